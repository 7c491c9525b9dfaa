"""Stacks of rigid blocks: balances, one block made of two, blocks that tip or fall off."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from rockslip import Result, Scene, parse_scene, simulate
from solver.excitation.motion import read_ground
from solver.rigid.plane.system import PlaneSystem

G = 9.81
DENSITY = 2000.0

Size = tuple[float, float]
TWO: list[Size] = [(0.4, 0.6), (0.35, 0.5)]
EQUAL: list[Size] = [(0.4, 0.6), (0.4, 0.6)]
THREE: list[Size] = [(0.4, 0.6), (0.3, 0.5), (0.3, 0.4)]
WIDE: list[Size] = [(0.4, 0.4), (0.6, 0.3)]


def scene(
    sizes: list[Size], friction: float, end: float, step: float = 1e-3, **tables: Any
) -> Scene:
    """Blocks on one another, shaken with 2 Hz unless `motion` says otherwise."""
    offsets = tables.pop("offsets", [0.0] * len(sizes))
    changes = tables.pop("changes", [{}] * len(sizes))
    blocks = [
        {
            "name": f"block{i}",
            "on": f"block{i - 1}" if i else "foundation",
            "width": width,
            "height": height,
            "density": DENSITY,
            "model": "rigid",
            "offset": offset,
        }
        | change
        for i, ((width, height), offset, change) in enumerate(
            zip(sizes, offsets, changes, strict=True)
        )
    ]
    return parse_scene(
        {
            "block": blocks[::-1],  # any order
            "contact": {"friction": friction},
            "time": {"end": end, "step": step},
        }
        | tables
    )


def sine(amplitude: float) -> dict[str, Any]:
    """A motion of 2 Hz, amplitude in g, of six cycles."""
    return {"kind": "sine", "amplitude_g": amplitude, "period": 0.5, "cycles": 6}


def checked(result: Result) -> Result:
    """The run completed, its energy did not rise, its ledger closes."""
    assert result.status == "completed"
    assert result.summary["energy"]["largest_gain_fraction"] < 1e-9
    assert result.summary["energy"]["ledger_error_fraction"] < 1e-10
    return result


@pytest.mark.parametrize("friction", [0.15, 0.6, 10.0])
@pytest.mark.parametrize(
    ("sizes", "offsets"),
    [(TWO, [0, 0]), (EQUAL, [0, 0]), (THREE, [0, 0.02, -0.03]), (WIDE, [0, 0.05])],
    ids=["two", "equal", "three", "wide"],
)
def test_energy_does_not_rise(sizes: list[Size], offsets: list[float], friction: float) -> None:
    """Rocking, sliding and both, under 0.5 g; on average the weight is where it should be."""
    result = checked(simulate(scene(sizes, friction, 4.0, offsets=offsets, motion=sine(0.5))))
    history = result.history
    weights = [DENSITY * width * height * G for width, height in sizes]
    for i in range(len(sizes)):
        force = history[f"block{i}.normal_force_N"].mean()
        assert force == pytest.approx(sum(weights[i:]), rel=0.02)
        assert history[f"block{i}.penetration_m"].max() < 1e-9


def test_contact_forces_balance_momentum() -> None:
    """Step by step: m dv/dt = weight + inertia of the ground + what the points carry."""
    step, count = 1e-3, 2000
    run = scene(THREE, 0.6, 2.0, motion=sine(0.5), offsets=[0, 0.02, -0.03])
    system = PlaneSystem.from_scene(run)
    motion = read_ground(run)
    ground = np.array([motion.acceleration(step * k) for k in range(count + 1)])
    mass = np.array([block.shape.mass for block in run.blocks])
    momentum = np.zeros((count + 1, 2))
    rows = []
    for k in range(count):
        rows.append(system.advance(1, step, ground[k : k + 2]).rows[0])
        momentum[k + 1] = mass @ np.array([system.velocity(b) for b in range(len(mass))])
    column = dict(zip(system.columns, np.array(rows).T, strict=True))
    weight = mass.sum() * G
    vertical = np.diff(momentum[:, 1]) / step
    # The lowest block stands on the floor; the others pass their forces on to it.
    excess = vertical + weight - column["block0.normal_force_N"]
    assert np.abs(excess).max() < 1e-10 * weight
    # Horizontally the ground counts by its mean over the step, cut at impacts or not.
    mean = 0.5 * (ground[:-1, 0] + ground[1:, 0])
    excess = np.diff(momentum[:, 0]) / step + mass.sum() * mean - column["block0.friction_force_N"]
    assert np.abs(excess).max() < 1e-10 * weight


def test_a_glued_stack_is_one_block() -> None:
    """mu = 100 on a platform, too weak a motion to rock: the platform does not notice the joint."""
    platform = {"kind": "oscillator", "mass_ratio": 2.0, "period": 0.5, "damping_ratio": 0.05}
    tables = {"foundation": platform, "motion": sine(0.1)}
    two = checked(simulate(scene([(0.5, 0.5), (0.5, 0.5)], 100.0, 3.0, **tables))).history
    one = checked(simulate(scene([(0.5, 1.0)], 100.0, 3.0, **tables))).history
    for name, size in (("platform.drift_m", 0.05), ("block0.friction_force_N", 1e3)):
        assert np.abs(one[name]).max() > 0.1 * size
        assert np.abs(two[name] - one[name]).max() < 1e-10 * size
    assert np.abs(two["block0.normal_force_N"] - one["block0.normal_force_N"]).max() < 1e-6


def test_a_glued_stack_rocks_as_one_block() -> None:
    """Released at 3 degrees: the joint carries moments, the upper block stands on all of it."""
    tilted = [{"tilt_deg": 3.0}, {}]
    two = simulate(scene([(0.25, 0.5), (0.25, 0.5)], 100.0, 1.5, changes=tilted))
    one = simulate(scene([(0.25, 1.0)], 100.0, 1.5, changes=[{"tilt_deg": 3.0}]))
    first = one.history["time_s"] < 0.5
    for name in ("block0.angle_rad", "block1.angle_rad"):
        difference = two.history[name] - one.history["block0.angle_rad"]
        assert np.abs(difference[first]).max() < 1e-7
        assert np.abs(difference).max() < 1e-4
    checked(two)


def test_a_block_slides_off_its_carrier_and_comes_to_rest_on_the_floor() -> None:
    """It leaves with 2 m/s, tips over the edge, and lies on the floor in the end."""
    thrown = [{}, {"velocity": [2.0, 0.0], "friction": 0.2}]
    sizes = [(0.4, 0.6), (0.2, 0.2)]
    result = checked(simulate(scene(sizes, 0.6, 3.0, changes=thrown, offsets=[0, 0.1])))
    history = result.history
    weight = DENSITY * 0.04 * G
    assert history["block1.centre_x_m"][-1] > 1.0
    assert history["block1.centre_y_m"][-1] == pytest.approx(0.1, abs=1e-8)
    assert history["block1.normal_force_N"][-1] == pytest.approx(weight, rel=1e-9)
    assert history["block0.normal_force_N"][-1] == pytest.approx(DENSITY * 0.24 * G, rel=1e-9)
    quarter_turns = history["block1.angle_rad"][-1] / (math.pi / 2)
    assert quarter_turns == pytest.approx(round(quarter_turns), abs=1e-7)
    assert result.summary["blocks"]["block1"]["mode"] == "fell"


@pytest.mark.parametrize(("offset", "tips"), [(0.19, False), (0.21, True)])
def test_an_overhang_tips_where_its_centre_leaves_the_carrier(offset: float, tips: bool) -> None:
    """A carrier of half width 0.2 m holds its load up to there."""
    result = simulate(scene([(0.4, 0.6), (0.4, 0.2)], 0.6, 1.0, offsets=[0, offset]))
    angle = result.history["block1.angle_rad"][-1]
    assert (angle > 1.0) if tips else (abs(angle) < 1e-9)
    checked(result)


def test_blocks_of_other_friction() -> None:
    """Each pair has its own: the upper block slides on the lower one, which stays."""
    slippery = [{}, {"friction": 0.1}]
    result = checked(
        simulate(scene([(0.6, 0.3), (0.4, 0.2)], 0.6, 3.0, changes=slippery, motion=sine(0.25)))
    )
    assert np.abs(result.history["block1.slip_m"]).max() > 0.01
    assert np.abs(result.history["block0.slip_m"]).max() < 1e-10
    ratio = np.abs(result.history["block1.friction_force_N"])
    assert ratio.max() <= 0.1 * DENSITY * 0.08 * G * (1 + 1e-9)
