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
    GREEN,
    GREY,
    ORANGE,
    RED,
    colour,
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


def overturning_picture(
    rows: Sequence[Row], others: Sequence[Row], title: str, top: float
) -> Figure:
    """What overturns a rigid block, a panel for each pulse.

    Args:
        rows: Of rigid blocks of one restitution.
        others: Of other engines, drawn as marks.
        title: What is said of all panels: slenderness, restitution, friction.
        top: Largest amplitude of the scan.
    """
    pulses = groups(rows, lambda row: row["pulse"])
    figure = new_figure(2.9 * len(pulses) + 0.6)
    panels = figure.subplots(len(pulses), 1, squeeze=False, sharex=True)[:, 0]
    for axes, (pulse, inside) in zip(panels, pulses.items(), strict=True):
        own = sorted(inside, key=lambda row: row["frequency"])
        _areas(axes, own, top)
        _marks(axes, [row for row in others if row["pulse"] == pulse])
        at = np.linspace(own[0]["frequency"], own[-1]["frequency"], 200)
        if pulse in LINEAR:
            linear = [LINEAR[pulse](float(s)) for s in at]
            words = "slender block, without impact, closed form"
            axes.plot(at, linear, color="black", linestyle=DASHES, linewidth=0.9, label=words)
        axes.set(ylim=(0, top), xlim=(at[0], at[-1]), ylabel=ORDINATE)
        axes.set_title(f"{PULSES[pulse].words}: {title}", loc="left")
    panels[-1].set_xlabel("frequency of the pulse, ω/p")
    legend_above(figure, columns=2)
    return figure


def _intervals(row: Row, top: float) -> Iterator[tuple[float, float, str]]:
    """Intervals of amplitude and what comes of them, from 0 to the top."""
    edges = [0.0, *(edge["amplitude"] for edge in row["boundaries"]), top]
    words = kinds(row) or (STAYS,)
    for (low, high), word in zip(pairwise(edges), words, strict=True):
        yield low, high, word


def _areas(axes: Axes, rows: Sequence[Row], top: float) -> None:
    """Areas between neighbouring frequencies: joined where they have the same kinds."""
    for low, high in pairwise(rows):
        first, last = low["frequency"], high["frequency"]
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
    at = [(row["frequency"], edge["amplitude"]) for row in rows for edge in row["boundaries"]]
    if at:
        axes.plot(*zip(*at, strict=True), ".", color=GREY, markersize=2, label="boundaries found")


def _marks(axes: Axes, others: Sequence[Row]) -> None:
    """Boundaries of the other engines."""
    marks = {"ode": ("x", GREEN, "Housner's equation"), "elastic": ("o", RED, "elastic block")}
    for engine, (mark, tint, words) in marks.items():
        at = [
            (row["frequency"], edge["amplitude"])
            for row in others
            if row["engine"] == engine
            for edge in row["boundaries"]
        ]
        if at:
            axes.plot(
                *zip(*at, strict=True), mark, color=tint, label=words, markersize=5,
                markerfacecolor="none", markeredgewidth=1.2,
            )  # fmt: skip


def restitution_picture(rows: Sequence[Row], title: str) -> Figure:
    """The boundaries of rigid blocks against restitution, a panel for each pulse."""
    pulses = groups(rows, lambda row: row["pulse"])
    figure = new_figure(2.9 * len(pulses) + 0.4)
    panels = figure.subplots(len(pulses), 1, squeeze=False, sharex=True)[:, 0]
    for axes, (pulse, inside) in zip(panels, pulses.items(), strict=True):
        curves = groups(inside, lambda row: row["frequency"])
        for number, frequency in enumerate(sorted(curves)):
            _curve(axes, curves[frequency], colour(number))
        axes.set(ylabel=ORDINATE)
        axes.set_title(f"{PULSES[pulse].words}: {title}", loc="left")
    panels[-1].set_xlabel("restitution e")
    for style, words in (("-", "after an impact"), (DASHES, "without impact")):
        panels[0].plot([], [], color=GREY, linestyle=style, label=words)
    legend_above(figure, columns=3)
    return figure


def _curve(axes: Axes, rows: Sequence[Row], tint: str) -> None:
    """The boundaries of one frequency: lines where neighbours have the same kinds, else points."""
    ordered = sorted(rows, key=lambda row: row["restitution"])
    label = f"ω/p = {ordered[0]['frequency']:g}"
    for row in ordered:
        at = [edge["amplitude"] for edge in row["boundaries"]]
        axes.plot([row["restitution"]] * len(at), at, ".", color=tint, markersize=3)
    for low, high in pairwise(ordered):
        if kinds(low) == kinds(high):
            for one, other in zip(low["boundaries"], high["boundaries"], strict=True):
                ends = [one["amplitude"], other["amplitude"]]
                style = DASHES if {one["below"], one["above"]} == {STAYS, DIRECTLY} else "-"
                across = [low["restitution"], high["restitution"]]
                axes.plot(across, ends, color=tint, linestyle=style, label=label)
