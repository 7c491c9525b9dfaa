"""Samples of the ground's acceleration and steps that do not meet them: no impulse goes missing."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rockslip import Result, Scene, parse_scene, simulate
from solver.excitation.motion import read_ground
from solver.reference.sliding import sliding

SAMPLES, DT = 60, 0.01
WHOLE = 0.8
"""End of the runs, s: what the inertia forces carry over has faded by then."""


@pytest.fixture
def noise(tmp_path: Path) -> Path:
    """White noise, the worst that can happen to steps that skip samples."""
    values = np.random.default_rng(4).normal(size=SAMPLES)
    file = tmp_path / "noise.txt"
    file.write_text("units: m/s2\n" + "".join(f"{value:.12g}\n" for value in values))
    return file


def scene(noise: Path, step: float, model: str, dimension: int = 2, **others: Any) -> Scene:
    block = {"name": "block", "width": 1.0, "height": 0.2, "density": 2000.0, "model": model}
    if model == "elastic":
        block |= {"young": 1e8, "poisson": 0.2, "cells": [2, 1]}
    motion = {"kind": "record", "file": str(noise), "dt": DT}
    content = {
        "dimension": dimension,
        "block": [block],
        "contact": {"friction": 0.0},
        "motion": motion,
        "damping": {"stiffness": 0.0},
        "time": {"end": WHOLE, "step": step},
    }
    return parse_scene(content | others)


def last_speed(result: Result, column: str) -> float:
    """Of a motion that is even in the end, m/s."""
    history = result.history
    return float(np.diff(history[column][-2:])[0] / np.diff(history["time_s"][-2:])[0])


CASES = [
    (model, dimension, step)
    for model, dimension in (("rigid", 2), ("rigid", 3), ("elastic", 2))
    for step in (0.007, 0.0237)
]


@pytest.mark.parametrize(("model", "dimension", "step"), CASES)
def test_a_block_without_friction_stays_behind(
    noise: Path, model: str, dimension: int, step: float
) -> None:
    """The ground gains the velocity v_g, so the block loses it relative to the ground.

    It is fast enough not to turn round: steps that are cut there leave a little behind.
    """
    run = scene(noise, step, model, dimension)
    start = (1.0, 0.0, 0.0)[:dimension]
    run = replace(run, blocks=(replace(run.blocks[0], velocity=start),))
    motion = read_ground(run)
    end = float(motion.velocity(np.array([WHOLE]))[0, 0])
    assert abs(end) > 0.04
    result = simulate(run)
    assert result.status == "completed"
    lost = 1 - last_speed(result, "block.centre_x_m")
    assert lost == pytest.approx(end, rel=1e-4 if step > 0.01 else 1e-7)
    assert result.summary["energy"]["ledger_error_fraction"] < 1e-10


def test_other_directions(noise: Path) -> None:
    """Along y, and along x with a start between the steps."""
    record = {"kind": "record", "file": str(noise), "dt": DT, "start": 0.0213}
    run = scene(noise, 0.007, "rigid", 3, motion=record | {"second": record | {"scale": -0.5}})
    result = simulate(run)
    motion = read_ground(run)
    along, across, _ = motion.velocity(np.array([WHOLE]))[0]
    assert last_speed(result, "block.slip_m") == pytest.approx(-along, rel=1e-6)
    assert last_speed(result, "block.slip_second_m") == pytest.approx(-across, rel=1e-6)
    assert across == pytest.approx(-along / 2, rel=1e-12)


def test_vertical_impulses_reach_the_floor(noise: Path) -> None:
    """The forces of the floor add up to weight and impulse of the ground, whatever the step."""
    record = {"kind": "record", "file": str(noise), "dt": DT, "scale": 0.5}
    run = scene(noise, 0.0237, "rigid", motion={"kind": "none", "vertical": record})
    history = simulate(run).history
    motion = read_ground(run)
    gained = float(motion.velocity(np.array([WHOLE]))[0, 1])
    pushed = float(history["block.normal_force_N"][1:] @ np.diff(history["time_s"]))
    assert pushed == pytest.approx(400.0 * (9.81 * WHOLE + gained), rel=1e-7)


@pytest.mark.parametrize("model", ["rigid", "elastic"])
def test_a_step_that_divides_and_one_that_does_not_agree(noise: Path, model: str) -> None:
    """Sliding on a platform, against the reference: steps of a third and of 0.4 of a sample."""
    platform = {"kind": "oscillator", "mass_ratio": 2.0, "period": 0.5, "damping_ratio": 0.05}
    others = {"contact": {"friction": 0.03}, "foundation": platform}
    for step, error in ((DT / 3, 1e-3), (0.004, 1e-3)):
        run = scene(noise, step, model, **others)
        motion = read_ground(run)
        assert motion is not None and motion.parts[0] is not None
        history = simulate(run).history
        exact = sliding(
            platform=run.platform(),
            mass=run.carried_mass,
            friction=0.03,
            gravity=9.81,
            acceleration=motion.parts[0].acceleration,
            end=WHOLE,
            step=1e-3,
        )
        drift = np.interp(history["time_s"], exact.time, exact.drift)
        largest = np.abs(drift).max()
        away = np.abs(history["platform.drift_m"] - drift).max() / largest
        assert away < error


def test_the_ground_at_many_times_is_that_at_each(noise: Path) -> None:
    """And its mean over steps gives the whole impulse."""
    run = scene(noise, 0.007, "rigid", motion={"kind": "rectangular", "amplitude_g": 0.1,
                "duration": 0.3, "start": 0.05, "vertical": {"kind": "record", "file": str(noise),
                "dt": DT}})  # fmt: skip
    motion = read_ground(run)
    times = 0.007 * np.arange(51)
    at, mean = motion.acceleration(times), motion.means(times)
    for k in range(50):
        np.testing.assert_allclose(motion.acceleration(0.007 * k), at[k], atol=1e-14)
        np.testing.assert_allclose(motion.mean(0.007 * k, 0.007), mean[k], atol=1e-12)
    assert mean[:, 0].sum() * 0.007 == pytest.approx(0.3 * 0.981, rel=1e-12)


@pytest.mark.parametrize("model", ["elastic", "rigid"])
@pytest.mark.parametrize("rho", [0.0, 0.8])
def test_a_ground_that_jumps_is_followed_at_once(noise: Path, rho: float, model: str) -> None:
    """Within a step: its whole impulse, and no energy lost or gained in time stepping."""
    pulse = {"kind": "rectangular", "amplitude_g": 1.0, "duration": 0.1053, "start": 0.0233}
    timing = {"end": 0.15, "step": 0.01, "rho_inf": rho}
    result = simulate(scene(noise, 0.01, model, motion=pulse, time=timing))
    history, energy = result.history, result.summary["energy"]
    speed = np.diff(history["block.centre_x_m"]) / 0.01
    assert speed[-2:] == pytest.approx(-0.1053 * 9.81, rel=1e-9)
    assert np.abs(history["energy.numerical_J"]).max() < 1e-8 * energy["scale_J"]
    assert energy["largest_gain_fraction"] < 1e-9
