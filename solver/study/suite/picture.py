"""Pictures of a suite: peaks over the strength of motions; of ensembles fragility and peaks."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from solver.pictures.style import (
    BLUE,
    DASHES,
    GREEN,
    GREY,
    RED,
    colour,
    legend_above,
    new_figure,
)
from solver.results.report import ROUND_OFF
from solver.study.suite.numbers import Lognormal, Sample, interval, is_of_block
from solver.study.tables import Row, groups

MEASURES = (
    ("platform.peak_drift_m", "peak drift (mm)", 1e3),
    (".peak_slip_m", "peak slip (mm)", 1e3),
    (".peak_angle_rad", "peak angle (°)", 180 / math.pi),
)
"""Ends of columns, what their panels are called, and factors."""

FALLEN = (".overturned_at_s", ".fell_at_s")

MARKERS = "osD^vP"

COLOURS = {"": GREY, "rigid": BLUE, "elastic": RED, "ode": GREEN}
NAMES = {"": "scene", "rigid": "rigid", "elastic": "elastic", "ode": "Housner's equation"}
MARKS = {"": "o", "rigid": "o", "elastic": "s", "ode": "^"}
STYLES: tuple[Any, ...] = ("-", DASHES, (0, (1, 1)))

LEAST_SLIP = 0.1
"""Shortest axis of slips, mm."""

Curves = Sequence[tuple[list[Sample], Lognormal | None]]


def panels_of(rows: Sequence[Row]) -> list[tuple[str, str, float]]:
    """Columns that have a panel, with its label and the factor: those in which something moves."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    found = []
    for ending, label, factor in MEASURES:
        for name in names:
            if name == ending or is_of_block(name, ending):
                owner = name.removesuffix(ending)
                if any(factor * abs(row.get(name) or 0.0) > ROUND_OFF for row in rows):
                    found.append((name, f"{owner} {label}".strip(), factor))
    return found


def suite_picture(
    rows: Sequence[Row], varied: Sequence[str], panels: Sequence[tuple[str, str, float]]
) -> Figure:
    """The peaks of all runs, a panel for each measure, a colour for each of the varied values."""
    figure = new_figure(0.7 + 1.9 * len(panels))
    grid = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    runs = groups(rows, lambda row: _words(row, varied))
    for axes, (name, label, factor) in zip(grid, panels, strict=True):
        for number, (words, inside) in enumerate(runs.items()):
            look = {"color": colour(number), "marker": MARKERS[number % len(MARKERS)]}
            _points(axes, inside, name, factor, label=words or "runs", **look)
        axes.set_ylabel(label)
        axes.set_ylim(0, None)
    grid[-1].set_xlabel("largest acceleration of the ground along x (g)")
    grid[-1].set_xlim(0, None)
    figure.align_ylabels()
    legend_above(figure)
    return figure


def _words(row: Mapping[str, Any], varied: Sequence[str]) -> str:
    """The varied values of a run in words."""
    return ", ".join(f"{key.rpartition('.')[2]} {row[key]}" for key in varied)


def _points(
    axes: Axes, rows: Sequence[Row], name: str, factor: float, *, label: str, **look: Any
) -> None:
    """A mark for each run, in a ring the rigid-body answer; crossed where a block was lost."""
    block = name.partition(".")[0]
    lost = [row for row in rows if any(row.get(block + end) is not None for end in FALLEN)]
    ring = {"label": "rigid-body answer", "color": GREY, "markersize": 7, "fillstyle": "none"}
    cross = {"label": "overturned or fell", "color": "black", "markersize": 6, "marker": "x"}
    for key, those, style in (
        (name, rows, {"label": label, "markersize": 3.5, **look}),
        (f"reference.{name}", rows, {"marker": "o", **ring}),
        (name, lost, cross),
    ):
        at = [(row["pga_g"], factor * row[key]) for row in those if row.get(key) is not None]
        if at:
            axes.plot(*np.array(at).T, linestyle="", **style)


def fragility_picture(curves: Curves, axis: str) -> Figure:
    """Probabilities of overturning with their intervals and the fitted curves."""
    blocks = groups(curves, lambda curve: curve[0][0].group).values()
    figure = new_figure(2.9 * len(blocks) + 0.4)
    panels = figure.subplots(len(blocks), 1, squeeze=False, sharex=True)[:, 0]
    for axes, inside in zip(panels, blocks, strict=True):
        for number, (own, curve) in enumerate(inside):
            _curve(axes, own, curve, number - (len(inside) - 1) / 2)
        axes.set(ylabel="probability of overturning", ylim=(-0.03, 1.03))
        axes.set_xlim(0, 1.12 * max(sample.level or 0.0 for own, _ in inside for sample in own))
        axes.set_title(f"{inside[0][0][0].words}, {len(inside[0][0][0].angle)} motions", loc="left")
    panels[-1].set_xlabel(axis)
    legend_above(figure, columns=3)
    return figure


def _curve(axes: Axes, own: list[Sample], curve: Lognormal | None, place: float) -> None:
    """Probabilities of one engine, beside those of the others, and its curve."""
    tint, engine = COLOURS[own[0].engine], own[0].engine
    at = np.array([sample.level for sample in own], dtype=float)
    beside = at + 0.008 * place * at.max()
    known = np.array([sample.overturned / len(sample.angle) for sample in own])
    ends = np.array([interval(sample.overturned, len(sample.angle)) for sample in own])
    error = np.abs(ends.T - known)
    style: dict[str, Any] = {"color": tint, "markersize": 3.5, "linewidth": 0.8, "capsize": 1.5}
    axes.errorbar(beside, known, error, fmt=MARKS[engine], label=NAMES[engine], **style)
    if curve is not None:
        along = np.linspace(at.max() / 200, 1.1 * at.max(), 300)
        axes.plot(along, curve.probability(along), color=tint)


def peaks_picture(samples: Sequence[Sample], axis: str) -> Figure:
    """The distributions of peak angles and slips, at three levels at most."""
    blocks = groups(samples, lambda sample: sample.group)
    figure = new_figure(2.7 * len(blocks) + 0.5)
    panels = figure.subplots(len(blocks), 2, squeeze=False, sharey=True)
    levels = sorted({sample.level for sample in samples if sample.level is not None})
    shown: list[float | None] = (
        list(sorted({levels[0], levels[len(levels) // 2], levels[-1]})) if levels else [None]
    )
    for line, (group, inside) in zip(panels, blocks.items(), strict=True):
        for sample in (sample for sample in inside if sample.level in shown):
            label = NAMES[sample.engine]
            if sample.level is not None:
                label += f", {axis.split(',')[0]} {sample.level:g}"
            style: dict[str, Any] = {
                "color": COLOURS[sample.engine],
                "linestyle": STYLES[shown.index(sample.level)],
                "label": label,
            }
            _steps(line[0], sample.angle, style)
            _steps(line[1], [1e3 * slip for slip in sample.slip], style)
        line[0].set_ylabel(f"fraction of the motions, {group[-1][1]}")
        line[0].set(xlim=(0, 1.05), ylim=(0, 1.02))
        line[1].set_xlim(0, max(LEAST_SLIP, line[1].get_xlim()[1]))  # not round-off
    panels[-1][0].set_xlabel("peak |theta|/alpha; the rest overturned")
    panels[-1][1].set_xlabel("peak slip while it stands, mm")
    legend_above(figure, columns=3)
    return figure


def _steps(axes: Axes, values: Sequence[float], style: dict[str, Any]) -> None:
    """The distribution of a sample, up to its finite values."""
    ordered = np.sort(np.asarray(values, dtype=float))
    known = ordered[np.isfinite(ordered)]
    if len(ordered):
        parts = np.arange(len(known) + 1) / len(ordered)
        axes.step(np.concatenate([[0.0], known]), parts, where="post", **style)
