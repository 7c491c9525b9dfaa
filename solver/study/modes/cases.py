"""Maps of modes: how blocks begin to move, by either engine, over friction and acceleration."""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

from mpi4py import MPI

import numpy as np

from geometry.block import Block
from solver.errors import SceneError, Statement
from solver.excitation.motion import GroundMotion
from solver.excitation.sampled import SampledMotion
from solver.rigid.system import RigidSystem
from solver.run.simulate import simulate
from solver.scene import Scene
from solver.study.modes.numbers import BAND, NAMES, as_text, maps_of, points_of
from solver.study.scenes import Tables, is_elastic, refuse_uneven, standing_block, variant
from solver.study.study import Row, Study, numbers, words
from solver.types import Array

ENGINES = ("rigid", "elastic")

FRICTIONS, ACCELERATIONS = (0.25, 2.45), (0.25, 4.0)
"""Ends of the grid of frictions and of accelerations A, both over B/H."""

FEWEST_CELLS = 4
"""Cells along each side of an elastic block, at least."""

RAMPED_STEPS = 400
"""Steps of a rigid block that is run beside an elastic one."""


SUDDEN, SUDDEN_STEPS = 0.075566, 200
"""Time from the start of a sudden acceleration in which a rigid block is followed, and its steps.

Times are over 1/p, in which blocks turn; for the paper's block they are whole ms, here 20.
"""

RAMP, WINDOW = 0.113349, (0.151133, 0.302265)
"""Time in which the ground's acceleration rises, and first and last time of what counts.

A sudden acceleration makes an elastic block overshoot; its vibration has to decay first. For the
paper's block 30, 40 and 80 ms: it bends with a period of 6 ms.
"""

LEAST = 0.01
"""Least angular acceleration, over p^2 sin alpha, and slip acceleration, over A g, that are motion.

Three per cent beyond a boundary they are at least 0.03 where there is one of them alone.
"""


@dataclass(frozen=True, slots=True)
class Onset:
    """First motion of a block, which leans and slips against the ground's acceleration."""

    turn: float
    """theta'', rad/s^2."""
    slip: float
    """Acceleration of the slip, m/s^2."""

    def mode(self, shape: Block, acceleration: float, gravity: float) -> str:
        """Mode that these accelerations stand for: "rest", "slide", "rock" or "slide-rock".

        Args:
            shape: The block.
            acceleration: A = |a_g|/g.
            gravity: g, m/s^2.
        """
        # 3/4 g b/R^2 = p^2 sin alpha: theta'' grows by A/A_uplift - 1 times this.
        turns = self.turn > LEAST * shape.frequency(gravity) ** 2 * np.sin(shape.slenderness())
        slips = self.slip > LEAST * acceleration * gravity
        return ("slide-rock" if slips else "rock") if turns else ("slide" if slips else "rest")


def unit(scene: Scene) -> float:
    """1/p of the block of a scene, s."""
    return 1 / scene.blocks[0].shape.frequency(scene.gravity)


def sudden_onset(scene: Scene, acceleration: float) -> Onset:
    """Onset of a rigid block under a sudden acceleration of its base, A = a_g/g."""
    system = RigidSystem(scene)
    name, columns = system.names[0], system.columns
    ground = np.zeros((SUDDEN_STEPS + 1, 2))
    ground[:, 0] = acceleration * scene.gravity
    rows = system.advance(SUDDEN_STEPS, SUDDEN * unit(scene) / SUDDEN_STEPS, ground).rows
    velocity = rows[:, columns.index(f"{name}.angular_velocity_rad_s")]
    slip = rows[:, columns.index(f"{name}.slip_m")]
    time = rows[:, columns.index("time_s")]
    # The accelerations depend on the angle, and so on t^2: theta' = theta'' t + ..t^3 from rest.
    return Onset(-_first(time, velocity, 1), -2 * _first(time, slip, 2))


def _first(time: Array, values: Array, power: int) -> float:
    """Factor of t^power in the best sum of that and t^(power + 2)."""
    terms = np.stack([time**power, time ** (power + 2)], axis=1)
    return float(np.linalg.lstsq(terms / terms[-1], values, rcond=None)[0][0] / terms[-1, 0])


def ramped_onset(scene: Scene, acceleration: float) -> Onset:
    """Onset of a block, elastic or rigid, after a ramp of its base's acceleration to A = a_g/g."""
    level, scale = acceleration * scene.gravity, unit(scene)
    times = np.array([0.0, RAMP * scale, scene.time.end])
    ramp = SampledMotion(time=times, value=np.array([0.0, level, level]))
    ground = GroundMotion((ramp, None))
    history = simulate(scene, comm=MPI.COMM_SELF, ground=ground).history
    name, time = scene.blocks[0].name, history["time_s"]
    turn = _fitted(time, history[f"{name}.angular_velocity_rad_s"], scale, degree=1)
    slip = 2 * _fitted(time, history[f"{name}.slip_m"], scale, degree=2)
    return Onset(-turn, -slip)


def _fitted(time: Array, values: Array, scale: float, degree: int) -> float:
    """Highest coefficient of the polynomial of a degree that fits values in the window best.

    The window is over `scale`, which is 1/p, s. Towards its ends values count less and less (Hann's
    weights), so that vibration of a few periods in it averages out.
    """
    part = np.linspace(0.0, 1.0, 401)
    at = scale * (WINDOW[0] + part * (WINDOW[1] - WINDOW[0]))
    weights = np.sin(np.pi * part)  # of the differences, which are squared
    fit = np.polyfit(at - at.mean(), np.interp(at, time, values), degree, w=weights)
    return float(fit[0])


@dataclass(frozen=True, slots=True, kw_only=True)
class ModesCase:
    """One engine, one slenderness, one acceleration, all frictions.

    Attributes:
        engine: "rigid" or "elastic".
        ratio: H/B.
        acceleration: A = a_g/g.
        scenes: One for each coefficient of friction.
        frictions: Their coefficients.
    """

    engine: str
    ratio: float
    acceleration: float
    scenes: tuple[Scene, ...]
    frictions: tuple[float, ...]

    @property
    def name(self) -> str:
        """Its own in the study; also the name of its file."""
        return f"{self.engine},ratio={self.ratio:g},acceleration={self.acceleration:g}"

    def run(self) -> Row:
        """Run all frictions on one process; the row of the case, with a list of points."""
        onset = sudden_onset if self.engine == "rigid" else ramped_onset
        points = []
        for friction, scene in zip(self.frictions, self.scenes, strict=True):
            found, shape = onset(scene, self.acceleration), scene.blocks[0].shape
            mode = found.mode(shape, self.acceleration, scene.gravity)
            point = {"friction": friction, "mode": mode}
            point |= {"turn_rad_s2": found.turn, "slip_m_s2": found.slip}
            if self.engine == "elastic":
                rigid = ramped_onset(rigid_of(scene), self.acceleration)
                point |= {"rigid_turn_rad_s2": rigid.turn, "rigid_slip_m_s2": rigid.slip}
            points.append(point)
        return {
            "engine": self.engine,
            "ratio": self.ratio,
            "width": self.scenes[0].blocks[0].width,
            "acceleration_g": self.acceleration,
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
    found = []
    for engine, ratio in product(engines, wanted):
        frictions = tuple(_grid(FRICTIONS, points, ratio))
        laws = (tables.get("contact", {}) | {"friction": friction} for friction in frictions)
        scenes = tuple(scene_of(tables | {"contact": law}, engine, ratio) for law in laws)
        found += [
            ModesCase(
                engine=engine, ratio=ratio, acceleration=a, scenes=scenes, frictions=frictions
            )
            for a in _grid(ACCELERATIONS, points, ratio)
        ]
    return found


def _grid(ends: tuple[float, float], points: int, ratio: float) -> list[float]:
    """Values of a grid between ends over B/H."""
    return [float(f"{value / ratio:.5g}") for value in np.linspace(*ends, points)]


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


class ModesStudy(Study[ModesCase]):
    """Rest, slide, rock or both: how a block at rest begins to move."""

    kind, noun = "modes", "study of modes"
    same = "the same scene and number of points"

    def __init__(self, options: argparse.Namespace):
        """Read the command line."""
        super().__init__(options)
        if not 2 <= options.points <= 200:
            raise SceneError("--points", f"{options.points}", "2 <= points <= 200")
        engines = words("--engines", options.engines, ENGINES)
        ratios = numbers("--ratios", options.ratios)
        tables = standing_block(options)
        scene = variant(tables)
        refuse_uneven(scene, "in this study, which varies H/B of homogeneous blocks")
        self.wanted = cases_of(tables, ratios, options.points, engines)
        self.gravity = scene.gravity
        self.settings = {"scene": scene.to_dict(), "points": options.points}

    @property
    def good(self) -> bool:
        """True if all cases completed and all points that are judged agree."""
        points = points_of(self.completed, self.gravity)
        return super().good and all(point["agrees"] for point in points if point["judged"])

    def write(self) -> str:
        """Write the points, what the maps show, the picture."""
        from solver.study.modes.picture import modes_picture

        points = points_of(self.completed, self.gravity)
        if not points:
            return ""
        maps = maps_of(points)
        text = as_text(maps)
        self.leave(points, text, {"band": BAND, "maps": maps}, names=NAMES)
        self.draw("modes.png", modes_picture, points)
        return text
