"""The bodies as they stand, with their stress, drawn from the files of the fields.

In space they are seen from the front, a little from the right and from above, without perspective:
the faces of their surfaces, those behind drawn first.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from solver.pictures.surfaces import FieldFiles, polygons
from solver.types import Array

#: From where bodies in space are seen: to the right of the front and above the horizontal, rad.
ASIDE, ABOVE = math.radians(25), math.radians(20)

#: Colours of bodies without stress and of the floor.
PLAIN, FLOOR, FLOOR_EDGE = "#d9dee5", "#dddddd", "#999999"


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

    @property
    def low(self) -> Array:
        """Least place in the picture, m, (2,)."""
        return np.asarray(np.min([outline.min(axis=0) for outline in self.outlines], axis=0))

    @property
    def high(self) -> Array:
        """Greatest place in the picture, m, (2,)."""
        return np.asarray(np.max([outline.max(axis=0) for outline in self.outlines], axis=0))


def read_snapshots(fields: Path, times: Sequence[float], dimension: int = 2) -> list[Snapshot]:
    """The snapshots nearest to some times, each once."""
    files = FieldFiles(fields, dimension)
    snapshots = []
    for index in files.nearest(times):
        surfaces = files.read(index)
        outlines = [polygon for surface in surfaces for polygon in polygons(surface)]
        stress = np.concatenate([np.asarray(s.cell_data["von_mises"], float) for s in surfaces])
        if dimension == 3:
            outlines = [seen_from_front(outline) for outline in outlines]
            # Nearer to the eye is later; the third coordinate has served then.
            order = np.argsort([float(outline[:, 2].mean()) for outline in outlines])
            outlines, stress = [outlines[i] for i in order], stress[order]
        outlines = [outline[:, :2] for outline in outlines]
        time = float(files.times[index])
        snapshots.append(Snapshot(time_s=time, outlines=outlines, von_mises=stress))
    return snapshots


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


def draw_deformed(
    figure: Any, fields: Path, times: Sequence[float], *, dimension: int = 2, floor: float = 0.0
) -> None:
    """Draw the bodies at some times side by side, true to scale, coloured by von Mises stress.

    Of the .pvd file the snapshots nearest to the times (s) are drawn; the floor, at a height in m,
    in the plane only.
    """
    from matplotlib.collections import PolyCollection

    snapshots = read_snapshots(fields, times, dimension)
    low, high, margin = _window(snapshots, floor)
    limit = float(np.quantile(np.concatenate([s.von_mises for s in snapshots]), 0.995))
    unit, factor = ("MPa", 1e-6) if limit >= 1e5 else ("kPa", 1e-3)
    panels = np.atleast_1d(figure.subplots(1, len(snapshots), sharey=True))
    for axes, snapshot in zip(panels, snapshots, strict=True):
        bodies = PolyCollection(
            snapshot.outlines, cmap="viridis", edgecolors=(0, 0, 0, 0.35), linewidths=0.2
        )
        if limit > 0:
            bodies.set_array(factor * snapshot.von_mises)
            bodies.set_clim(0, factor * limit)
        else:
            bodies.set(facecolor=PLAIN, edgecolor="black", linewidth=0.5)
        axes.add_collection(bodies)
        if dimension == 2:
            _draw_floor(axes, floor, margin)
        axes.set(
            xlim=(low[0] - margin, high[0] + margin),
            ylim=(low[1] - margin, high[1] + margin),
            aspect="equal",
            title=f"t = {snapshot.time_s:.3g} s",
        )
        axes.set_xlabel("x (m)" if dimension == 2 else "(m)")
        axes.locator_params(axis="x", nbins=3)
        axes.grid(False)
    panels[0].set_ylabel("y (m)" if dimension == 2 else "(m)")
    if limit > 0:
        bar = figure.colorbar(bodies, ax=list(panels), extend="max", shrink=0.9)
        bar.set_label(f"von Mises stress ({unit})")


def _window(snapshots: Sequence[Snapshot], floor: float) -> tuple[Array, Array, float]:
    """Least and greatest place that all panels show, and a margin, m.

    What falls below the floor is followed for as far as all was wide or high at the start.
    """
    size = float(np.max(snapshots[0].high - snapshots[0].low))
    low = np.min([snapshot.low for snapshot in snapshots], axis=0)
    high = np.max([snapshot.high for snapshot in snapshots], axis=0)
    low[1] = max(min(low[1], floor), floor - size)
    return low, high, 0.06 * float(np.max(high - low))


def _draw_floor(axes: Any, level: float, depth: float) -> None:
    """The floor, as wide as the picture is."""
    axes.axhspan(
        level - depth, level, facecolor=FLOOR, edgecolor=FLOOR_EDGE, hatch="////", linewidth=0
    )
    axes.axhline(level, color="black", linewidth=0.8)
