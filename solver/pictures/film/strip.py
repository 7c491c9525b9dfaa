"""The still parts of a film, above and below the stage: title, legend, accelerogram and angle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np

from solver.pictures.film.contact import State
from solver.pictures.film.encode import Pixels
from solver.pictures.film.stage import BODY, FORCE, STRESS
from solver.pictures.ground import add_ground
from solver.pictures.style import STYLE, colour, least_span, new_figure, zero_line
from solver.results.runs import Run, labels

#: Pixels an inch of the still parts.
RESOLUTION = 100

#: How pale what is still to come is drawn: part of white.
PALE = 0.62

MARK = np.array([200, 30, 30], dtype=np.uint8)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Strip:
    """Histories with a mark that moves with the time."""

    pixels: Pixels
    panels: list[tuple[int, int, int, int]]
    """First and last row and column of each panel."""
    span: tuple[float, float]
    """First and last time, s."""

    def at(self, time: float) -> Pixels:
        """The strip at a time, s: what is still to come is pale."""
        drawn = self.pixels.copy()
        part = (time - self.span[0]) / (self.span[1] - self.span[0])
        for top, bottom, left, right in self.panels:
            column = left + round(part * (right - left))
            rest = drawn[top:bottom, column : right + 3]
            rest[:] = (PALE * 255 + (1 - PALE) * rest).astype(np.uint8)
            drawn[top:bottom, max(column - 1, left) : column + 1] = MARK
        return drawn


def draw_strip(runs: Sequence[Run], span: tuple[float, float], width: int) -> Strip:
    """The acceleration of the ground, where it moves, above the angles of the blocks."""
    moving = [run for run in runs if run.scene.motion is not None]
    rows = 2 if moving else 1
    with mpl.rc_context(STYLE | {"font.size": 8.5}):
        figure = new_figure(0.85 * rows + 0.45, width=width / RESOLUTION)
        figure.set_dpi(RESOLUTION)
        panels = list(np.atleast_1d(figure.subplots(rows, 1, sharex=True)))
        if moving:
            add_ground(panels[0], moving[0])
            if panels[0].get_legend_handles_labels()[0]:
                panels[0].legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
        _add_angles(panels[-1], runs)
        panels[-1].set(xlim=span, xlabel="time (s)")
        figure.align_ylabels()
        pixels = _pixels(figure)
        boxes = [axes.get_window_extent() for axes in panels]
    height = pixels.shape[0]
    places = [(height - round(b.y1), height - round(b.y0), round(b.x0), round(b.x1)) for b in boxes]
    return Strip(pixels=pixels, panels=places, span=span)


def _add_angles(axes: Any, runs: Sequence[Run]) -> None:
    """The angle of every block; of several runs that of the last block of each."""
    curves = [
        (run, block, label if len(runs) > 1 else block.name)
        for run, label in zip(runs, labels(runs), strict=True)
        for block in (run.scene.blocks if len(runs) == 1 else run.scene.blocks[-1:])
    ]
    for number, (run, block, label) in enumerate(curves):
        angle = np.degrees(run.history[f"{block.name}.angle_rad"])
        axes.plot(run.history["time_s"], angle, color=colour(number), linewidth=1.0, label=label)
    axes.set_ylabel("angle (°)")
    least_span(axes, 1e-3)
    zero_line(axes)
    if len(curves) > 1:
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))


def draw_heading(runs: Sequence[Run], limit: float, width: int) -> Pixels:
    """The titles of the runs, each over its stage, and what colours mean."""
    with mpl.rc_context(STYLE):
        figure = new_figure(0.62, width=width / RESOLUTION)
        figure.set_dpi(RESOLUTION)
        figure.set_layout_engine("none")
        for number, (run, label) in enumerate(zip(runs, labels(runs), strict=True)):
            title = run.scene.title or label if len(runs) == 1 else label
            left = (number + 0.5) / len(runs) if len(runs) > 1 else 0.012
            side = "center" if len(runs) > 1 else "left"
            figure.text(left, 0.93, title, ha=side, va="top", fontsize=11, weight="bold")
        _add_legend(figure, limit)
        return _pixels(figure)


def _add_legend(figure: Any, limit: float) -> None:
    """The colours of arrows and rigid bodies, and of stress."""
    from matplotlib.patches import Patch

    handles = [
        Patch(
            facecolor=BODY[s] if limit == 0 else FORCE[s],
            edgecolor=FORCE[s],
            label=f"contact force, {s.value}",
        )
        for s in (State.STICKS, State.SLIPS)
    ]
    figure.legend(
        handles=handles,
        loc="lower left",
        bbox_to_anchor=(0.0, -0.06),
        ncols=3,
        title=None,
        handlelength=1.2,
        fontsize=8.5,
    )
    if limit > 0:
        unit, factor = ("MPa", 1e-6) if limit >= 1e5 else ("kPa", 1e-3)
        # Inches from the right: the label, the bar, the zero.
        wide, _ = figure.get_size_inches()
        label, bar = 1.62, 1.0
        left = 1 - (label + bar) / wide
        axes = figure.add_axes((left, 0.30, bar / wide, 0.13))
        axes.imshow(np.linspace(0, 1, 256)[None], aspect="auto", cmap=STRESS, extent=(0, 1, 0, 1))
        axes.set_axis_off()
        look = {"va": "center", "fontsize": 8.5}
        figure.text(left - 0.05 / wide, 0.36, "0", ha="right", **look)
        figure.text(
            1 - (label - 0.05) / wide,
            0.36,
            f"{factor * limit:.3g} {unit} von Mises",
            ha="left",
            **look,
        )


def _pixels(figure: Any) -> Pixels:
    """A figure as it is drawn."""
    figure.canvas.draw()
    return np.asarray(figure.canvas.buffer_rgba())[:, :, :3].copy()
