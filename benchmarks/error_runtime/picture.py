"""The work-precision picture: error against seconds, one line for each family."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from benchmarks.error_runtime.findings import Beside, Findings
from solver.pictures.style import GREY, PALETTE, new_figure, save

#: One for each family; colours come round earlier.
MARKERS = "osD^vP*<>Xhp"

#: Markers of other programs.
OTHER_PROGRAMS_MARKERS = "1234+x"

#: Errors below this are drawn at it: they are round-off, or 0.
LEAST_ERROR = 1e-12

#: Height of a panel, in.
PANEL_HEIGHT = 2.5


def picture(findings: Findings, file: Path, measures: Sequence[str]) -> Path:
    """Draw a panel for each of these measures; returns the file."""
    return save(lambda: draw(findings, measures), file)


def draw(findings: Findings, measures: Sequence[str]) -> Figure:
    """The figure, a panel for each of these measures."""
    figure = new_figure(PANEL_HEIGHT * len(measures) + 0.3)
    panels = figure.subplots(len(measures), 1, sharex=True, squeeze=False)[:, 0]
    for axes, measure in zip(panels, measures, strict=True):
        _panel(axes, findings, measure)
        axes.legend(
            loc="center left", bbox_to_anchor=(1.01, 0.5), fontsize=7, title_fontsize=7,
            title="slope against time; order", alignment="left", handlelength=1.6,
        )  # fmt: skip
    panels[-1].set_xlabel("time in the loop (s)")
    return figure


def _panel(axes: Axes, findings: Findings, measure: str) -> None:
    """The lines of all families, the floor of the reference, and the others."""
    axes.set(xscale="log", yscale="log", ylabel="relative error", title=findings.names[measure])
    for number, family in enumerate(findings.families):
        line = findings.line(family, measure)
        if not line:
            continue
        slope = findings.slope(family, measure)
        told = "" if math.isnan(slope.order) else f"  {slope.time:.1f}; {slope.order:.1f}"
        axes.plot(
            [trial.loop_s for trial, _ in line],
            [max(error, LEAST_ERROR) for _, error in line],
            marker=MARKERS[number % len(MARKERS)],
            markersize=3.5,
            linestyle="-" if family.own else ":",
            color=(*PALETTE, "black", GREY)[number % (len(PALETTE) + 2)],
            label=f"{family.name}{told}",
        )
    for number, other in enumerate(o for o in findings.others if o.measure == measure):
        _draw_other(axes, other, OTHER_PROGRAMS_MARKERS[number % len(OTHER_PROGRAMS_MARKERS)])
    axes.axhline(findings.target, color=GREY, linewidth=0.6, linestyle=(0, (1, 2)), zorder=0)
    _floor(axes, findings.references[measure].floor)


def _draw_other(axes: Axes, other: Beside, marker: str) -> None:
    """A point of another program; a level where its time is not known."""
    label = f"{other.program}{f' ({other.note})' if other.note else ''}"
    error = max(other.error, LEAST_ERROR)
    if not math.isnan(other.seconds):
        axes.plot(
            [other.seconds], [error], linestyle="none", marker=marker, markersize=7,
            color="black", label=label,
        )  # fmt: skip
        return
    axes.axhline(error, linestyle="-.", linewidth=0.6, color=GREY)
    axes.annotate(
        label, (0.99, error), xycoords=("axes fraction", "data"), ha="right", va="bottom",
        fontsize=6, color=GREY,
    )  # fmt: skip


def _floor(axes: Axes, floor: float) -> None:
    """Grey below what the reference can tell."""
    low, high = axes.get_ylim()
    if np.isfinite(floor) and floor > low:
        axes.axhspan(low, min(floor, high), color=GREY, alpha=0.12, linewidth=0, zorder=0)
        axes.set_ylim(low, high)
