"""The picture of a suite: the peaks of all its runs against the strength of their motions."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from solver.pictures.style import GREY, colour, legend_above, new_figure, save
from solver.results.report import ROUND_OFF
from solver.study.tables import Row

MEASURES = (
    ("platform.peak_drift_m", "peak drift (mm)", 1e3),
    (".peak_slip_m", "peak slip (mm)", 1e3),
    (".peak_angle_rad", "peak angle (°)", 180 / math.pi),
)
"""Ends of columns, what their panels are called, and factors."""

FALLEN = (".overturned_at_s", ".fell_at_s")

MARKERS = "osD^vP"


def suite_picture(rows: Sequence[Row], varied: Sequence[str], file: Path) -> Path | None:
    """Draw the peaks of all runs; returns the file, None where there is nothing to draw."""
    shown = [row for row in rows if row.get("pga_g") is not None]
    panels = _panels(shown)
    return save(lambda: _draw(shown, varied, panels), file) if panels else None


def _panels(rows: Sequence[Row]) -> list[tuple[str, str, float]]:
    """Columns that have a panel, with its label and the factor: those in which something moves."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    found = []
    for ending, label, factor in MEASURES:
        for name in names:
            of_block = name.endswith(ending) and not name.startswith(("reference.", "platform."))
            if name == ending or (ending.startswith(".") and of_block):
                owner = name.removesuffix(ending)
                if any(factor * abs(row.get(name) or 0.0) > ROUND_OFF for row in rows):
                    found.append((name, f"{owner} {label}".strip(), factor))
    return found


def _draw(
    rows: Sequence[Row], varied: Sequence[str], panels: Sequence[tuple[str, str, float]]
) -> Figure:
    """A panel for each measure, a colour for each of the varied values."""
    figure = new_figure(0.7 + 1.9 * len(panels))
    grid = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    groups = list(dict.fromkeys(_group(row, varied) for row in rows))
    for axes, (name, label, factor) in zip(grid, panels, strict=True):
        for number, group in enumerate(groups):
            inside = [row for row in rows if _group(row, varied) == group]
            look = {"color": colour(number), "marker": MARKERS[number % len(MARKERS)]}
            _points(axes, inside, name, factor, label=group or "runs", **look)
        axes.set_ylabel(label)
        axes.set_ylim(0, None)
    grid[-1].set_xlabel("largest acceleration of the ground along x (g)")
    grid[-1].set_xlim(0, None)
    figure.align_ylabels()
    legend_above(figure)
    return figure


def _group(row: Mapping[str, Any], varied: Sequence[str]) -> str:
    """The varied values of a run in words."""
    return ", ".join(f"{key.rpartition('.')[2]} {row[key]}" for key in varied)


def _points(
    axes: Axes, rows: Sequence[Row], name: str, factor: float, *, label: str, **look: Any
) -> None:
    """A mark for each run, in a ring the rigid-body answer; crossed where a block was lost."""
    own = [(row["pga_g"], factor * row[name]) for row in rows if row.get(name) is not None]
    block = name.partition(".")[0]
    lost = [
        (row["pga_g"], factor * row[name])
        for row in rows
        if any(row.get(block + ending) is not None for ending in FALLEN)
    ]
    answer = [
        (row["pga_g"], factor * row[f"reference.{name}"])
        for row in rows
        if row.get(f"reference.{name}") is not None
    ]
    if own:
        axes.plot(*np.array(own).T, linestyle="", markersize=3.5, label=label, **look)
    if answer:
        ring: dict[str, Any] = {"linestyle": "", "marker": "o", "fillstyle": "none"}
        axes.plot(*np.array(answer).T, color=GREY, markersize=7, label="rigid-body answer", **ring)
    if lost:
        cross: dict[str, Any] = {"linestyle": "", "marker": "x", "color": "black"}
        axes.plot(*np.array(lost).T, markersize=6, label="overturned or fell", **cross)
