"""Style of the pictures: sizes, colours, lines."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter
from numpy.typing import NDArray

#: Colours that remain distinct for colour-blind readers (Okabe and Ito 2008).
BLUE, ORANGE, GREEN, RED = "#0072B2", "#E69F00", "#009E73", "#D55E00"
PURPLE, SKY, GREY = "#CC79A7", "#56B4E9", "#666666"
PALETTE = (BLUE, RED, GREEN, PURPLE, ORANGE, SKY)

#: Colours of bodies without stress, of the floor and its edge, and the map of stresses.
PLAIN, FLOOR, FLOOR_EDGE, STRESS = "#d9dee5", "#dddddd", "#999999", "viridis"

DASHES = (0, (4, 1.5))

#: Width of a column of text, in.
WIDTH = 6.3

STYLE = {
    "font.size": 9.0,
    "axes.titlesize": 9.0,
    "axes.linewidth": 0.6,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e6e6e6",
    "grid.linewidth": 0.5,
    "hatch.linewidth": 0.4,
    "legend.frameon": False,
    "legend.handlelength": 2.4,
    "lines.linewidth": 1.1,
    "pdf.fonttype": 42,
    "savefig.dpi": 200,
    "svg.fonttype": "none",
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
}


def new_figure(height: float, width: float = WIDTH) -> Any:
    """A figure of that size (in) that needs no screen and leaves no global state behind."""
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def save(draw: Callable[[], Figure], file: Path) -> Path:
    """Draw a figure in the style of all, and write it in the format of the file's name."""
    return save_as(draw, file.with_suffix(""), [file.suffix.removeprefix(".")])[0]


def save_as(draw: Callable[[], Figure], stem: Path, formats: Sequence[str]) -> list[Path]:
    """Draw a figure in the style of all, and write it in some formats; returns the files."""
    files = [stem.with_name(f"{stem.name}.{ending}") for ending in formats]
    with mpl.rc_context(STYLE):
        figure = draw()
        for file in files:
            figure.savefig(file)
    return files


def zero_line(axes: Axes) -> None:
    """A thin line at zero, behind the curves."""
    axes.axhline(0, color=GREY, linewidth=0.5, zorder=0)


def least_span(axes: Axes, least: float) -> None:
    """Show at least -least to least: what stands still shall look like it."""
    low, high = axes.get_ylim()
    axes.set_ylim(min(low, -least), max(high, least))


def plain_periods(axes: Axes) -> None:
    """Periods on a logarithmic axis as 0.1, 1 and 10 s."""
    axes.xaxis.set_major_formatter(FormatStrFormatter("%g"))
    axes.set_xlabel("period (s)")


def legend_above(figure: Any, columns: int = 4) -> None:
    """One legend above all panels that names each curve once, in rows of equal length.

    It has fewer columns where so many are wider than the figure.
    """
    found: dict[str, Any] = {}
    for axes in figure.axes:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            found.setdefault(label, handle)
    if found:
        handles, labels = list(found.values()), list(found)
        renderer = FigureCanvasAgg(figure.figure).get_renderer()  # that of all its parts
        for most in range(columns, 0, -1):
            rows = math.ceil(len(labels) / most)
            legend = figure.legend(
                handles, labels, loc="outside upper center", ncols=math.ceil(len(labels) / rows)
            )
            if most == 1 or legend.get_window_extent(renderer).width <= figure.bbox.width:
                break
            legend.remove()


def legend_over(axes: Any, columns: int = 5) -> None:
    """The legend of a panel above it, where no curve is."""
    axes.legend(
        loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=columns, borderpad=0.1, columnspacing=1.2
    )


def stress_unit(limit: float) -> tuple[str, float]:
    """Unit of stresses up to a limit, Pa, and how many there are in one Pa."""
    return ("MPa", 1e-6) if limit >= 1e5 else ("kPa", 1e-3)


def colour(number: int) -> str:
    """The colour of the curve of that number."""
    return PALETTE[number % len(PALETTE)]


def largest(values: NDArray[np.float64]) -> float:
    """Largest magnitude among what is known; 0 where nothing is."""
    known = np.abs(values[np.isfinite(values)])
    return float(np.max(known, initial=0.0))
