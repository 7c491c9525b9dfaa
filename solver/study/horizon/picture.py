"""The picture of a study of horizons: how the difference of run and twin grows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from solver.pictures.style import DASHES, GREY, colour, legend_above, new_figure
from solver.run.twin import APART

LEAST = 1e-14
"""Smallest difference that is drawn, over alpha."""


def horizon_picture(rows: Sequence[Mapping[str, Any]]) -> Figure:
    """A panel for each run."""
    figure = new_figure(2.3 * len(rows) + 0.5)
    panels = figure.subplots(len(rows), 1, squeeze=False, sharex=True, sharey=True)[:, 0]
    for axes, row in zip(panels, rows, strict=True):
        for number, twin in enumerate(row["twins"]):
            apart = np.maximum(twin["difference"], LEAST)
            label = f"{twin['perturbation']:g} more"
            axes.semilogy(twin["time"], apart, color=colour(number), linewidth=0.8, label=label)
            if twin["horizon_s"] is not None:
                axes.axvline(twin["horizon_s"], color=colour(number), linewidth=0.6, linestyle=":")
        axes.axhline(APART, color=GREY, linestyle=DASHES, linewidth=0.8)
        axes.set(ylabel="|difference| / alpha", ylim=(LEAST, 20))
        scale = "" if row["scale"] == 1 else f", motion times {row['scale']:g}"
        name = f"{row['engine']} block" if row["engine"] else "the scene"
        axes.set_title(f"{name}{scale}", loc="left")
    panels[-1].set_xlabel("time (s)")
    legend_above(figure, columns=4)
    return figure
