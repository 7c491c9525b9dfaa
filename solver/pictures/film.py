"""Films of runs: `rockslip animate`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np

from solver.errors import SceneError
from solver.excitation.sampled import running_integral
from solver.fields.contacts import LONGEST, arrow_of_weight, largest_weight
from solver.fields.ground import floor_level
from solver.pictures.contact import (
    BlockFrames,
    State,
    block_frames,
    interpolated,
    pair_frames,
)
from solver.pictures.encode import encoder_for
from solver.pictures.ground import add_ground
from solver.pictures.links import LinkFrames, legend_handles, links_of, states_in
from solver.pictures.meshes import Bodies, bodies_of
from solver.pictures.renderer import (
    Pixels,
    Renderer,
    arrow,
    bars,
    display,
    in_front,
    in_view,
)
from solver.pictures.style import (
    STRESS,
    STYLE,
    colour,
    least_span,
    new_figure,
    stress_unit,
    zero_line,
)
from solver.results.moving import moving_span
from solver.results.runs import Run, labels
from solver.types import Array

SHORTEST = 6.0
"""A film that would be shorter is slowed down to last so long, s."""

MOST_FRAMES = 3000
"""A film has no more frames than this."""

BETWEEN = 160
"""Grey of the line between two shots."""

FOLLOWED_DISTANCE = 1.5
"""Bodies that leave are followed this far to a side, over the size of all at the start."""

#: Colours of arrows and rigid bodies by state, and of what is no block.
FORCE = {State.STICKS: "#2aa9ff", State.SLIPS: "#ff6a00", State.OPEN: "#2aa9ff"}
BODY = {State.STICKS: "#c9d3df", State.SLIPS: "#f6cf9b", State.OPEN: "#e8f4e4"}
PLATFORM = "#b5b5b5"

#: An arrow is not drawn where it is shorter than this, over the one of the largest weight.
SHORTEST_ARROW = 0.03

#: Height of a heading, and of a line of its legend more, in.
HEADING, LEGEND = 0.62, 0.2

#: Pixels an inch of the still parts.
RESOLUTION = 100

#: How pale what is still to come is drawn: part of white.
PALE = 0.62

MARK = np.array([200, 30, 30], dtype=np.uint8)


@dataclass(frozen=True, slots=True, kw_only=True)
class FilmOptions:
    """Options of a film."""

    fixed: bool = False
    """Show the ground in motion, from a place at rest; else it stands still."""
    slow: float | None = None
    """Seconds of the film for each second of the run; None: 1, or what makes it last 6 s."""
    begin: float | None = None
    """First time, s; None: when something begins to move."""
    end: float | None = None
    """Last time, s; None: when all is at rest."""
    width: int = 960
    """Width of the picture, pixels."""


def film(runs: Sequence[Run], file: Path, options: FilmOptions) -> None:
    """Film runs side by side into a file, whose name ends with .mp4 or .gif."""
    encoder = encoder_for(file)
    dimensions = {run.scene.dimension for run in runs}
    if len(dimensions) > 1:
        raise SceneError(
            str(runs[-1].folder), "a run in another dimension", "runs of one dimension"
        )
    span = _span(runs, options)
    times = frame_times(span, options.slow, encoder.frames_per_second)
    shots = [Shot(run, times, fixed=options.fixed) for run in runs]
    with display():
        draft = file.with_name(f"{file.stem}.part{file.suffix}")
        try:
            encoder.write(_frames(shots, span, options.width), draft)
            draft.replace(file)
        finally:
            draft.unlink(missing_ok=True)


def _span(runs: Sequence[Run], options: FilmOptions) -> tuple[float, float]:
    """First and last time that is shown, s."""
    spans = [moving_span(run.scene, run.history) for run in runs]
    begin = min(span[0] for span in spans) if options.begin is None else options.begin
    end = max(span[1] for span in spans) if options.end is None else options.end
    last = max(float(run.history["time_s"][-1]) for run in runs)
    if not 0 <= begin < end:
        raise SceneError("--from, --until", f"{begin:g} and {end:g}", "0 <= from < until, s")
    if begin >= last:
        raise SceneError("--from", f"{begin:g}", f"less than the end of the run, {last:g} s")
    return begin, min(end, last)


def frame_times(span: tuple[float, float], slow: float | None, rate: int) -> Array:
    """Times of the frames, s, at so many frames a second."""
    lasts = span[1] - span[0]
    factor = max(1.0, SHORTEST / lasts) if slow is None else slow
    count = max(2, round(lasts * factor * rate) + 1)
    if count > MOST_FRAMES:
        raise SceneError(
            "--slow", f"{factor:g}, which makes {count} frames", f"at most {MOST_FRAMES} frames"
        )
    return np.asarray(np.linspace(*span, count), dtype=np.float64)


def _frames(shots: Sequence[Shot], span: tuple[float, float], width: int) -> Iterator[Pixels]:
    """The frames, one by one."""
    runs, limit = [shot.run for shot in shots], max(shot.bodies.stress_limit for shot in shots)
    low, high = _window(shots)
    size = _shot_size(low, high, width // len(shots))
    corners = np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(len(low), -1).T
    window = in_view(corners).min(axis=0), in_view(corners).max(axis=0)
    beyond = 2 * float(np.max(high - low))
    states = states_in(link for shot in shots for link in shot.links)
    heading, strip = draw_heading(runs, limit, width, states), draw_strip(runs, span, width)
    renderers = [
        Renderer(size, low, high, window=window, floor=each.floor, limit=limit, beyond=beyond)
        for each in shots
    ]
    try:
        for frame, time in enumerate(shots[0].times):
            pictures = [
                shot.draw(renderer, frame) for shot, renderer in zip(shots, renderers, strict=True)
            ]
            for picture in pictures[1:]:
                picture[:, :1] = BETWEEN
            middle = _wide(np.concatenate(pictures, axis=1), width)
            top = _with_time(heading, time)
            yield np.concatenate([_wide(top, width), middle, _wide(strip.at(time), width)])
    finally:
        for renderer in renderers:
            renderer.close()


def _window(shots: Sequence[Shot]) -> tuple[Array, Array]:
    """Least and greatest place that all shots show, m, with room for the floor."""
    low = np.min([shot.low for shot in shots], axis=0)
    high = np.max([shot.high for shot in shots], axis=0)
    margin = 0.08 * float(np.max(high - low))
    low[-1] = min(low[-1], min(shot.floor for shot in shots))
    return low - margin, high + margin


def _shot_size(low: Array, high: Array, width: int) -> tuple[int, int]:
    """Width and height of a shot, pixels: as what it shows, within bounds."""
    extent = high - low
    ratio = float(extent[-1] / (extent[0] if len(extent) == 2 else np.hypot(*extent[:2])))
    return width, round(width * min(max(ratio, 0.4), 0.62 if width > 600 else 0.8))


def _with_time(heading: Pixels, time: float) -> Pixels:
    """The heading with the time at its right end."""
    from matplotlib import get_data_path
    from PIL import Image, ImageDraw, ImageFont

    picture = Image.fromarray(heading)
    font: Any = ImageFont.truetype(f"{get_data_path()}/fonts/ttf/DejaVuSans.ttf", 15)
    place = (picture.width - 12, round(0.06 * RESOLUTION))
    ImageDraw.Draw(picture).text(place, f"t = {time:.2f} s", fill="black", font=font, anchor="ra")
    return np.asarray(picture)


def _wide(pixels: Pixels, width: int) -> Pixels:
    """Pixels cut or filled up with white to a width."""
    missing = max(0, width - pixels.shape[1])
    return np.pad(pixels, ((0, 0), (0, missing), (0, 0)), constant_values=255)[:, :width]


class Shot:
    """One run, frame by frame: bodies, forces, the path of the ground, and the window."""

    def __init__(self, run: Run, times: Array, *, fixed: bool):
        """Take a run at the times of the frames, s.

        It is seen from the ground, or `fixed`: from a place at rest.
        """
        scene = run.scene
        self.run, self.times, self.floor = run, times, floor_level(scene)
        self._blocks = {block.name: block_frames(run, block, times) for block in scene.blocks}
        self._pairs = pair_frames(run, times)
        self.links = links_of(run, times)
        blocks = list(self._blocks.values())
        self.bodies: Bodies = bodies_of(run, times)
        self._ground = ground_path(run, times) if fixed else np.zeros((len(times), scene.dimension))
        self.low, self.high = _extent(blocks, self.bodies, self.links, self._ground)
        """Least and greatest place of the bodies in all frames, m, (d,)."""
        self._unit = arrow_of_weight(scene)
        """Length of an arrow that stands for the largest weight, m."""
        self._weight = largest_weight(scene)
        """The largest weight, N."""

    def draw(self, renderer: Renderer, frame: int) -> Pixels:
        """The picture of a frame."""
        blocks, arrows = self._blocks, []
        bodies = [
            (surface, BODY[blocks[name].push.states[frame]] if name in blocks else PLATFORM)
            for name, surface in zip(self.bodies.names, self.bodies.at(frame), strict=True)
        ]
        for push in (*(block.push for block in blocks.values()), *self._pairs):
            force, state, place = push.force[frame], push.states[frame], push.place[frame]
            length = float(np.linalg.norm(force)) * push.weight / self._weight
            if length >= SHORTEST_ARROW:
                drawn = self._unit * min(length, LONGEST)
                hue = FORCE[state]
                arrows.append((arrow(in_front(place), force, drawn, unit=self._unit), hue))
        arrows += bars(self.links, frame, unit=self._unit)
        return renderer.draw(bodies, arrows, self._ground[frame])


def ground_path(run: Run, times: Array) -> Array:
    """Displacement of the ground, m, (n, d): its acceleration integrated twice from rest."""
    history, dimension = run.history, run.scene.dimension
    time = history["time_s"]
    path = np.zeros((len(time), dimension))
    axes = {"acceleration_m_s2": 0, "second_acceleration_m_s2": 1}
    axes["vertical_acceleration_m_s2"] = dimension - 1
    for name, axis in axes.items():
        if f"base.{name}" in history:
            velocity = running_integral(time, history[f"base.{name}"])
            path[:, axis] = running_integral(time, velocity)
    return interpolated(time, path, times)


def _extent(
    blocks: Sequence[BlockFrames], bodies: Bodies, links: Sequence[LinkFrames], ground: Array
) -> tuple[Array, Array]:
    """Least and greatest place of all that is shown, m."""
    start = np.concatenate([np.asarray(surface.points) for surface in bodies.at(0)])
    start = start[:, : ground.shape[1]]
    first, last = start.min(axis=0), start.max(axis=0)
    away = FOLLOWED_DISTANCE * float((last - first).max())
    low, high = first + ground.min(axis=0), last + ground.max(axis=0)
    for block in blocks:
        middle = block.centres + ground
        reach = block.frames @ block.corners.T
        low = np.minimum(low, (middle + reach.min(axis=2)).min(axis=0))
        high = np.maximum(high, (middle + reach.max(axis=2)).max(axis=0))
    for link in links:
        ends = link.ends + ground[:, None]
        low = np.minimum(low, ends.min(axis=(0, 1)))
        high = np.maximum(high, ends.max(axis=(0, 1)))
    return np.maximum(low, first - away), np.minimum(high, last + away)


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


def draw_heading(
    runs: Sequence[Run], limit: float, width: int, states: Sequence[int] = ()
) -> Pixels:
    """The titles of the runs, each over its shot, and what colours mean."""
    high = HEADING + LEGEND * bool(states)
    with mpl.rc_context(STYLE):
        figure = new_figure(high, width=width / RESOLUTION)
        figure.set_dpi(RESOLUTION)
        figure.set_layout_engine("none")
        for number, (run, label) in enumerate(zip(runs, labels(runs), strict=True)):
            title = run.scene.title or label if len(runs) == 1 else label
            left = (number + 0.5) / len(runs) if len(runs) > 1 else 0.012
            side = "center" if len(runs) > 1 else "left"
            look = {"va": "top", "fontsize": 11, "weight": "bold"}
            figure.text(left, 1 - 0.043 / high, title, ha=side, **look)
        _add_legend(figure, limit, states)
        return _pixels(figure)


def _add_legend(figure: Any, limit: float, states: Sequence[int] = ()) -> None:
    """The colours of arrows and rigid bodies, and of stress; below, of links in their states."""
    from matplotlib.patches import Patch

    wide, high = figure.get_size_inches()
    look = {"loc": "lower left", "handlelength": 1.2, "fontsize": 8.5}
    handles = [
        Patch(
            facecolor=BODY[s] if limit == 0 else FORCE[s],
            edgecolor=FORCE[s],
            label=f"contact force, {s.value}",
        )
        for s in (State.STICKS, State.SLIPS)
    ]
    base = LEGEND * bool(states)  # in
    figure.legend(handles=handles, bbox_to_anchor=(0.0, (base - 0.037) / high), ncols=3, **look)
    if states:
        lines = legend_handles(states)
        figure.legend(handles=lines, bbox_to_anchor=(0.0, -0.037 / high), ncols=4, **look)
    if limit > 0:
        unit, factor = stress_unit(limit)
        # Inches from the right: the label, the bar, the zero.
        label, bar = 1.62, 1.0
        left = 1 - (label + bar) / wide
        axes = figure.add_axes((left, (base + 0.186) / high, bar / wide, 0.08 / high))
        axes.imshow(np.linspace(0, 1, 256)[None], aspect="auto", cmap=STRESS, extent=(0, 1, 0, 1))
        axes.set_axis_off()
        middle, text = (base + 0.223) / high, {"va": "center", "fontsize": 8.5}
        figure.text(left - 0.05 / wide, middle, "0", ha="right", **text)
        figure.text(
            1 - (label - 0.05) / wide,
            middle,
            f"{factor * limit:.3g} {unit} von Mises",
            ha="left",
            **text,
        )


def _pixels(figure: Any) -> Pixels:
    """A figure as it is drawn."""
    figure.canvas.draw()
    return np.asarray(figure.canvas.buffer_rgba())[:, :, :3].copy()
