"""Pictures of a study of overturning: amplitude against frequency, and against restitution."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from solver.pictures.style import (
    BLUE,
    DASHES,
    GREY,
    ORANGE,
    RED,
    legend_above,
    new_figure,
)
from solver.study.overturning.blocks import PULSES
from solver.study.overturning.boundaries import DIRECTLY, LATER, STAYS
from solver.study.overturning.numbers import LINEAR, kinds
from solver.study.tables import groups

Row = Mapping[str, Any]

COLOURS = {DIRECTLY: BLUE, LATER: ORANGE}
ORDINATE = r"amplitude / $(g \tan\alpha)$"
ABSCISSAE = {"frequency": "frequency of the pulse, ω/p", "restitution": "restitution e"}


def overturning_picture(
    over: str, rows: Sequence[Row], others: Sequence[Row], title: str, top: float
) -> Figure:
    """What overturns a rigid block, a panel for each pulse, over restitution also each frequency.

    Args:
        over: "frequency" or "restitution".
        rows: Of rigid blocks, over frequency of one restitution.
        others: Of elastic blocks, drawn as marks.
        title: What is said of all panels: slenderness, restitution, friction.
        top: Largest amplitude of the scan.
    """
    apart = over == "restitution"
    parts = groups(rows, lambda row: (row["pulse"], row["frequency"] if apart else None))
    figure = new_figure(2.9 * len(parts) + 0.6)
    panels = figure.subplots(len(parts), 1, squeeze=False, sharex=True)[:, 0]
    for axes, ((pulse, frequency), inside) in zip(panels, parts.items(), strict=True):
        own = sorted(inside, key=lambda row: row[over])
        _areas(axes, own, top, over)
        beside = [row for row in others if row["pulse"] == pulse]
        if at := _places(beside, over):
            style: dict[str, Any] = {"markerfacecolor": "none", "markeredgewidth": 1.2}
            axes.plot(*at, "o", color=RED, label="elastic block", markersize=5, **style)
        first, last = own[0][over], own[-1][over]
        if pulse in LINEAR:
            along = np.linspace(first, last, 200)
            linear = [LINEAR[pulse](float(frequency or s)) for s in along]
            words = "slender block, without impact, closed form"
            axes.plot(along, linear, color="black", linestyle=DASHES, linewidth=0.9, label=words)
        axes.set(ylim=(0, top), xlim=(first, last), ylabel=ORDINATE)
        of = f", ω/p = {frequency:g}" if apart else ""
        axes.set_title(f"{PULSES[pulse].words}{of}: {title}", loc="left")
    panels[-1].set_xlabel(ABSCISSAE[over])
    legend_above(figure, columns=2)
    return figure


def _places(rows: Sequence[Row], over: str) -> list[tuple[float, ...]]:
    """Abscissae and amplitudes of all boundaries; empty where there is none."""
    at = [(row[over], edge["amplitude"]) for row in rows for edge in row["boundaries"]]
    return list(zip(*at, strict=True))


def _intervals(row: Row, top: float) -> Iterator[tuple[float, float, str]]:
    """Intervals of amplitude and what comes of them, from 0 to the top."""
    edges = [0.0, *(edge["amplitude"] for edge in row["boundaries"]), top]
    words = kinds(row) or (STAYS,)
    for (low, high), word in zip(pairwise(edges), words, strict=True):
        yield low, high, word


def _areas(axes: Axes, rows: Sequence[Row], top: float, over: str = "frequency") -> None:
    """Areas between neighbours: joined where they have the same kinds."""
    for low, high in pairwise(rows):
        first, last = low[over], high[over]
        if kinds(low) == kinds(high):
            ends = [(first, last, low, high)]
        else:
            middle = (first + last) / 2
            ends = [(first, middle, low, low), (middle, last, high, high)]
        for left, right, one, other in ends:
            for (a, b, word), (c, d, _) in zip(
                _intervals(one, top), _intervals(other, top), strict=True
            ):
                if word != STAYS:
                    axes.fill([left, left, right, right], [a, b, d, c], color=COLOURS[word],
                              alpha=0.45, linewidth=0, label=f"rigid block {word}")  # fmt: skip
    if at := _places(rows, over):
        axes.plot(*at, ".", color=GREY, markersize=2, label="boundaries found")
