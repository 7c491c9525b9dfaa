"""The deformed block with its stress, drawn from the files of the fields."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Snapshot:
    """The block at an instant.

    Attributes:
        time_s: The instant, s.
        outlines: Corners of each cell as it stands, m.
        von_mises: Stress of each cell, Pa.
    """

    time_s: float
    outlines: list[Array]
    von_mises: Array


def read_snapshots(fields: Path, times: Sequence[float]) -> list[Snapshot]:
    """The snapshots nearest to some times, each once."""
    import pyvista

    reader = pyvista.get_reader(str(fields))
    written = np.array(reader.time_values)
    nearest = sorted({int(np.argmin(np.abs(written - time))) for time in times})
    snapshots = []
    for index in nearest:
        reader.set_active_time_value(written[index])
        snapshots.append(_snapshot(float(written[index]), reader.read().combine()))
    return snapshots


def _snapshot(time: float, grid: Any) -> Snapshot:
    """Outlines and stress of the cells, those of each rank once."""
    place = np.asarray(grid.points)[:, :2] + np.asarray(grid.point_data["displacement"])[:, :2]
    stress = np.asarray(grid.cell_data["von_mises"], dtype=float)
    ghost = grid.cell_data.get("vtkGhostType", np.zeros(len(stress)))
    # Cells that a rank only knows from its neighbour are in the files of both.
    own = np.flatnonzero(np.asarray(ghost) == 0)
    cells = np.split(grid.cell_connectivity, grid.offset[1:-1])
    outlines = [place[_around(cells[cell], int(grid.celltypes[cell]))] for cell in own]
    return Snapshot(time_s=time, outlines=outlines, von_mises=stress[own])


def _around(points: NDArray[np.int64], cell_type: int) -> NDArray[np.int64]:
    """Points of a cell in the order of its outline; 69 and 70 are VTK's triangle and quadrilateral.

    Corners come first, then the points inside the edges: one to an edge at degree 2.
    """
    corners = {5: 3, 9: 4, 22: 3, 23: 4, 69: 3, 70: 4}[cell_type]
    if len(points) < 2 * corners:
        return points[:corners]
    return np.stack([points[:corners], points[corners : 2 * corners]], axis=1).ravel()


def draw_deformed(figure: Any, fields: Path, times: Sequence[float]) -> None:
    """Draw the block at some times side by side, true to scale, coloured by von Mises stress.

    Args:
        figure: A matplotlib figure.
        fields: The .pvd file.
        times: Instants, s; the snapshots nearest to them are drawn.
    """
    from matplotlib.collections import PolyCollection
    from matplotlib.patches import Rectangle

    snapshots = read_snapshots(fields, times)
    corners = np.concatenate([outline for s in snapshots for outline in s.outlines])
    low, high = corners.min(axis=0), corners.max(axis=0)
    margin = 0.06 * float(np.max(high - low))
    all_stress = np.concatenate([s.von_mises for s in snapshots])
    limit = max(float(np.quantile(all_stress, 0.995)), 1e-300)
    unit, factor = ("MPa", 1e-6) if limit >= 1e5 else ("kPa", 1e-3)
    panels = np.atleast_1d(figure.subplots(1, len(snapshots), sharey=True))
    for axes, snapshot in zip(panels, snapshots, strict=True):
        block = PolyCollection(
            snapshot.outlines, cmap="viridis", edgecolors=(0, 0, 0, 0.35), linewidths=0.2
        )
        block.set_array(factor * snapshot.von_mises)
        block.set_clim(0, factor * limit)
        axes.add_collection(block)
        width = float(high[0] - low[0]) + 2 * margin
        floor = Rectangle(
            (float(low[0]) - margin, -margin),
            width,
            margin,
            facecolor="#dddddd",
            edgecolor="#999999",
            hatch="////",
            linewidth=0,
        )
        axes.add_patch(floor)
        axes.axhline(0, color="black", linewidth=0.8)
        axes.set(
            xlim=(low[0] - margin, high[0] + margin),
            ylim=(-margin, high[1] + margin),
            aspect="equal",
            title=f"t = {snapshot.time_s:.3g} s",
        )
        axes.set_xlabel("x (m)")
        axes.grid(False)
    panels[0].set_ylabel("y (m)")
    bar = figure.colorbar(block, ax=list(panels), extend="max", shrink=0.9)
    bar.set_label(f"von Mises stress ({unit})")
