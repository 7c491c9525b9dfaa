"""The picture of a study of modes: maps over friction and acceleration, with their boundaries."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from solver.pictures.style import BLUE, GREEN, GREY, ORANGE, RED, legend_above, new_figure
from solver.reference.initiation import initial_mode, rocking_friction
from solver.study.modes.numbers import Row

COLOURS = {"rest": GREY, "slide": BLUE, "rock": GREEN, "slide-rock": ORANGE}
MARKS = {"rest": "o", "slide": "s", "rock": "^", "slide-rock": "D"}
MARGIN = 0.04
"""Between marks and edges of a panel, over the largest value."""

ROUND: dict[str, Any] = {"markersize": 9, "markerfacecolor": "none", "markeredgewidth": 1.4}


def modes_picture(points: Sequence[Row]) -> Figure:
    """A panel for each engine and slenderness."""
    engines = list(dict.fromkeys(point["engine"] for point in points))
    ratios = list(dict.fromkeys(point["ratio"] for point in points))
    figure = new_figure(2.6 * len(ratios) + 0.5)
    panels = figure.subplots(len(ratios), len(engines), squeeze=False, sharex="row", sharey="row")
    for line, ratio in zip(panels, ratios, strict=True):
        for axes, engine in zip(line, engines, strict=True):
            chosen = [p for p in points if (p["engine"], p["ratio"]) == (engine, ratio)]
            _panel(axes, chosen, ratio)
            axes.set_title(f"{engine} block, H/B = {ratio:g}", loc="left")
        line[0].set_ylabel("friction coefficient mu")
    for axes in panels[-1]:
        axes.set_xlabel("acceleration of the base, A = a_g/g\nopen marks: within 3 % of a boundary")
    legend_above(figure, columns=4)
    return figure


def _panel(axes: Axes, points: Sequence[Row], ratio: float) -> None:
    """Areas of the modes, their boundaries, and the points."""
    values = [[p[key] for p in points] for key in ("acceleration_g", "friction")]
    low = [min(each) - MARGIN * max(each) for each in values]
    high = [(1 + MARGIN) * max(each) for each in values]
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    _boundaries(axes, ratio, high)
    for mode, mark in MARKS.items():
        for judged in (True, False):
            found = [p for p in points if p["mode"] == mode and p["judged"] == judged]
            style: dict[str, Any] = {"color": COLOURS[mode], "markersize": 4, "linestyle": "none"}
            if not judged:
                style |= {"markerfacecolor": "white", "markeredgewidth": 0.8}
            x, y = [p["acceleration_g"] for p in found], [p["friction"] for p in found]
            axes.plot(x, y, marker=mark, label=mode if judged else None, **style)
    wrong = [p for p in points if p["judged"] and not p["agrees"]]
    at = [p["acceleration_g"] for p in wrong], [p["friction"] for p in wrong]
    axes.plot(*at, "o", color=RED, label="disagrees" if wrong else None, **ROUND)


def _boundaries(axes: Axes, ratio: float, high: Sequence[float]) -> None:
    """Shenton's boundaries: A = mu, A = B/H, mu = B/H and mu = mu_R(A)."""
    uplift = 1 / ratio
    line: dict[str, Any] = {"color": "black", "linewidth": 0.9}
    axes.plot([0, uplift], [0, uplift], **line)
    axes.plot([uplift, uplift], [uplift, high[1]], **line)
    axes.plot([uplift, high[0]], [uplift, uplift], **line)
    along = np.linspace(uplift, high[0], 200)
    axes.plot(along, [rocking_friction(float(a), ratio) for a in along], **line)
    x, y = np.meshgrid(np.linspace(0, high[0], 300), np.linspace(0, high[1], 300))
    names = list(COLOURS)
    shade = np.vectorize(lambda a, mu: names.index(initial_mode(a, mu, ratio)))(x, y)
    levels = np.arange(len(names) + 1) - 0.5
    axes.contourf(x, y, shade, levels=levels, colors=list(COLOURS.values()), alpha=0.12)
