"""Base shear of a platform on a spring and dashpot: what balances all masses, in every engine."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from rockslip import Scene, parse_scene, simulate
from solver.build.assembly import build, initial_state
from solver.excitation.motion import read_ground
from solver.history.history import scene_columns
from solver.rigid.system import RigidSystem
from solver.run.observer import Observer
from solver.types import Array

BLOCKS: list[dict[str, Any]] = [
    {"name": "tall", "width": 0.25, "height": 1.0, "mass": 500.0, "friction": 0.6},
    {"name": "flat", "width": 0.5, "height": 0.2, "mass": 300.0, "friction": 0.1, "offset": 2.0},
]
"""One that rocks, and lands within steps, and one that slides."""

PLATFORM: dict[str, Any] = {
    "kind": "oscillator",
    "mass": 400.0,
    "period": 0.5,
    "damping_ratio": 0.05,
}

STEP = 2e-3


def scene(dimension: int, model: str, **more: Any) -> Scene:
    """Both blocks on a platform under a pulse, along y, too."""
    blocks = [{"model": model, "thickness": 0.6} | block for block in BLOCKS]
    if model == "elastic":
        small = {"young": 1e9, "poisson": 0.2, "cells": [2, 4, 2][:dimension]}
        blocks = [block | small for block in blocks]
    pulse = {"kind": "one_sine", "amplitude_g": 0.6, "duration": 0.4}
    motion = pulse | ({"second": pulse | {"amplitude_g": -0.4}} if dimension == 3 else {})
    tables = {"dimension": dimension, "block": blocks, "foundation": PLATFORM, "motion": motion}
    return parse_scene(tables | {"time": {"end": 0.5, "step": STEP}} | more)


def rigid_steps(case: Scene) -> Iterator[tuple[Array, Array, Array]]:
    """Of each step the base shear, the momentum that all masses gained, the mean of the ground."""
    system: Any = RigidSystem(case)
    across = case.dimension - 1
    masses = [block.shape.mass for block in case.blocks]

    def momentum() -> Array:
        moving = [m * system.velocity(b)[:across] for b, m in enumerate(masses)]
        return np.asarray(case.platform().mass * system.drift_velocity + sum(moving))

    names = [f"foundation.base_shear{way}_N" for way in ("", "_second")[:across]]
    columns, ground = [system.columns.index(name) for name in names], read_ground(case)
    for n in range(round(case.time.end / STEP)):
        ends, before = STEP * np.array([n, n + 1]), momentum()
        mean = ground.means(ends)
        (row,) = system.advance(1, STEP, ground.acceleration(ends), mean=mean).rows
        yield row[columns], momentum() - before, mean[0, :across]


def meshed_steps(case: Scene) -> Iterator[tuple[Array, Array, Array]]:
    """The same of bodies of which some are meshed."""
    assembly = build(case)
    stepper = assembly.stepper
    state, exchange = initial_state(case, assembly)
    names, across = list(scene_columns(case)), case.dimension - 1
    observer = Observer(assembly, state, names)
    shears = [name for name in names if name.startswith("foundation.")]
    assert shears == [f"foundation.base_shear{way}_N" for way in ("", "_second")[:across]]
    for _ in range(round(case.time.end / STEP)):
        new, exchange = stepper.advance(state, STEP)
        row = observer.row(new, exchange, STEP)
        gained = stepper.system.directional_mass @ (new.v - state.v)
        mean = stepper.mean_base(state.time, STEP)
        yield np.array([row[names.index(name)] for name in shears]), gained[:across], mean[:across]
        state = new


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("model", ["rigid", "elastic"])
def test_it_balances_all_masses_in_each_step(dimension: int, model: str) -> None:
    """Less the sum of all masses times absolute accelerations, to 1e-10 of the largest.

    Impacts within the steps are in it, the velocity solve, slip and an incline.
    """
    case = scene(dimension, model, gravity_tilt_deg=2.0)
    steps = rigid_steps(case) if model == "rigid" else meshed_steps(case)
    mass = case.platform().mass + case.carried_mass
    along = np.array(case.gravity_vector[:-1])
    found = [(s, -(p / STEP + mass * (mean - along))) for s, p, mean in steps]
    shear, exact = (np.array([pair[k] for pair in found]) for k in (0, 1))
    largest = np.abs(exact).max(axis=0)
    assert (largest > 0.05 * mass * case.gravity).all()
    assert (np.abs(shear - exact).max(axis=0) < 1e-10 * largest).all()


def test_it_is_the_force_of_spring_and_dashpot() -> None:
    """k u + c v at the middle of the step, and at rest on an incline the weight along it."""
    case = scene(2, "rigid", time={"end": 0.5, "step": STEP, "rho_inf": 1.0, "damped_steps": 0})
    result = simulate(case)
    found, platform = result.history, case.platform()
    force = platform.stiffness * found["platform.drift_m"]
    force += platform.damping * found["platform.velocity_m_s"]
    shear = found["foundation.base_shear_N"]
    off = shear[1:] - (force[1:] + force[:-1]) / 2
    assert np.abs(off).max() < 2e-2 * np.abs(force).max()
    assert np.sqrt(np.mean(off**2)) < 2e-3 * np.abs(force).max()
    assert result.summary["platform"]["peak_base_shear_N"] == np.abs(shear).max()
    still = scene(2, "rigid", gravity_tilt_deg=2.0, motion={"kind": "none"})
    first = simulate(still).history["foundation.base_shear_N"][0]
    weight = 9.81 * (platform.mass + case.carried_mass)
    assert first == pytest.approx(weight * math.sin(math.radians(2.0)), rel=1e-6)


def test_ground_that_does_not_give_way_has_no_base_shear() -> None:
    """Nor has a plate that is held."""
    for kind in ({"kind": "rigid"}, {"kind": "elastic", "width": 8.0, "height": 0.2,
                 "density": 2400.0, "young": 3e10, "poisson": 0.2}):  # fmt: skip
        case = scene(2, "rigid", foundation=kind)
        assert not [name for name in scene_columns(case) if name.startswith("foundation.")]
