"""The heat-maps of the stability study: a grid for each family."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from benchmarks.stability.verdict import LARGEST_GAIN, Verdict
from solver.pictures.style import GREY, PURPLE, RED, new_figure, save
from solver.study.tables import groups

LEAST_GAIN = 1e-14
"""Gains below this, and losses, are drawn as it."""

COLOURS = {"ended": PURPLE, "refused": GREY, "failed": RED}
"""Colours of scenes that do not hold, by their verdicts."""

PANELS_ACROSS = 3
"""Families side by side."""


def picture(verdicts: Sequence[Verdict], file: Path) -> Path:
    """Draw all families that are grids; returns the file."""
    return save(lambda: draw(verdicts), file)


def draw(verdicts: Sequence[Verdict]) -> Figure:
    """The figure, a panel for each family."""
    families = groups(verdicts, lambda verdict: verdict.family)
    across = min(PANELS_ACROSS, len(families))
    down = math.ceil(len(families) / max(1, across))
    figure = new_figure(1.75 * down + 0.5, width=4.0 * across + 1.0)
    panels = figure.subplots(down, across, squeeze=False).ravel()
    scale = Normalize(math.log10(LEAST_GAIN), math.log10(LARGEST_GAIN))
    image = None
    for axes, (family, inside) in zip(panels, families.items(), strict=False):
        image = _panel(axes, family, inside, scale)
    for axes in panels[len(families) :]:
        axes.set_axis_off()
    if image is not None:
        tall = down > 2
        bar = figure.colorbar(image, ax=list(panels), shrink=0.4 if tall else 1.0, aspect=40)
        where = " " if tall else "\n"
        bar.set_label(f"log10 of the energy gain;{where}pink: ended, grey: refused, red: failed")
    return figure


def _panel(axes: Axes, family: str, verdicts: Sequence[Verdict], scale: Normalize) -> Any:
    """One family: colours for the energy gain, and for scenes that do not hold."""
    rows = list(dict.fromkeys(verdict.row for verdict in verdicts))
    columns = list(dict.fromkeys(verdict.column for verdict in verdicts))
    if len(columns) == 1:  # random scenes, a list: as a block of ten to a line
        rows, columns = [str(10 * k) for k in range(math.ceil(len(rows) / 10))], list("0123456789")
        places = [divmod(k, 10) for k in range(len(verdicts))]
    else:
        places = [(rows.index(v.row), columns.index(v.column)) for v in verdicts]
    gain = np.full((len(rows), len(columns)), np.nan)
    for place, verdict in zip(places, verdicts, strict=True):
        if verdict.verdict == "holds":
            gain[place] = math.log10(max(LEAST_GAIN, verdict.energy_gain))
        else:
            axes.add_patch(_square(place, COLOURS[verdict.verdict]))
    image = axes.imshow(gain, norm=scale, cmap="viridis", aspect="auto")
    axes.set_title(family)
    axes.set_xticks(range(len(columns)), columns, rotation=35, ha="right", fontsize=6)
    axes.set_yticks(range(len(rows)), rows, fontsize=6)
    axes.grid(False)
    return image


def _square(place: tuple[int, int], colour: str) -> Rectangle:
    """A cell of one colour."""
    return Rectangle((place[1] - 0.5, place[0] - 0.5), 1, 1, facecolor=colour, zorder=2)
