"""Friction on a disc: blocks in space that slide both ways, spin, and fall off."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rockslip import Scene, parse_scene, simulate
from solver.build.assembly import build, initial_state

BLOCK = {
    "width": 1.0,
    "height": 0.5,
    "thickness": 0.8,
    "mass": 1000.0,
    "young": 5e10,
    "poisson": 0.2,
    "cells": [2, 2, 2],
}


def scene(*, end: float, friction: float = 0.3, block: Any = None, **tables: Any) -> Scene:
    """The squat block, with steps of 1 ms."""
    content = {
        "dimension": 3,
        "block": [BLOCK | (block or {})],
        "contact": {"friction": friction},
        "damping": {"stiffness": 0.0},
        "time": {"end": end, "step": 1e-3},
    }
    return parse_scene(content | tables)


def test_a_block_thrown_spinning_comes_to_rest() -> None:
    """Its energy only falls, down to that of the block that stands."""
    moving = {"velocity": [0.5, 0.3, 0.0], "angular_velocity": [0.0, 0.0, 4.0]}
    result = simulate(scene(end=0.4, friction=0.8, block=moving))
    history, energy = result.history, result.summary["energy"]
    assert result.status == "completed"
    assert energy["largest_gain_fraction"] < 1e-9
    assert energy["ledger_error_fraction"] < 1e-9
    start, turned = history["energy.kinetic_J"][0], history["block.angle_z_rad"]
    polar = 1000.0 / 12 * (1.0**2 + 0.8**2)
    assert start == pytest.approx(0.5 * 1000 * 0.34 + 0.5 * polar * 16, rel=1e-6)
    # Single steps may store a little in what is out of balance (docs/method.md).
    assert np.diff(history["energy.total_J"]).max() < 1e-8 * start
    assert turned[-1] > 0.3
    assert np.ptp(turned[-50:]) < 1e-6
    assert np.ptp(history["block.slip_m"][-50:]) < 1e-6
    assert history["energy.kinetic_J"][-1] < 1e-6 * start
    assert history["energy.friction_J"][-1] == pytest.approx(start, rel=1e-2)


def test_every_point_is_held_back_along_its_own_slip() -> None:
    """While it spins the points slip in all directions: within 0.1 degree, at mu times pressure."""
    moving = {"velocity": [0.5, 0.3, 0.0], "angular_velocity": [0.0, 0.0, 4.0]}
    run = scene(end=0.1, friction=0.8, block=moving)
    assembly = build(run)
    state, _ = initial_state(run, assembly)
    seen = []
    for _ in range(40):
        before = state.contacts[0].anchor.copy()
        state, _ = assembly.stepper.advance(state, 1e-3)
        memory = state.contacts[0]
        slip, force = memory.anchor - before, memory.force
        sliding_on = (force[:, 0] > 1.0) & (np.linalg.norm(slip, axis=1) > 1e-5)
        slip, force = slip[sliding_on], force[sliding_on]
        size = np.linalg.norm(force[:, 1:], axis=1)
        assert size == pytest.approx(0.8 * force[:, 0], rel=1e-6)
        across = slip[:, 0] * force[:, 2] - slip[:, 1] * force[:, 1]
        along = -np.sum(slip * force[:, 1:], axis=1)
        assert np.rad2deg(np.abs(np.arctan2(across, along))).max() < 0.1
        seen += list(np.arctan2(slip[:, 1], slip[:, 0]))
    assert len(seen) > 200
    assert np.ptp(seen) > np.pi


@pytest.mark.slow
def test_a_block_slides_off_the_side_of_a_plate_and_falls(falls_on: None) -> None:
    """Across, along the second direction; in the end it is below the top, and nothing is gained."""
    plate = {"kind": "elastic", "width": 1.6, "thickness": 1.2, "height": 0.3, "density": 2500.0}
    elastic = {"young": 5e10, "poisson": 0.2, "cells": [3, 3, 1], "support": "bottom"}
    block = {"velocity": [0.0, 3.0, 0.0], "width": 0.8, "thickness": 0.4, "height": 0.4}
    result = simulate(scene(end=0.55, friction=0.1, block=block, foundation=plate | elastic))
    assert result.status == "completed", result.summary["reason"]
    assert result.history["block.centre_z_m"][-1] < 0.1
    assert result.history["block.centre_y_m"][-1] > 0.7
    assert result.history["block.angle_x_rad"].min() < -0.2
    assert result.summary["energy"]["largest_gain_fraction"] < 1e-6
    assert result.summary["energy"]["ledger_error_fraction"] < 1e-8
