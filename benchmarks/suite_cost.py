"""Cost of the accuracy of a platform's peak drift, over time steps and models.

    ./in-env python3 benchmarks/suite_cost.py [--motions 3] [--end 20]

The platform of the paper (mass ratio 2, period 0.5 s, xi 0.05, friction 0.2) under the first of the
synthetic motions in which the block slides, in steps of 1e-2 to 2e-4 s: a rigid block, an elastic
one on the oscillator, an elastic one on a meshed plate on rollers. Writes
`benchmarks/suite_cost.csv`, a row for each model and step: errors of the peak drift against the
closed form of the rigid block, and the median time of the loop; and
`docs/pictures/suite_cost.png`, which shows them. One run after the other: their times are those of
a machine that does nothing else.
"""

from __future__ import annotations

import argparse
import statistics
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from tqdm import tqdm

from benchmarks.rows import write_table
from rockslip import Scene, parse_scene, simulate
from solver.excitation.synthetic import table1_suite
from solver.pictures.style import colour, legend_above, new_figure, save
from solver.reference.answer import reference_history
from solver.scene.motion import SyntheticSpec

TABLE = Path(__file__).with_suffix(".csv")
PICTURE = TABLE.parents[1] / "docs" / "pictures" / "suite_cost.png"

STEPS = (1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4)
FRICTION = 0.2

#: Step between the rows of the reference, s: its peak is read off there.
FINE = 2e-4

BLOCK = {"width": 1.0, "height": 0.5, "thickness": 1.0, "mass": 1000.0}
RIGID = BLOCK | {"model": "rigid"}
ELASTIC = BLOCK | {"young": 5e10, "poisson": 0.2, "cells": [6, 4]}
SPRING = {"mass_ratio": 2.0, "period": 0.5, "damping_ratio": 0.05}
OSCILLATOR = {"kind": "oscillator"} | SPRING
PLATE = {
    "kind": "elastic",
    "support": "rollers",
    "width": 3.0,
    "height": 0.3,
    "young": 5e10,
    "poisson": 0.2,
    "cells": [16, 2],
} | SPRING

MODELS: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "rigid on oscillator": (RIGID, OSCILLATOR),
    "elastic on oscillator": (ELASTIC, OSCILLATOR),
    "elastic on plate": (ELASTIC, PLATE),
}


def scene_of(model: str, motion: SyntheticSpec, step: float, end: float) -> Scene:
    """One run."""
    block, foundation = MODELS[model]
    scene = parse_scene(
        {
            "block": [block],
            "foundation": foundation,
            "contact": {"friction": FRICTION},
            "damping": {"stiffness": 0.0},
            "time": {"end": end, "step": step},
            "output": {"fields": "none", "every": end},
        }
    )
    return replace(scene, motion=motion)


def sliding_motions(count: int, end: float) -> dict[int, float]:
    """The first motions of the suite under which the block slides: number and peak drift, m."""
    found: dict[int, float] = {}
    for number, motion in enumerate(table1_suite()):
        history = reference_history(scene_of("rigid on oscillator", motion, FINE, end))
        if np.abs(history["block.slip_m"]).max() > 1e-2:
            found[number] = float(np.abs(history["platform.drift_m"]).max())
        if len(found) == count:
            break
    return found


def row_of(model: str, step: float, exact: dict[int, float], end: float) -> dict[str, Any]:
    """All motions with one model and one step."""
    motions, errors, seconds, steps = table1_suite(), [], [], 0
    for number, drift in exact.items():
        summary = simulate(scene_of(model, motions[number], step, end)).summary
        if summary["status"] != "completed":
            sys.exit(f"{model}, step {step:g} s: {summary['status']}, {summary['reason']}")
        errors.append(abs(summary["platform"]["peak_drift_m"] / drift - 1))
        seconds.append(summary["cost"]["wall_s"])
        steps = summary["cost"]["steps"]
    return {
        "model": model,
        "step_s": step,
        "motions": len(errors),
        "mean_error": f"{statistics.fmean(errors):.1e}",
        "largest_error": f"{max(errors):.1e}",
        "loop_s": f"{statistics.median(seconds):.3g}",
        "milliseconds_a_step": f"{1e3 * statistics.median(seconds) / steps:.3g}",
    }


def drawn(rows: list[dict[str, Any]], end: float) -> Figure:
    """Mean error against time in the loop, a line for each model."""
    figure = new_figure(3.2)
    axes = figure.subplots()
    for number, model in enumerate(MODELS):
        own = [row for row in rows if row["model"] == model]
        at = [[float(row[key]) for row in own] for key in ("loop_s", "mean_error")]
        axes.plot(*at, "o-", color=colour(number), markersize=4, label=model)
        for row, time, error in zip(own, *at, strict=True):
            axes.annotate(f"{row['step_s']:g} s", (time, error), (4, 3), textcoords="offset points",
                          fontsize=6)  # fmt: skip
    axes.set(xscale="log", yscale="log", ylabel="error of the peak drift")
    axes.set_xlabel(f"time in the loop for {end:g} s of motion (s)")
    legend_above(figure)
    return figure


def main() -> int:
    """Run all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--motions", type=int, default=3, help="number of motions, default 3")
    parser.add_argument("--end", type=float, default=20.0, help="of each run, s, default 20")
    options = parser.parse_args()
    exact = sliding_motions(options.motions, options.end)
    grid = [(model, step) for model in MODELS for step in STEPS]
    rows = write_table(
        TABLE,
        (row_of(model, step, exact, options.end) for model, step in tqdm(grid, desc="cost")),
    )
    save(lambda: drawn(rows, options.end), PICTURE)
    sys.stdout.write(f"{len(grid)} rows of {len(exact)} motions each; table in {TABLE}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
