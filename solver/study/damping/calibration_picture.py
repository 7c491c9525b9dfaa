"""Picture of a calibration: its runs, the target, and a measured history beside the best run."""

from __future__ import annotations

from pathlib import Path

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
    save,
    zero_line,
)
from solver.study.damping.search import Search, Trial
from solver.study.damping.target import Target
from solver.types import Array

Angles = tuple[Array, Array]
"""Times (s) and angles (rad)."""


def calibration_picture(
    search: Search, target: Target, label: str, best: Angles | None, file: Path
) -> Path:
    """Draw a calibration; returns the file.

    Args:
        search: Its runs.
        target: What they are compared with.
        label: Name and unit of the parameter.
        best: The angle of the best run, beside a measured history; None: no panel of it.
        file: To be written.
    """
    return save(lambda: _figure(search, target, label, best), file)


def _figure(search: Search, target: Target, label: str, best: Angles | None) -> Figure:
    """One panel, or two with a measured history."""
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
        low, high = _bracket(search)
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


def _bracket(search: Search) -> tuple[Trial, Trial]:
    """The neighbours of the best run."""
    number = search.trials.index(search.best)
    return search.trials[max(number - 1, 0)], search.trials[min(number + 1, len(search.trials) - 1)]


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
