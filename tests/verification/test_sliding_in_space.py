"""Friction on a disc: blocks in space that slide both ways, spin, and fall off."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rockslip import Scene, parse_scene, simulate
from solver.build.assembly import build, initial_state
from solver.excitation.kinds import base_motion
from solver.reference.sliding import sliding

BLOCK = {
    "width": 1.0,
    "height": 0.5,
    "thickness": 0.8,
    "mass": 1000.0,
    "young": 5e10,
    "poisson": 0.2,
    "cells": [2, 2, 2],
}
AZIMUTH = np.deg2rad(30.0)


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


@pytest.mark.parametrize("cell", ["hexahedron", "tetrahedron"])
def test_a_block_stops_on_a_straight_line(cell: str) -> None:
    """From 1 m/s at 30 degrees: after v^2/(2 mu g), and friction opposes the velocity."""
    speed, friction = 1.0, 0.3
    velocity = [speed * np.cos(AZIMUTH), speed * np.sin(AZIMUTH), 0.0]
    result = simulate(scene(end=0.4, block={"velocity": velocity, "cell": cell}))
    history = result.history
    along, across = history["block.slip_m"], history["block.slip_second_m"]
    stop = speed**2 / (2 * friction * 9.81)
    assert np.hypot(along[-1], across[-1]) == pytest.approx(stop, rel=3e-3)
    slides = slice(5, int(0.97 * speed / (friction * 9.81) / 1e-3))
    forces = history["block.friction_force_N"], history["block.friction_force_second_N"]
    direction = np.rad2deg(np.arctan2(-forces[1], -forces[0]))[slides]
    assert np.abs(direction - 30.0).max() < 0.1
    size = np.hypot(*forces)[slides]
    assert size == pytest.approx(friction * history["block.normal_force_N"][slides], rel=1e-6)
    assert np.abs(history["block.angle_z_rad"]).max() < 1e-6
    assert result.summary["energy"]["largest_gain_fraction"] < 1e-9


def test_shaken_at_an_angle_it_slides_as_in_the_plane() -> None:
    """Two proportional motions: a disc knows no directions, a pyramid would."""
    parts = {
        name: {"kind": "sine", "amplitude_g": 0.4 * part, "period": 0.5}
        for name, part in (("first", float(np.cos(AZIMUTH))), ("second", float(np.sin(AZIMUTH))))
    }
    run = scene(end=0.3, friction=0.1, motion=parts["first"] | {"second": parts["second"]})
    history = simulate(run).history
    shaken = base_motion(run.motion, run.time.end)
    assert shaken is not None
    exact = sliding(
        acceleration=lambda t: shaken.acceleration(t) / np.cos(AZIMUTH),
        friction=0.1,
        gravity=9.81,
        end=0.3,
        step=1e-3,
    )
    slip = np.interp(history["time_s"], exact.time, exact.slip)
    scale = 3e-3 * np.abs(slip).max()
    assert history["block.slip_m"] == pytest.approx(slip * np.cos(AZIMUTH), abs=scale)
    assert history["block.slip_second_m"] == pytest.approx(slip * np.sin(AZIMUTH), abs=scale)


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
