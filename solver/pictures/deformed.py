"""The bodies as they stand at some instants of a run, with their stress.

They are those of the films: in the plane drawn by matplotlib, in space by the renderer of films.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter

from solver.errors import EnvironmentTrouble
from solver.fields.contacts import arrow_of_weight
from solver.fields.ground import floor_level
from solver.fields.part import in_space
from solver.pictures.links import LOOKS, LinkFrames, legend_handles, links_of, states_in
from solver.pictures.meshes import EDGE_NORMALS, EDGES, SHARP, bodies_of, polygons, stress_of
from solver.pictures.renderer import Renderer, bars, display, in_view
from solver.pictures.style import (
    FLOOR,
    FLOOR_EDGE,
    PLAIN,
    STRESS,
    WIDTH,
    new_figure,
    stress_unit,
)
from solver.results.motion import BlockMotion
from solver.results.moving import moving_span
from solver.results.rocking import swings
from solver.results.runs import Run
from solver.run.streams import tell
from solver.scene import Scene
from solver.types import Array

#: What is wider than this over its height stands in two rows.
WIDE = 1.1

#: Heights of titles and of labels, and the width of the colour bar, in.
TITLE, LABEL, BAR = 0.45, 0.45, 0.9

#: Floor in space beyond the bodies, over their size.
BEYOND = 0.3

#: Length of a link that is drawn as a dot over that of an arrow of the weight.
DOT = 0.06

#: Pixels of the longer side of a picture in space.
PIXELS = 1000


class Instant(NamedTuple):
    """An instant, and what happens then."""

    time_s: float
    """Time, s."""
    name: str = ""
    """Name, in a word or two; empty: nothing in particular."""


def instants(run: Run) -> list[Instant]:
    """Lift-off, largest angle, landing and end of the block that leans most over its slenderness.

    Of a block that is released: the release, its landing, the peak after that, the end.
    Where it rolls, or nothing rocks, four instants evenly spread over the time of motion.
    """
    first, last = moving_span(run.scene, run.history)
    end = Instant(last, "at rest" if last < run.history["time_s"][-1] else "end")
    entries = run.summary["blocks"]
    most = max(run.scene.blocks, key=lambda b: entries[b.name]["peak_angle_over_alpha"])
    motion = BlockMotion(run.scene, run.history, most)
    found = swings(motion.time, motion.angle, motion.shape.slenderness())
    rolls = "roll" in entries[most.name]["mode"].split("-")
    if rolls or not found:
        return [Instant(float(t)) for t in np.linspace(first, last, 4)]
    if found[0].first == 0:
        return _after_release(run, most.name, last, end)
    largest = max(found, key=lambda swing: abs(swing.peak_rad))
    lift = Instant(float(motion.time[largest.first]), "lift-off")
    known = entries[most.name]
    lost = {"overturned": known["overturned_at_s"], "off its carrier": known["fell_at_s"]}
    fall, how = min(((t, how) for how, t in lost.items() if t is not None), default=(math.inf, ""))
    if fall < math.inf:
        middle = 0.5 * (lift.time_s + fall)
        return [lift, Instant(middle, "falling"), Instant(fall, how), Instant(last, "end")]
    top = Instant(largest.peak_s, "largest angle")
    if largest.last + 1 >= len(motion.time):
        return [lift, top, end]
    return [lift, top, Instant(float(motion.time[largest.last + 1]), "landing"), end]


def _after_release(run: Run, name: str, last: float, end: Instant) -> list[Instant]:
    """The instants of a block that leans at the start."""
    start = Instant(float(run.history["time_s"][0]), "release")
    block = run.summary["blocks"][name]
    impacts = [i["time_s"] for i in block["impacts"][:1]]
    after = [p["time_s"] for p in block["peaks"] if impacts and p["time_s"] > impacts[0]][:1]
    if not impacts or not after:
        return [start, *(Instant(float(t)) for t in np.linspace(start.time_s, last, 4)[1:3]), end]
    return [start, Instant(impacts[0], "landing"), Instant(after[0], "next peak"), end]


@dataclass(frozen=True, slots=True, kw_only=True)
class Snapshot:
    """The bodies at an instant."""

    instant: Instant
    surfaces: list[Any]
    """Surface of each body as `pyvista.PolyData`, m."""
    links: list[LinkFrames] = field(default_factory=list)
    """Each link, at this instant alone."""

    @property
    def places(self) -> Array:
        """Points of all surfaces, and ends of links, m, (n, 3)."""
        ends = [in_space(link.ends[0]) for link in self.links]
        return np.concatenate([*(np.asarray(s.points) for s in self.surfaces), *ends])

    @property
    def von_mises(self) -> Array:
        """Stress of each face, Pa, in the order of the polygons of the surfaces."""
        return np.concatenate([stress_of(surface) for surface in self.surfaces])


def snapshots_of(run: Run, chosen: Sequence[Instant]) -> list[Snapshot]:
    """A run at some instants; in space only what is above the floor."""
    times, floor = np.array([instant.time_s for instant in chosen]), floor_level(run.scene)
    bodies, found = bodies_of(run, times), []
    for frame, instant in enumerate(chosen):
        surfaces = bodies.at(frame)
        if run.scene.dimension == 3:
            surfaces = [_above(surface, floor) for surface in surfaces]
        links = links_of(run, times[[frame]])
        found.append(Snapshot(instant=instant, surfaces=surfaces, links=links))
    return found


def _above(surface: Any, floor: float) -> Any:
    """The part of a surface that is above the floor, but for round-off."""
    slack = 1e-6 * float(np.ptp(surface.points))
    if surface.bounds[4] >= floor - slack:
        return surface
    above = surface.clip("z", origin=(0.0, 0.0, floor), invert=False)
    if EDGES in surface.field_data:
        ends, normals = (
            np.asarray(surface.field_data[name]).reshape(-1, 2, 3) for name in (EDGES, EDGE_NORMALS)
        )
        kept = (ends[:, :, 2] >= floor - slack).all(axis=1)
        above.field_data[SHARP] = surface.field_data[SHARP]
        above.field_data[EDGES] = ends[kept].reshape(-1, 3)
        above.field_data[EDGE_NORMALS] = normals[kept].reshape(-1, 3)
    return above


def deformed_figure(run: Run, chosen: Sequence[Instant] = ()) -> Figure:
    """The bodies of a run at the instants chosen, or worth a look; the panels fill the page."""
    snapshots, dimension = snapshots_of(run, chosen or instants(run)), run.scene.dimension
    low, high = _window(snapshots, floor_level(run.scene), dimension)
    wide, high_by = high - low
    columns = _columns(float(wide / high_by), len(snapshots))
    rows = math.ceil(len(snapshots) / columns)
    panel = (WIDTH - LABEL - (BAR if _limit(snapshots) > 0 else 0.0)) / columns
    height = rows * (panel * float(high_by / wide) + TITLE) + LABEL
    figure = new_figure(min(max(height, 1.8), 8.0))
    draw_snapshots(figure, snapshots, run.scene)
    return figure


def draw_deformed(figure: Any, run: Run, chosen: Sequence[Instant]) -> None:
    """Draw the bodies at some instants, true to scale, coloured by von Mises stress."""
    draw_snapshots(figure, snapshots_of(run, chosen), run.scene)


def draw_snapshots(figure: Any, snapshots: Sequence[Snapshot], scene: Scene) -> None:
    """Draw snapshots side by side, or in two rows where they are wide.

    Where VTK cannot draw those in space, the figure says so, and so does the program. Links are as
    thick as they are in a film.
    """
    dimension, floor, unit = scene.dimension, floor_level(scene), arrow_of_weight(scene)
    low, high = _window(snapshots, floor, dimension)
    columns = _columns(float(np.divide(*(high - low))), len(snapshots))
    rows = math.ceil(len(snapshots) / columns)
    limit = _limit(snapshots)
    pictures: list[Any] = []
    if dimension == 3:
        try:
            pictures = _rendered(snapshots, (low, high), floor, limit, unit)
        except EnvironmentTrouble as error:
            tell(f"the bodies in space are not drawn: {error}\n")
            figure.text(0.5, 0.5, f"not drawn: {error}", ha="center", fontsize="small")
            return
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    name, factor = stress_unit(limit)
    for number, (axes, snapshot) in enumerate(zip(grid.ravel(), snapshots, strict=False)):
        if pictures:
            axes.imshow(pictures[number], extent=(low[0], high[0], low[1], high[1]))
        else:
            _draw_floor(axes, floor, floor - low[1])
            _draw_bodies(axes, snapshot, factor, limit)
            _draw_links(axes, snapshot, unit)
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
        axes.set_title(_title(snapshot.instant))
        axes.locator_params(axis="x", nbins=3)
        axes.xaxis.set_major_formatter(FormatStrFormatter("%g"))  # no 0.00 beside -0.25
        axes.grid(False)
    for axes in grid.ravel()[len(snapshots) :]:
        axes.set_visible(False)
    for axes in grid[-1]:
        axes.set_xlabel("x (m)" if dimension == 2 else "(m)")
    for axes in grid[:, 0]:
        axes.set_ylabel("y (m)" if dimension == 2 else "(m)")
    if limit > 0:
        colours = ScalarMappable(Normalize(0, factor * limit), STRESS)
        bar = figure.colorbar(colours, ax=list(grid.ravel()), extend="max", shrink=0.9)
        bar.set_label(f"von Mises stress ({name})")
    states = states_in(link for snapshot in snapshots for link in snapshot.links)
    if states:
        figure.legend(handles=legend_handles(states), loc="outside lower center", ncols=4)


def _rendered(
    snapshots: Sequence[Snapshot],
    window: tuple[Array, Array],
    floor: float,
    limit: float,
    unit: float,
) -> list[Any]:
    """Pictures of snapshots in space that show a window, m, as it is seen."""
    shown, (wide, high) = _shown(snapshots, floor), window[1] - window[0]
    size = round(PIXELS * min(1.0, wide / high)), round(PIXELS * min(1.0, high / wide))
    least, most = shown.min(axis=0), shown.max(axis=0)
    with display():
        renderer = Renderer(
            size, least, most, window=window, floor=floor, limit=limit, beyond=0.0, line=2.0
        )
        pictures = [
            renderer.draw([(s, PLAIN) for s in each.surfaces], bars(each.links, 0, unit=unit))
            for each in snapshots
        ]
        renderer.close()
    return pictures


def _shown(snapshots: Sequence[Snapshot], floor: float) -> Array:
    """Places in space that all panels show, m, (n, 3): the bodies and the floor around them."""
    places = np.concatenate([snapshot.places for snapshot in snapshots])
    least, most = places[:, :2].min(axis=0), places[:, :2].max(axis=0)
    margin = BEYOND * float(np.max(most - least))
    (left, front), (right, back) = least - margin, most + margin
    ring = (left, front), (right, front), (right, back), (left, back)
    return np.concatenate([places, [(*corner, floor) for corner in ring]])


def _columns(ratio: float, count: int) -> int:
    """Panels in a row, by the width of one over its height."""
    return count if ratio <= WIDE else math.ceil(count / 2)


def _limit(snapshots: Sequence[Snapshot]) -> float:
    """Stress of the last colour, Pa."""
    return float(np.quantile(np.concatenate([s.von_mises for s in snapshots]), 0.995))


def _title(instant: Instant) -> str:
    """Title of a snapshot: its name, and the time."""
    time = f"t = {instant.time_s:.3g} s"
    return f"{instant.name}\n{time}" if instant.name else time


def _draw_bodies(axes: Any, snapshot: Snapshot, factor: float, limit: float) -> None:
    """The cells of all bodies in the plane, coloured by stress where there is any."""
    from matplotlib.collections import LineCollection, PolyCollection

    outlines = [face[:, :2] for surface in snapshot.surfaces for face in polygons(surface)]
    bodies = PolyCollection(
        outlines, cmap=STRESS, edgecolors=(0, 0, 0, 0.35), linewidths=0.2, zorder=1
    )
    bodies.set_snap(False)  # upright cells are not to be drawn a pixel beside others
    shaped = any(EDGES in surface.field_data for surface in snapshot.surfaces)
    if limit > 0:
        bodies.set_array(factor * snapshot.von_mises)
        bodies.set_clim(0, factor * limit)
    elif not shaped:
        bodies.set(facecolor=PLAIN, edgecolor="black", linewidth=0.5)
    else:  # parts without seams between them
        bodies.set(facecolor=PLAIN, edgecolor=PLAIN, linewidth=0.3)
    axes.add_collection(bodies)
    if shaped:
        ends = [e for surface in snapshot.surfaces for e in _sides(surface, plain=limit == 0)]
        axes.add_collection(
            LineCollection(ends, colors="black", linewidths=0.5, zorder=1, capstyle="round")
        )


def _draw_links(axes: Any, snapshot: Snapshot, unit: float) -> None:
    """The links in the plane; one whose ends are at one place is a dot."""
    for link in snapshot.links:
        hue = LOOKS[int(link.states[0])][1]
        for line in link.lines(0, unit):
            short = np.linalg.norm(line[1] - line[0]) < DOT * unit
            look = {"marker": "o", "markersize": 3.0} if short else {"linewidth": 1.2}
            axes.plot(*line.T, color=hue, solid_capstyle="round", zorder=3, **look)


def _sides(surface: Any, *, plain: bool) -> Iterator[Array]:
    """The sides of a rigid shape in the plane, (2, 2), m; of other bodies where they are `plain`.

    A body with the colours of its stress has its cells.
    """
    if EDGES in surface.field_data:
        yield from np.asarray(surface.field_data[EDGES])[:, :2].reshape(-1, 2, 2)
    elif plain:
        for face in polygons(surface):
            yield from np.stack([face[:, :2], np.roll(face[:, :2], -1, axis=0)], axis=1)


def _window(snapshots: Sequence[Snapshot], floor: float, dimension: int) -> tuple[Array, Array]:
    """Least and greatest place that all panels show, as it is seen, m.

    What falls below the floor is not followed.
    """
    if dimension == 3:
        seen = in_view(_shown(snapshots, floor))
    else:
        seen = np.concatenate([snapshot.places[:, :2] for snapshot in snapshots])
        seen[:, 1] = np.maximum(seen[:, 1], floor)
        seen = np.vstack([seen, [seen[0, 0], floor]])
    low, high = seen.min(axis=0), seen.max(axis=0)
    margin = 0.06 * float(np.max(high - low))
    return low - margin, high + margin


def _draw_floor(axes: Any, level: float, depth: float) -> None:
    """The floor, as wide as the picture is, over whatever has fallen below it."""
    axes.axhspan(
        level - depth,
        level,
        facecolor=FLOOR,
        edgecolor=FLOOR_EDGE,
        hatch="////",
        linewidth=0,
        zorder=2,
    )
    axes.axhline(level, color="black", linewidth=0.8, zorder=2)
