"""Pictures of the study: restitution against each axis, and histories of the angle."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from solver.pictures.style import (
    GREEN,
    GREY,
    PALETTE,
    colour,
    legend_above,
    new_figure,
    save,
    zero_line,
)
from solver.study.damping.axes import Axis
from solver.study.damping.findings import Line
from solver.study.damping.restitution import Restitution
from solver.types import Array

MARKERS = "osD^vP"

PANEL_HEIGHT = 2.1
"""Height of one of several panels, in."""

MOST_CURVES = len(PALETTE)
"""Histories in one panel."""

LEAST_HEIGHT = 0.01
"""Restitutions that a panel shows at least."""

Angles = tuple[Array, Array]
"""Times (s) and angles (rad)."""


def restitution_picture(
    lines: Sequence[Line], own: Restitution | None, at: Axis | None, file: Path
) -> Path:
    """Draw restitution against each axis; returns the file.

    Args:
        lines: What was measured.
        own: Restitution of the scene as it is.
        at: The axis that all is repeated for.
        file: To be written.
    """
    return save(lambda: _restitutions(lines, own, at), file)


def _restitutions(lines: Sequence[Line], own: Restitution | None, at: Axis | None) -> Figure:
    """A panel for each axis."""
    names = list(dict.fromkeys(line.axis.name for line in lines))
    columns = 1 if len(names) == 1 else 2
    rows = math.ceil(len(names) / columns)
    figure = new_figure(3.2 if rows == 1 else PANEL_HEIGHT * rows + 0.4)
    panels = figure.subplots(rows, columns, squeeze=False, sharey=True).ravel()
    for axes, name in zip(panels, names, strict=False):
        _panel(axes, [line for line in lines if line.axis.name == name], own, at)
    for axes in panels[len(names) :]:
        axes.set_visible(False)
    for axes in panels[::columns]:
        axes.set_ylabel("restitution")
    low, high = panels[0].get_ylim()
    if high - low < LEAST_HEIGHT:
        middle = (low + high) / 2
        panels[0].set_ylim(middle - LEAST_HEIGHT / 2, middle + LEAST_HEIGHT / 2)
    legend_above(figure)
    return figure


def _panel(axes: Axes, lines: Sequence[Line], own: Restitution | None, at: Axis | None) -> None:
    """The points of one axis, the limit, the scene as it is."""
    axis = lines[0].axis
    axes.set_xlabel(f"{axis.label}, {axis.meaning}")
    place = _Places([value for line in lines for value in line.values])
    for number, line in enumerate(lines):
        known = [(v, f) for v, f in zip(line.values, line.found, strict=True) if f.mean]
        if not known:
            continue
        mean = np.array([found.mean for _, found in known])
        least = np.array([min(found.known) for _, found in known])
        largest = np.array([max(found.known) for _, found in known])
        label = "mean and range of the impacts"
        if at is not None and line.at is not None:
            label = f"{at.name} {line.at:g}"
        axes.errorbar(
            place.of([value for value, _ in known], number), mean,
            yerr=np.array([mean - least, largest - mean]), color=colour(number),
            marker=MARKERS[number % len(MARKERS)], markersize=3.5, capsize=2.5, elinewidth=0.8,
            linestyle="-" if len(known) > 1 else "none", linewidth=0.8, label=label,
        )  # fmt: skip
        if line.limit is not None:
            low, high = (line.limit.value + s * line.limit.uncertainty for s in (-1, 1))
            axes.axhspan(low, high, color=GREEN, alpha=0.25, linewidth=0, label="limit")
    if own is not None and own.mean is not None:
        axes.axhline(own.mean, color=GREY, linewidth=0.7, linestyle=":", label="the scene")
    place.ticks(axes)


class _Places:
    """Places of values on a logarithmic axis that has room for zero, at its left end."""

    def __init__(self, values: Sequence[float]):
        positive = sorted({value for value in values if value > 0})
        self._logarithmic = bool(positive) and positive[-1] > 4 * positive[0]
        self._zero = math.nan
        if self._logarithmic and min(values) == 0:
            self._zero = positive[0] * (positive[0] / positive[-1]) ** 0.15

    def of(self, values: Sequence[float], number: int) -> list[float]:
        """Places of the values of a line; lines are set apart by a little."""
        apart = 1 + 0.04 * number if self._logarithmic else 1.0
        return [apart * (self._zero if v == 0 and self._logarithmic else v) for v in values]

    def ticks(self, axes: Axes) -> None:
        """Scale and ticks."""
        if not self._logarithmic:
            return
        axes.set_xscale("log")
        if not math.isnan(self._zero):
            low, high = axes.get_xlim()
            ticks = [tick for tick in axes.get_xticks() if 1.5 * self._zero < tick <= high]
            powers = [f"$10^{{{round(math.log10(tick))}}}$" for tick in ticks]
            axes.set_xticks([self._zero, *ticks], ["0", *powers])
            axes.set_xlim(low, high)


def history_picture(curves: Mapping[str, Angles], file: Path) -> Path:
    """Draw angles against time; returns the file.

    Args:
        curves: Angles of runs, by label.
        file: To be written.
    """
    return save(lambda: _histories(curves), file)


def _histories(curves: Mapping[str, Angles]) -> Figure:
    """All curves in one panel."""
    figure = new_figure(3.2)
    axes = figure.subplots()
    for number, (label, (time, angle)) in enumerate(some(curves).items()):
        axes.plot(time, np.degrees(angle), color=colour(number), linewidth=0.9, label=label)
    zero_line(axes)
    axes.set(xlabel="time (s)", ylabel="rocking angle (°)")
    legend_above(figure, columns=5)
    return figure


def some(curves: Mapping[str, Angles]) -> dict[str, Angles]:
    """Curves that can be told apart: of too many some, evenly chosen, first and last included."""
    names = list(curves)
    if len(names) > MOST_CURVES:
        chosen = np.linspace(0, len(names) - 1, MOST_CURVES).round().astype(int)
        names = [names[k] for k in chosen]
    return {name: curves[name] for name in names}
