"""Columns of rigid drums in space: every step has a solution, and friction only takes energy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks import random_columns
from rockslip import Scene, parse_scene
from solver.excitation.motion import read_ground
from solver.rigid.plane.system import PlaneSystem
from solver.rigid.space.system import SpaceSystem

Array = NDArray[np.float64]


def drums(count: int, end: float, step: float, **changes: Any) -> dict[str, Any]:
    """Drums of stone on each other that a Ricker wavelet rocks; they come to rest after 2 s."""
    shape = {"model": "rigid", "width": 0.5, "thickness": 0.5, "height": 0.414, "density": 2600.0}
    blocks = [{"name": f"drum{k}", **shape} for k in range(count)]
    for k in range(1, count):
        blocks[k]["on"] = f"drum{k - 1}"
    return {
        "dimension": 3,
        "block": blocks,
        "contact": {"friction": 0.6},
        "motion": {"kind": "ricker", "amplitude_g": 0.57, "frequency": 1.96},
        "time": {"end": end, "step": step},
    } | changes


def run(scene: Scene) -> tuple[str | None, dict[str, Array]]:
    """Failure and history of a rigid scene."""
    engine = SpaceSystem if scene.dimension == 3 else PlaneSystem
    system, step = engine.from_scene(scene), scene.time.step
    count, motion = round(scene.time.end / step), read_ground(scene)
    ground = mean = None
    if motion is not None:
        times = np.arange(count + 1) * step
        ground, mean = motion.accelerations(times), motion.means(times)
    outcome = system.advance(count, step, ground, mean=mean)
    return outcome.failure, dict(zip(system.columns, outcome.rows.T, strict=True))


def energy_scale(history: dict[str, Array]) -> float:
    """Energy that went to and fro, J."""
    moved = np.abs(np.diff(history["energy.input_J"])).sum()
    return float(moved + np.ptp(history["energy.gravity_J"]) + history["energy.kinetic_J"].max())


def test_drums_rock_to_rest() -> None:
    """A step is cut at an impact; what points hold of each other stays what it was."""
    failure, history = run(parse_scene(drums(3, 2.2, 1e-3)))
    assert failure is None
    scale = energy_scale(history)
    assert np.abs(history["energy.ledger_error_J"]).max() < 1e-8 * scale
    assert np.diff(history["energy.friction_J"]).min() > -1e-12 * scale
    assert np.ptp(history["drum2.centre_x_m"][-50:]) < 1e-9


@pytest.mark.parametrize("seed", [1, 2, 4])
def test_random_columns(seed: int) -> None:
    """`benchmarks/random_columns.py` has a hundred; these failed before."""
    found = random_columns.run(parse_scene(random_columns.column(seed)), seed)
    assert found["failure"] is None
    assert found["ledger"] < 1e-8
    assert found["friction"] > -1e-12


@pytest.mark.parametrize("dimension", [2, 3])
def test_friction_of_a_stack_that_sticks_never_gives_energy_back(dimension: int) -> None:
    scene = drums(3, 1.5, 1e-3, dimension=dimension, contact={"friction": 0.9})
    failure, history = run(parse_scene(scene))
    assert failure is None
    scale = energy_scale(history)
    assert np.diff(history["energy.friction_J"]).min() > -1e-12 * scale
    assert np.abs(history["energy.ledger_error_J"]).max() < 1e-8 * scale
    assert history["energy.contact_J"][-1] > 1e-3 * scale
