"""Gaps and penetration of blocks on blocks mean the same in every engine."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from rockslip import Scene, parse_scene, simulate
from solver.rigid.system import RigidSystem

Array = NDArray[np.float64]

WIDTH, HEIGHT = 0.4, 0.3
"""Of the upper block, m."""

CARRIER = 0.5
"""Height of the lower block, m."""

PLATE = {"kind": "elastic", "width": 6.0, "height": 0.2, "density": 2400.0}
"""All of it held: a scene with it is run by the meshed engine."""


def scene(engine: str, end: float = 0.5, **upper: Any) -> Scene:
    """A block on another one; `upper`: further keys of the upper one."""
    common = {"density": 2400.0, "model": "rigid", "thickness": 0.4}
    lower = common | {"name": "lower", "width": 1.0, "height": CARRIER}
    top = common | {"name": "top", "on": "lower", "width": WIDTH, "height": HEIGHT} | upper
    tables: dict[str, Any] = {
        "dimension": 3 if engine == "space" else 2,
        "block": [lower, top],
        "contact": {"friction": 0.3},
        "damping": {"stiffness": 0.0},
        "time": {"end": end, "step": 1e-3},
        "output": {"fields": "none"},
    }
    if engine == "meshed":
        tables["foundation"] = PLATE | {"young": 1e10, "poisson": 0.2, "cells": [4, 1]}
    return parse_scene(tables)


def first_row(engine: str, depth: float, **upper: Any) -> dict[str, float]:
    """The first row where the upper block starts `depth` further down than where it belongs."""
    given = scene(engine, **upper)
    down = np.zeros(given.dimension)
    down[-1] = depth
    poses, name = given.poses(), given.blocks[1].name
    system = RigidSystem(
        given, poses | {name: replace(poses[name], place=poses[name].place - down)}
    )
    row = system.row(1e-3)
    return dict(zip(system.columns, row, strict=True))


def meshed_first_row(depth: float, **upper: Any) -> dict[str, float]:
    """The same in the meshed engine."""
    from solver.build.assembly import build, initial_state
    from solver.history.history import scene_columns
    from solver.run.observer import Observer
    from solver.stepping.state import Exchange

    given = scene("meshed", **upper)
    assembly = build(given)
    u = initial_state(given, assembly)[0].u.copy()
    u[assembly.stepper.system.slices[1].start + 1] -= depth
    state = assembly.stepper.start(u, np.zeros_like(u))
    names = scene_columns(given)
    row = Observer(assembly, state, names).row(state, Exchange(), 1e-3)
    return dict(zip(names, row, strict=True))


ENGINES = ["plane", "space", "meshed"]


def row_of(engine: str, depth: float, **upper: Any) -> dict[str, float]:
    """The first row of an engine."""
    if engine == "meshed":
        return meshed_first_row(depth, **upper)
    return first_row(engine, depth, **upper)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_block_that_is_in_its_carrier(engine: str) -> None:
    """Flat: as deep as its gaps say; the lower block is in nothing."""
    row = row_of(engine, 1e-3)
    gaps = [value for name, value in row.items() if name.startswith("top.gap")]
    assert gaps == pytest.approx([-1e-3] * len(gaps), abs=1e-12)
    assert row["top.penetration_m"] == pytest.approx(1e-3, abs=1e-12)
    assert row["lower.penetration_m"] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("engine", ENGINES)
def test_the_carrier_that_is_in_the_block(engine: str) -> None:
    """Its edge is in the bottom of a block that leans over it: deeper than any corner of that."""
    lean, depth = math.radians(10.0), 2e-3
    # The pivot, at x = 0.62, is beyond the edge at 0.5; the bottom rises from it to the left.
    clear = (0.42 + WIDTH / 2 - 0.5) * math.tan(lean)
    row = row_of(engine, clear - depth, tilt_deg=10.0, offset=0.42)
    assert row["top.penetration_m"] == pytest.approx(0.0, abs=1e-12)
    row = row_of(engine, clear + depth, tilt_deg=10.0, offset=0.42)
    assert row["top.penetration_m"] == pytest.approx(depth * math.cos(lean), rel=1e-6)


def corner_heights(history: Any, spatial: bool) -> tuple[Array, Array, Array]:
    """Heights of the bottom corners of the upper block over level 0 and over the carrier's top.

    Returns:
        Both, (rows, 2), and whether the centre is above the plane of that top.
    """
    up = "z" if spatial else "y"
    centre = np.column_stack([history["top.centre_x_m"], history[f"top.centre_{up}_m"]])
    below = np.column_stack([history["lower.centre_x_m"], history[f"lower.centre_{up}_m"]])
    angle, turned = history["top.angle_rad"], history["lower.angle_rad"]
    normal = np.column_stack([np.sin(turned), np.cos(turned)])
    heights = []
    for side in (-1.0, 1.0):
        x, y = side * WIDTH / 2, -HEIGHT / 2
        arm = np.column_stack(
            [np.cos(angle) * x + np.sin(angle) * y, np.cos(angle) * y - np.sin(angle) * x]
        )
        over = ((centre + arm - below) * normal).sum(axis=1) - CARRIER / 2
        heights.append(((centre + arm)[:, 1], over))
    carried = ((centre - below) * normal).sum(axis=1) > CARRIER / 2
    level, over = (np.column_stack(values) for values in zip(*heights, strict=True))
    return level, over, carried


@pytest.mark.parametrize("engine", ENGINES)
def test_gaps_of_a_block_that_falls_off_its_carrier(engine: str, falls_on: None) -> None:
    """Over the plane of the carrier's top, then, with the centre below that plane, over level 0."""
    velocity = [2.0, 0.0, 0.0] if engine == "space" else [2.0, 0.0]
    history = simulate(scene(engine, offset=0.4, velocity=velocity)).history
    spatial = engine == "space"
    level, over, carried = corner_heights(history, spatial)
    assert carried[0] and not carried[-1]
    names = ["gap_1_m", "gap_2_m"] if spatial else ["gap_left_m", "gap_right_m"]
    gaps = np.column_stack([history[f"top.{name}"] for name in names])
    expected = np.where(carried[:, None], over, level)
    np.testing.assert_allclose(gaps, expected, atol=1e-9)
