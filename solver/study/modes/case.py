"""One case of the map of modes: one engine, one slenderness, one acceleration, all frictions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from solver.errors import SceneError, Statement
from solver.scene import Scene
from solver.study.modes.onset import WINDOW, ramped_onset, sudden_onset, unit
from solver.study.standing import Tables, is_elastic, variant

ENGINES = ("rigid", "elastic")

FRICTIONS, ACCELERATIONS = (0.25, 2.45), (0.25, 4.0)
"""Ends of the grid of frictions and of accelerations A, both over B/H."""

FEWEST_CELLS = 4
"""Cells along each side of an elastic block, at least."""

RAMPED_STEPS = 400
"""Steps of a rigid block that is run beside an elastic one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ModesCase:
    """Case of the study, as one process is given it.

    Attributes:
        name: Its own in the study; also the name of its file.
        engine: "rigid" or "elastic".
        ratio: H/B.
        acceleration: A = a_g/g.
        scenes: One for each coefficient of friction.
        frictions: Their coefficients.
    """

    name: str
    engine: str
    ratio: float
    acceleration: float
    scenes: tuple[Scene, ...]
    frictions: tuple[float, ...]


def run_case(case: ModesCase) -> dict[str, Any]:
    """Run a case on one process; its row, with a list of points."""
    onset = sudden_onset if case.engine == "rigid" else ramped_onset
    points = []
    for friction, scene in zip(case.frictions, case.scenes, strict=True):
        found, shape = onset(scene, case.acceleration), scene.blocks[0].shape
        mode = found.mode(shape, case.acceleration, scene.gravity)
        point = {"friction": friction, "mode": mode, "turn": found.turn, "slip": found.slip}
        if case.engine == "elastic":
            rigid = ramped_onset(rigid_of(scene), case.acceleration)
            point |= {"rigid_turn": rigid.turn, "rigid_slip": rigid.slip}
        points.append(point)
    return {
        "status": "completed",
        "engine": case.engine,
        "ratio": case.ratio,
        "width": case.scenes[0].blocks[0].width,
        "acceleration": case.acceleration,
        "points": points,
    }


def rigid_of(scene: Scene) -> Scene:
    """The scene with its block made rigid, and steps of a rigid block."""
    end = scene.time.end
    return variant(scene.to_dict(), model="rigid", time={"end": end, "step": end / RAMPED_STEPS})


def cases_of(
    tables: Tables, ratios: Sequence[float], points: int, engines: Sequence[str]
) -> list[ModesCase]:
    """All cases of a study.

    Args:
        tables: The scene of the block.
        ratios: H/B; none: that of the scene.
        points: Of the grid, along each axis.
        engines: Which of `ENGINES`; none: those that the block has the material for.
    """
    engines = engines or ENGINES[: 1 + is_elastic(tables)]
    if "elastic" in engines and not is_elastic(tables):
        raise Statement("block", "has no young and poisson: add them, or choose --engines rigid")
    own = variant(tables, model="rigid").blocks[0].shape
    wanted = ratios or [float(f"{own.height / own.width:.6g}")]
    return [
        _case(tables, engine, ratio, float(acceleration), points)
        for engine in engines
        for ratio in wanted
        for acceleration in _grid(ACCELERATIONS, points, ratio)
    ]


def _grid(ends: tuple[float, float], points: int, ratio: float) -> list[float]:
    """Values of a grid between ends over B/H."""
    return [float(f"{value / ratio:.5g}") for value in np.linspace(*ends, points)]


def _case(tables: Tables, engine: str, ratio: float, acceleration: float, points: int) -> ModesCase:
    """One acceleration of one map."""
    frictions = _grid(FRICTIONS, points, ratio)
    scenes = tuple(
        scene_of(tables | {"contact": tables.get("contact", {}) | {"friction": mu}}, engine, ratio)
        for mu in frictions
    )
    return ModesCase(
        name=f"{engine},ratio={ratio:g},acceleration={acceleration:g}",
        engine=engine,
        ratio=ratio,
        acceleration=acceleration,
        scenes=scenes,
        frictions=tuple(frictions),
    )


def scene_of(tables: Tables, engine: str, ratio: float) -> Scene:
    """The scene with a block of slenderness H/B: of its own half diagonal, density, size of cells.

    With the half diagonal p stays what it is, and so does the time in which blocks turn.
    """
    if not 0.1 <= ratio <= 100:
        raise SceneError("--ratios", f"{ratio:g}", "0.1 <= H/B <= 100")
    scene = variant(tables)
    own, end = scene.blocks[0], WINDOW[1] * unit(scene)
    width = 2 * own.shape.half_diagonal / math.hypot(1.0, ratio)
    height = ratio * width
    along, up = own.cells[0], own.cells[-1]
    keys = {
        "width": width,
        "height": height,
        "mass": None,
        "density": own.shape.density,
        "cells": [
            max(FEWEST_CELLS, round(along * width / own.width)),
            max(FEWEST_CELLS, round(up * height / own.height)),
        ],
    }
    return variant(tables, model=engine, time={"end": end}, friction=None, **keys)
