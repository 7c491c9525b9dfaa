"""Pressure, friction and state of contact in files of fields, against the forces of the run."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rockslip import Result, parse_scene, simulate
from solver.fields.nodal_contact import NodeState

pyvista = pytest.importorskip("pyvista")

G, MASS, WIDTH, FRICTION = 9.81, 600.0, 0.6, 0.3


def leave(
    folder: Path,
    dimension: int = 2,
    friction: float = FRICTION,
    contact: dict[str, Any] | None = None,
    **block: Any,
) -> tuple[Result, Any]:
    """A run of a squat block for a moment, and its grid at the end."""
    cells = [4, 2] if dimension == 2 else [2, 2, 2]
    squat = {"width": WIDTH, "height": 0.4, "thickness": 0.5, "mass": MASS, "cells": cells}
    tables = {
        "dimension": dimension,
        "block": [squat | {"young": 3e10, "poisson": 0.2} | block],
        "contact": contact or {"friction": friction},
        "time": {"end": 0.02, "step": 1e-3},
    }
    result = simulate(parse_scene(tables), folder=folder)
    reader = pyvista.get_reader(str(folder / "fields.pvd"))
    reader.set_active_time_value(result.history["time_s"][-1])
    return result, reader.read()[0]


def areas(grid: Any, dimension: int, degree: int = 1) -> np.ndarray:
    """The area of the bottom that belongs to each node, m2: half or a quarter at its ends.

    Of degree 2, in the plane, by Simpson's rule.
    """
    if degree == 2:
        place, level = np.asarray(grid.points)[:, 0], np.asarray(grid.points)[:, 1]
        part = np.round((place - place.min()) / (np.ptp(place) / 8)).astype(int)
        rule = np.array([1, 4, 2, 4, 2, 4, 2, 4, 1]) / 24.0 * WIDTH * 0.5
        return np.where(np.isclose(level, level.min()), rule[part], 0.0)
    level = np.asarray(grid.points)[:, dimension - 1]
    area = np.where(np.isclose(level, level.min()), WIDTH * 0.5, 0.0)
    for axis, count in enumerate((4,) if dimension == 2 else (2, 2)):
        place = np.abs(np.asarray(grid.points)[:, axis])
        area /= np.where(np.isclose(place, place.max()), 2 * count, count)
    return area


@pytest.mark.serial
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_block_that_slides(tmp_path: Path, dimension: int) -> None:
    """Friction is mu times pressure against the way it goes; both add up to the forces."""
    velocity = [1.0, 0.0] if dimension == 2 else [0.6, 0.8, 0.0]
    result, grid = leave(tmp_path / "run", dimension, velocity=velocity)
    data, area = grid.point_data, areas(grid, dimension)
    pressure, friction, state = (
        np.asarray(data[name]) for name in ("contact_pressure", "friction", "contact_state")
    )
    normal = result.history["block.normal_force_N"][-1]
    assert pressure @ area == pytest.approx(normal, rel=1e-9)
    total = (friction.T @ area)[: dimension - 1]
    names = ["block.friction_force_N", "block.friction_force_second_N"][: dimension - 1]
    assert total == pytest.approx([result.history[name][-1] for name in names], rel=1e-6)
    way = np.array(velocity[: dimension - 1])
    np.testing.assert_allclose(total, -FRICTION * normal * way, rtol=1e-2)
    assert set(state[(area > 0) & (pressure > 0)]) == {NodeState.SLIPS}
    assert set(state[area == 0]) == {NodeState.AWAY}
    # All of it moves as friction leaves it.
    left = np.zeros(3)
    left[: dimension - 1] = (1 - FRICTION * G * result.history["time_s"][-1]) * way
    moved = data["velocity"] - left
    assert np.abs(moved).max() < 0.02


@pytest.mark.serial
def test_a_block_at_rest_and_one_on_its_corner(tmp_path: Path) -> None:
    """All of the bottom sticks, without friction; leaning, all but one corner is open."""
    _, grid = leave(tmp_path / "rest")
    state = np.asarray(grid.point_data["contact_state"])
    bottom = areas(grid, 2) > 0
    assert set(state[bottom]) == {NodeState.STICKS}
    weight = MASS * G
    assert np.abs(grid.point_data["friction"].T @ areas(grid, 2)).max() < 1e-6 * weight
    _, grid = leave(tmp_path / "lean", friction=3.0, tilt_deg=5.0)
    state = np.asarray(grid.point_data["contact_state"])[bottom]
    assert sorted(state) == [NodeState.OPEN] * 4 + [NodeState.STICKS]
    assert np.asarray(grid.points)[bottom][state == NodeState.STICKS, 0] == pytest.approx(0.3)


@pytest.mark.serial
def test_quadratic_tetrahedra_at_rest(tmp_path: Path) -> None:
    """Corners of their faces have no area of their own: they show the pressure beside them."""
    pytest.importorskip("gmsh")
    contact = {"points": "gauss", "friction": FRICTION}
    quadratic = {"cell": "tetrahedron", "degree": 2}
    _, grid = leave(tmp_path / "run", 3, contact=contact, **quadratic)
    pressure = np.asarray(grid.point_data["contact_pressure"])
    points = np.asarray(grid.points)
    bottom = np.isclose(points[:, 2], points[:, 2].min())
    mean = MASS * G / (WIDTH * 0.5)
    assert not pressure[~bottom].any()
    assert pressure[bottom].mean() == pytest.approx(mean, rel=0.25)
    assert 0.2 * mean < pressure[bottom].min() < pressure.max() < 4 * mean
    assert set(np.asarray(grid.point_data["contact_state"])[bottom]) == {NodeState.STICKS}


@pytest.mark.serial
@pytest.mark.parametrize(("dimension", "degree"), [(2, 1), (2, 2), (3, 1)])
def test_a_block_that_overhangs_what_carries_it(
    tmp_path: Path, dimension: int, degree: int
) -> None:
    """The fields also contain the forces of the carrier's edges, and those where edges cross."""
    cells = [4, 2] if dimension == 2 else [2, 2, 2]
    size = {
        "width": WIDTH,
        "height": 0.3,
        "thickness": 0.5,
        "mass": MASS,
        "cells": cells,
        "degree": degree,
    }
    velocity = [1.0, 0.0] if dimension == 2 else [0.8, 0.6, 0.0]
    below = {"name": "low", **size, "friction": 2.0}
    above = {"name": "up", "on": "low", **size, "friction": 0.2, "velocity": velocity}
    tables = {
        "dimension": dimension,
        "block": [each | {"young": 3e9, "poisson": 0.2} for each in (below, above)],
        "time": {"end": 0.1, "step": 1e-3},
        "output": {"every": 0.05},
    }
    history = simulate(parse_scene(tables), folder=tmp_path / "run").history
    reader = pyvista.get_reader(str(tmp_path / "run" / "fields.pvd"))
    for time in (0.05, 0.1):
        reader.set_active_time_value(time)
        row = int(np.argmin(np.abs(history["time_s"] - time)))
        assert history["up.slip_m"][row] > 0.03
        grid = reader.read()[1]
        data, area = grid.point_data, areas(grid, dimension, degree)
        pressure, friction, state = (
            np.asarray(data[name]) for name in ("contact_pressure", "friction", "contact_state")
        )
        assert pressure @ area == pytest.approx(history["up.normal_force_N"][row], rel=1e-3)
        drag = history["up.friction_force_N"][row]
        assert (friction.T @ area)[0] == pytest.approx(drag, rel=1e-2)
        assert set(state[pressure > 0]) == {NodeState.SLIPS}
