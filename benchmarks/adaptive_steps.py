"""Errors of the default steps, against the limit of short ones.

    ./in-env python3 benchmarks/adaptive_steps.py [--processes N]

Writes `benchmarks/adaptive_steps.csv`, a row a run. Blocks of several shapes, stiffnesses and
meshes rock freely, one stands on another block, one on an oscillator, some are dropped flat. Each
is run with the default tolerance, a fourth and four times of it, and 1/32 of it; the last one
is what the others are compared with. The columns are the largest differences of the restitutions of
impacts 1 to 4, of the times of impacts 2 to 5 (%), and of the peaks 2 to 4 (%). What is dropped has
one impact, whose restitution is the speed of its centre after the impact over that before. Steps do
not depend on what else runs on the machine; seconds do.
"""

from __future__ import annotations

import copy
import tomllib
from itertools import chain, pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks.rows import DEMO, side_by_side, write_table
from rockslip import History, Scene, parse_scene, simulate
from solver.results.rocking import peaks

TABLE = Path(__file__).with_suffix(".csv")

TOLERANCE = 1e-3
FACTORS = (1 / 32, 1 / 4, 1.0, 4.0)
BETAS = (3e-5, 1e-4)
VIBRATING = 1e-5
"""Damping with which vibration lasts through a swing, s: of the demo's block alone."""
SPEED = 1.4
"""Speed of a block that lands flat, m/s: that of a fall of 0.1 m."""

BLOCKS: dict[str, dict[str, Any]] = {
    "demo": {},
    "H/B 3": {"height": 0.75, "mass": 503 * 0.75},
    "H/B 6": {"height": 1.5, "mass": 503 * 1.5, "tilt_deg": 2.0},
    "H/B 8": {"height": 2.0, "mass": 503 * 2.0, "tilt_deg": 1.5},
    "E 5 GPa": {"young": 5e9},
    "E 500 GPa": {"young": 5e11},
    "12 x 32 cells": {"cells": [12, 32]},
    "24 x 64 cells": {"cells": [24, 64]},
    "0.8 alpha": {"tilt_deg": 0.8 * float(np.degrees(np.arctan(0.25)))},
}
PEDESTAL = {
    "name": "pedestal", "width": 0.5, "height": 0.5, "thickness": 0.75, "density": 2680.0,
    "young": 5e10, "poisson": 0.2, "cells": [12, 8],
}  # fmt: skip
FLIGHT = 5e-3
"""Shortest flight, s: contacts in between are vibration."""
PLATFORM = {"kind": "oscillator", "mass_ratio": 2.0, "period": 0.5, "damping_ratio": 0.05}


class Answer(NamedTuple):
    """Values that are compared."""

    restitutions: list[float]
    times: list[float]
    peaks: list[float]
    steps: int
    seconds: float


def scene(case: str, damping: float) -> dict[str, Any]:
    """The scene of a case with material damping beta_R (s)."""
    with DEMO.open("rb") as stream:
        made: dict[str, Any] = tomllib.load(stream)
    (block,) = made["block"]
    made["damping"] = {"stiffness": damping}
    made["time"] = {"end": 2.0 if case == "H/B 8" else 1.6}
    made["output"] = {"fields": "none"}
    block["name"] = "block"
    if case == "on a block":
        made["block"].insert(0, copy.deepcopy(PEDESTAL))
        block["on"] = "pedestal"
    elif case == "on an oscillator":
        made["foundation"] = PLATFORM
    elif case == "dropped flat":
        made["time"]["end"] = 0.3
        block |= {"tilt_deg": 0.0, "velocity": [0.0, -SPEED]}
    else:
        block |= BLOCKS[case]
    return made


def rebound(history: History) -> float:
    """Speed of a dropped block in its first flight of `FLIGHT` or more, over that of its fall."""
    time, height = history["time_s"], history["block.centre_y_m"]
    touching = [0, *np.flatnonzero(history["block.normal_force_N"] > 0), len(time)]
    for last, following in pairwise(touching):
        rows = slice(last + 1, following)
        if following - last > 4 and time[following - 1] - time[last] > FLIGHT:
            moved = height[rows] + 9.81 * (time[rows] - time[last]) ** 2 / 2
            return float(np.polynomial.polynomial.polyfit(time[rows], moved, 1)[1] / SPEED)
    return 0.0


def answer(case: str, made: Scene) -> Answer:
    """Run a scene."""
    run = simulate(made)
    cost = run.summary["cost"]
    if case == "dropped flat":
        return Answer([rebound(run.history)], [], [], cost["steps"], cost["wall_s"])
    found = run.summary["blocks"]["block"]["impacts"]
    shape = next(block for block in made.blocks if block.name == "block").shape
    turns = peaks(run.history["time_s"], run.history["block.angle_rad"], shape.slenderness())
    return Answer(
        [impact["restitution"] for impact in found[:4] if impact["restitution"] is not None],
        [impact["time_s"] for impact in found[1:5]],
        [angle for _, angle in turns[1:4]],
        cost["steps"],
        cost["wall_s"],
    )


def rows_of(task: tuple[str, float]) -> list[dict[str, Any]]:
    """The rows of a case with a damping."""
    case, damping = task
    answers = []
    for factor in FACTORS:
        made = scene(case, damping)
        made["time"]["tolerance"] = TOLERANCE * factor
        answers.append(answer(case, parse_scene(made)))
    limit = answers[0]
    return [
        {
            "case": case,
            "beta_s": f"{damping:g}",
            "tolerance": f"{TOLERANCE * factor:.3g}",
            "steps": found.steps,
            "restitution": f"{np.exp(np.mean(np.log(found.restitutions))):.4f}",
            "restitutions_differ": f"{_apart(found.restitutions, limit.restitutions):.4f}",
            "times_differ_percent": f"{100 * _apart(found.times, limit.times, limit.times):.3f}",
            "peaks_differ_percent": f"{100 * _apart(found.peaks, limit.peaks, limit.peaks):.3f}",
            "loop_s": f"{found.seconds:.2f}",
        }
        for factor, found in zip(FACTORS, answers, strict=True)
    ]


def _apart(found: list[float], limit: list[float], scale: list[float] | None = None) -> float:
    """Largest difference, over a scale; NaN where one has more of them than the other."""
    if len(found) != len(limit):
        return float("nan")
    by = np.ones(len(limit)) if scale is None else np.abs(scale)
    return float(np.max(np.abs(np.subtract(found, limit)) / by, initial=0.0))


def main() -> None:
    """Run all cases."""
    cases = [*BLOCKS, "on a block", "on an oscillator", "dropped flat"]
    tasks = [("demo", VIBRATING), *((case, damping) for case in cases for damping in BETAS)]
    write_table(TABLE, chain.from_iterable(side_by_side(rows_of, tasks, __doc__)))


if __name__ == "__main__":
    main()
