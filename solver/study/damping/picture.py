"""Pictures of the study: restitution against each axis, calibrations."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from solver.pictures.style import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    RED,
    legend_above,
    new_figure,
    zero_line,
)
from solver.study.damping.calibration import Search, Target
from solver.study.damping.numbers import Line, Restitution
from solver.types import Array

FEW_VALUES = 5
"""Values up to this number are all named on their axis."""

PANEL_HEIGHT = 2.1
"""Height of one of several panels, in."""

LEAST_HEIGHT = 0.01
"""Restitutions that a panel shows at least."""

Angles = tuple[Array, Array]
"""Times (s) and angles (rad)."""


def restitution_picture(lines: Sequence[Line], own: Restitution | None) -> Figure:
    """Restitution against each axis, a panel for each.

    Args:
        lines: What was measured, of each axis.
        own: Restitution of the scene as it is.
    """
    columns = 1 if len(lines) == 1 else 2
    rows = math.ceil(len(lines) / columns)
    figure = new_figure(3.2 if rows == 1 else PANEL_HEIGHT * rows + 0.4)
    panels = figure.subplots(rows, columns, squeeze=False, sharey=True).ravel()
    for axes, line in zip(panels, lines, strict=False):
        _panel(axes, line, own)
    for axes in panels[len(lines) :]:
        axes.set_visible(False)
    for axes in panels[::columns]:
        axes.set_ylabel("restitution")
    panels[0].set_ylim(*_heights(lines))
    legend_above(figure, columns=2)
    return figure


def _heights(lines: Sequence[Line]) -> tuple[float, float]:
    """Lower and upper end of all panels: what was measured, not the uncertainty of limits."""
    known = [e for line in lines for found in line.found for e in found.known]
    low, high = min(known), max(known)
    margin = max(0.05 * (high - low), (LEAST_HEIGHT - high + low) / 2)
    return low - margin, high + margin


def _panel(axes: Axes, line: Line, own: Restitution | None) -> None:
    """The points of one axis, the limit, the scene as it is."""
    axes.set_xlabel(f"{line.axis.label}, {line.axis.meaning}")
    _scale(axes, line.values)
    mean = np.array(line.means)
    least = np.array([min(found.known) for found in line.found])
    largest = np.array([max(found.known) for found in line.found])
    axes.errorbar(
        line.values, mean, yerr=np.array([mean - least, largest - mean]), color=BLUE, marker="o",
        markersize=3.5, capsize=2.5, elinewidth=0.8, linewidth=0.8,
        label="mean and range of impacts",
    )  # fmt: skip
    if line.limit is not None:
        low, high = (line.limit.value + s * line.limit.uncertainty for s in (-1, 1))
        known = line.limit.source != "scatter"
        axes.axhspan(
            low, high, color=GREEN if known else ORANGE, alpha=0.25 if known else 0.15,
            linewidth=0, label="limit" if known else "range of last three",
        )  # fmt: skip
    if own is not None and own.mean is not None:
        axes.axhline(own.mean, color=GREY, linewidth=0.7, linestyle=":", label="the scene")


def _scale(axes: Axes, values: Sequence[float]) -> None:
    """Scale and ticks for increasing values: logarithmic where they differ much, linear to zero."""
    positive = [value for value in values if value > 0]
    if positive and positive[-1] > 3 * positive[0]:
        axes.set_xscale("symlog", linthresh=positive[0], linscale=0.5)
    if len(values) <= FEW_VALUES:
        names = [f"{value:g}".replace("e+", "e").replace("e0", "e") for value in values]
        axes.set_xticks(values, names, fontsize="small")
        axes.set_xticks([], minor=True)


def calibration_picture(search: Search, target: Target, label: str, best: Angles | None) -> Figure:
    """A calibration: one panel, or two with a measured history.

    Args:
        search: Its runs.
        target: What they are compared with.
        label: Name and unit of the parameter.
        best: The angle of the best run, beside a measured history; None: no panel of it.
    """
    both = target.history is not None and best is not None
    figure = new_figure(5.4 if both else 3.0)
    panels = figure.subplots(2 if both else 1, 1, squeeze=False)[:, 0]
    _draw_search(panels[0], search, target, label)
    if target.history is not None and best is not None:
        _draw_history(panels[1], target.history, best)
    legend_above(figure, columns=6)
    return figure


def _draw_search(axes: Axes, search: Search, target: Target, label: str) -> None:
    """Restitution against the parameter, numbered as the runs were made."""
    least, largest = search.reach
    axes.axhspan(least, largest, color=GREY, alpha=0.12, linewidth=0, label="reach")
    axes.axhline(target.restitution, color=RED, linewidth=0.9, label="target")
    if search.within_reach:
        number = search.trials.index(search.best)
        low, *_, high = search.trials[max(number - 1, 0) : number + 2]
        axes.axvspan(low.value, high.value, color=ORANGE, alpha=0.18, linewidth=0, label="bracket")
    values = [trial.value for trial in search.trials]
    found = [trial.restitution for trial in search.trials]
    axes.plot(values, found, color=BLUE, marker="o", markersize=3.5, linewidth=0.8, label="runs")
    for number, trial in enumerate(search.made, start=1):
        axes.annotate(
            str(number), (trial.value, trial.restitution), xytext=(4, 5),
            textcoords="offset points", fontsize=7,
        )  # fmt: skip
    if search.within_reach:
        axes.plot(
            [search.best.value], [search.best.restitution], color=GREEN, marker="D",
            markersize=6, linestyle="none", label="calibrated",
        )  # fmt: skip
    axes.set(xscale="log", xlabel=label, ylabel="restitution")


def _draw_history(axes: Axes, measured: Angles, best: Angles) -> None:
    """The measured angle and that of the best run, both leaning to the same side at first."""
    time, angle = measured
    own = np.sign(best[1][0]) * np.sign(angle[np.argmax(np.abs(angle))])
    axes.plot(
        time - time[0], own * np.degrees(angle), color=GREY, linewidth=2.4, alpha=0.5,
        label="measured",
    )  # fmt: skip
    axes.plot(best[0], np.degrees(best[1]), color=BLUE, linewidth=0.9, label="calibrated run")
    zero_line(axes)
    axes.set(xlabel="time (s)", ylabel="rocking angle (°)")
