"""The bodies as they stand, with their stress, drawn from the files of the fields.

In space they are seen from the front, a little from the right and from above, without perspective:
the faces of their surfaces, those behind drawn first (`drawing_order`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter

from solver.fields.ground import floor_level
from solver.pictures.drawing_order import drawing_order
from solver.pictures.instants import Instant, instants
from solver.pictures.style import WIDTH, new_figure
from solver.pictures.surfaces import FieldFiles, polygons
from solver.results.runs import Run
from solver.types import Array

#: From where bodies in space are seen: to the right of the front and above the horizontal, rad.
ASIDE, ABOVE = math.radians(25), math.radians(20)

#: Colours of bodies without stress and of the floor.
PLAIN, FLOOR, FLOOR_EDGE = "#d9dee5", "#dddddd", "#999999"

#: What is wider than this over its height stands in two rows.
WIDE = 1.1

#: Heights of titles and of labels, and the width of the colour bar, in.
TITLE, LABEL, BAR = 0.45, 0.45, 0.9


@dataclass(frozen=True, slots=True, kw_only=True)
class Snapshot:
    """The bodies at an instant."""

    time_s: float
    """The instant, s."""
    outlines: list[Array]
    """Corners of each cell (in space: of each face of the surface) as it stands in the picture, m;
    those that hide others later."""
    von_mises: Array
    """Stress of each, Pa."""
    least: Array
    """Least place of the bodies, m, (3,)."""
    most: Array
    """Greatest place, m, (3,)."""

    @property
    def low(self) -> Array:
        """Least place in the picture, m, (2,)."""
        return np.asarray(np.min([outline.min(axis=0) for outline in self.outlines], axis=0))

    @property
    def high(self) -> Array:
        """Greatest place in the picture, m, (2,)."""
        return np.asarray(np.max([outline.max(axis=0) for outline in self.outlines], axis=0))


def read_snapshots(
    fields: Path, times: Sequence[float], dimension: int = 2, floor: float = -math.inf
) -> list[Snapshot]:
    """The snapshots nearest to some times, each once; what is below the floor is left out."""
    files = FieldFiles(fields, dimension)
    return [_snapshot(files, index, dimension, floor) for index in files.nearest(times)]


def _snapshot(files: FieldFiles, index: int, dimension: int, floor: float) -> Snapshot:
    """The bodies at one of the times of the files."""
    surfaces = files.read(index)
    outlines = [polygons(surface) for surface in surfaces]
    faces = [face for own in outlines for face in own]
    stress = np.concatenate([np.asarray(s.cell_data["von_mises"], float) for s in surfaces])
    places = np.concatenate(faces)
    if dimension == 3:
        slack = 1e-6 * float(np.ptp(places))
        above = [k for k, face in enumerate(faces) if face[:, 2].max() >= floor - slack]
        faces, stress = [seen_from_front(faces[k]) for k in above], stress[above]
        # The third coordinate, towards the eye, has served then.
        bodies = np.repeat(np.arange(len(outlines)), [len(own) for own in outlines])
        order = drawing_order(faces, bodies[above])
        faces, stress = [faces[i] for i in order], stress[order]
    return Snapshot(
        time_s=float(files.times[index]),
        outlines=[face[:, :2] for face in faces],
        von_mises=stress,
        least=places.min(axis=0),
        most=places.max(axis=0),
    )


def seen_from_front(place: Array) -> Array:
    """Places in space (n, 3) as they are seen: to the right, up, and towards the eye, m."""
    right = np.array([math.cos(ASIDE), math.sin(ASIDE), 0.0])
    eye = np.array(
        [
            math.sin(ASIDE) * math.cos(ABOVE),
            -math.cos(ASIDE) * math.cos(ABOVE),
            math.sin(ABOVE),
        ]
    )
    return np.asarray(place @ np.stack([right, np.cross(eye, right), eye], axis=1))


def deformed_figure(run: Run, fields: Path) -> Figure:
    """The bodies of a run at the instants worth a look; the panels fill the page."""
    chosen, dimension = instants(run), run.scene.dimension
    floor = floor_level(run.scene)
    snapshots = read_snapshots(fields, [i.time_s for i in chosen], dimension, floor)
    low, high = _window(snapshots, floor, dimension)
    wide, high_by = high - low
    columns = _columns(float(wide / high_by), len(snapshots))
    rows = math.ceil(len(snapshots) / columns)
    panel = (WIDTH - LABEL - (BAR if _limit(snapshots) > 0 else 0.0)) / columns
    height = rows * (panel * float(high_by / wide) + TITLE) + LABEL
    figure = new_figure(min(max(height, 1.8), 8.0))
    draw_snapshots(figure, snapshots, chosen, dimension=dimension, floor=floor)
    return figure


def draw_deformed(
    figure: Any, fields: Path, chosen: Sequence[Instant], *, dimension: int = 2, floor: float = 0.0
) -> None:
    """Draw the bodies at some instants, true to scale, coloured by von Mises stress.

    Of the .pvd or .vtkhdf file the snapshots nearest to the instants are drawn, above the floor,
    whose height is given in m.
    """
    times = [instant.time_s for instant in chosen]
    snapshots = read_snapshots(fields, times, dimension, floor)
    draw_snapshots(figure, snapshots, chosen, dimension=dimension, floor=floor)


def draw_snapshots(
    figure: Any,
    snapshots: Sequence[Snapshot],
    chosen: Sequence[Instant],
    *,
    dimension: int,
    floor: float,
) -> None:
    """Draw snapshots side by side, or in two rows where they are wide."""
    low, high = _window(snapshots, floor, dimension)
    columns = _columns(float(np.divide(*(high - low))), len(snapshots))
    rows = math.ceil(len(snapshots) / columns)
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    limit = _limit(snapshots)
    unit, factor = ("MPa", 1e-6) if limit >= 1e5 else ("kPa", 1e-3)
    for axes, snapshot in zip(grid.ravel(), snapshots, strict=False):
        if dimension == 2:
            _draw_floor(axes, floor, floor - low[1])
        else:
            _draw_floor_in_space(axes, snapshots, floor)
        bodies = _draw_bodies(axes, snapshot, factor, limit)
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
        axes.set_title(_title(snapshot, chosen))
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
        bar = figure.colorbar(bodies, ax=list(grid.ravel()), extend="max", shrink=0.9)
        bar.set_label(f"von Mises stress ({unit})")


def _columns(ratio: float, count: int) -> int:
    """Panels in a row, by the width of one over its height."""
    return count if ratio <= WIDE else math.ceil(count / 2)


def _limit(snapshots: Sequence[Snapshot]) -> float:
    """Stress of the last colour, Pa."""
    return float(np.quantile(np.concatenate([s.von_mises for s in snapshots]), 0.995))


def _title(snapshot: Snapshot, chosen: Sequence[Instant]) -> str:
    """What happens, and when."""
    nearest = min(chosen, key=lambda instant: abs(instant.time_s - snapshot.time_s))
    time = f"t = {snapshot.time_s:.3g} s"
    return f"{nearest.name}\n{time}" if nearest.name else time


def _draw_bodies(axes: Any, snapshot: Snapshot, factor: float, limit: float) -> Any:
    """The cells of all bodies, coloured by stress where there is any."""
    from matplotlib.collections import PolyCollection

    bodies = PolyCollection(
        snapshot.outlines, cmap="viridis", edgecolors=(0, 0, 0, 0.35), linewidths=0.2, zorder=1
    )
    bodies.set_snap(False)  # upright cells are not to be drawn a pixel beside others
    if limit > 0:
        bodies.set_array(factor * snapshot.von_mises)
        bodies.set_clim(0, factor * limit)
    else:
        bodies.set(facecolor=PLAIN, edgecolor="black", linewidth=0.5)
    axes.add_collection(bodies)
    return bodies


def _window(snapshots: Sequence[Snapshot], floor: float, dimension: int) -> tuple[Array, Array]:
    """Least and greatest place that all panels show, m.

    What falls below the floor is not followed.
    """
    low = np.min([snapshot.low for snapshot in snapshots], axis=0)
    high = np.max([snapshot.high for snapshot in snapshots], axis=0)
    if dimension == 2:
        low[1] = floor
    else:
        corners = _floor_corners(snapshots, floor)
        low, high = np.minimum(low, corners.min(axis=0)), np.maximum(high, corners.max(axis=0))
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


def _floor_corners(snapshots: Sequence[Snapshot], level: float) -> Array:
    """Corners of the piece of floor that is drawn in space, as they are seen, m, (4, 2)."""
    least = np.min([snapshot.least[:2] for snapshot in snapshots], axis=0)
    most = np.max([snapshot.most[:2] for snapshot in snapshots], axis=0)
    margin = 0.3 * float(np.max(most - least))
    (left, front), (right, back) = least - margin, most + margin
    ring = (left, front), (right, front), (right, back), (left, back)
    return seen_from_front(np.array([(*corner, level) for corner in ring]))[:, :2]


def _draw_floor_in_space(axes: Any, snapshots: Sequence[Snapshot], level: float) -> None:
    """The floor below the bodies, as a plane."""
    axes.fill(
        *_floor_corners(snapshots, level).T, facecolor="#f0f0f0", edgecolor=FLOOR_EDGE, zorder=0
    )
