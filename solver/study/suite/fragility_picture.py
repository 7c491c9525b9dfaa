"""Pictures of an ensemble: fragility over intensity, and distributions of peaks."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from solver.pictures.style import BLUE, DASHES, GREEN, GREY, RED, legend_above, new_figure, save
from solver.study.suite.findings import Sample
from solver.study.suite.fragility import Lognormal, interval

COLOURS = {"": GREY, "rigid": BLUE, "elastic": RED, "ode": GREEN}
NAMES = {"": "scene", "rigid": "rigid", "elastic": "elastic", "ode": "Housner's equation"}
MARKS = {"": "o", "rigid": "o", "elastic": "s", "ode": "^"}
STYLES: tuple[Any, ...] = ("-", DASHES, (0, (1, 1)))

LEAST_SLIP = 0.1
"""Shortest axis of slips, mm."""

Curves = Sequence[tuple[list[Sample], Lognormal | None]]


def draw_curves(curves: Curves, axis: str, file: Path) -> Path:
    """Draw probabilities of overturning with their intervals and the fitted curves."""
    return save(lambda: _curves(curves, axis), file)


def _curves(curves: Curves, axis: str) -> Figure:
    groups = list(dict.fromkeys(own[0].group for own, _ in curves))
    figure = new_figure(2.9 * len(groups) + 0.4)
    panels = figure.subplots(len(groups), 1, squeeze=False, sharex=True)[:, 0]
    for axes, group in zip(panels, groups, strict=True):
        inside = [pair for pair in curves if pair[0][0].group == group]
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


def draw_distributions(samples: Sequence[Sample], axis: str, file: Path) -> Path:
    """Draw the distributions of peak angles and slips, at three levels at most."""
    return save(lambda: _distributions(samples, axis), file)


def _distributions(samples: Sequence[Sample], axis: str) -> Figure:
    groups = list(dict.fromkeys(sample.group for sample in samples))
    figure = new_figure(2.7 * len(groups) + 0.5)
    panels = figure.subplots(len(groups), 2, squeeze=False, sharey=True)
    levels = sorted({sample.level for sample in samples if sample.level is not None})
    shown: list[float | None] = (
        list(sorted({levels[0], levels[len(levels) // 2], levels[-1]})) if levels else [None]
    )
    for line, group in zip(panels, groups, strict=True):
        for sample in (s for s in samples if s.group == group and s.level in shown):
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
