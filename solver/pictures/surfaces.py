"""The surfaces of bodies as they stand at the times of the files of the fields."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from solver.pictures.field_grids import HdfGrids, PvdGrids
from solver.types import Array, Indices, Mask


class FieldFiles:
    """The bodies in a .pvd or .vtkhdf file, by its times."""

    def __init__(self, file: Path, dimension: int):
        """Read times and names."""
        self._grids = HdfGrids(file) if file.suffix == ".vtkhdf" else PvdGrids(file)
        self._dimension = dimension
        self.times, self.names = self._grids.times, self._grids.names
        """What the bodies are called, in their order; empty where the file does not say."""

    def read(self, index: int) -> list[Any]:
        """Surface of each body that is not empty, as `pyvista.PolyData`, in the order of the file.

        Points are where the bodies stand, m; cells have their von Mises stress (`von_mises`, Pa).
        """
        grids = [g for g in self._grids.read(index) if g is not None and g.n_cells]
        return [_skin(grid) if self._dimension == 3 else _sheet(grid) for grid in grids]

    def nearest(self, times: Sequence[float]) -> list[int]:
        """The snapshots nearest to some times, each once, by their numbers."""
        return sorted({int(np.argmin(np.abs(self.times - time))) for time in times})


def _sheet(grid: Any) -> Any:
    """A body in the plane: its cells, those of each rank once."""
    import pyvista

    cells = _cells(grid)
    own = np.flatnonzero(_owned(grid))
    around = [_around(cells[cell], int(grid.celltypes[cell])) for cell in own]
    sheet = pyvista.PolyData(_places(grid), faces=_counted(around))
    sheet.cell_data["von_mises"] = _stress(grid)[own]
    return sheet


def _skin(grid: Any) -> Any:
    """The surface of a body in space."""
    import pyvista
    from vtkmodules.vtkFiltersGeometry import vtkDataSetSurfaceFilter

    # VTK's own filter: pyvista's changes its defaults from version to version.
    skin = vtkDataSetSurfaceFilter()
    skin.SetInputData(_own_cells(grid))
    skin.SetNonlinearSubdivisionLevel(0)
    skin.Update()
    surface = pyvista.wrap(skin.GetOutput())
    surface.points = _places(surface)
    surface.cell_data["von_mises"] = _stress(surface)
    return surface


def _own_cells(grid: Any) -> Any:
    """A body in space without the cells that are copies, which stand in another rank's part.

    By hand: VTK's own filter for that (`vtkExtractCells` of 9.3, behind pyvista's `extract_cells`)
    ended the process with a segmentation fault once in some hundred calls.
    """
    import pyvista

    own = np.flatnonzero(_owned(grid))
    if len(own) == grid.n_cells:
        return grid
    cells = _cells(grid)
    kept = _counted([cells[cell] for cell in own])
    part = pyvista.UnstructuredGrid(kept, np.asarray(grid.celltypes)[own], grid.points)
    for name in grid.point_data:
        part.point_data[name] = grid.point_data[name]
    for name in grid.cell_data:
        part.cell_data[name] = np.asarray(grid.cell_data[name])[own]
    return part


def _cells(grid: Any) -> list[Indices]:
    """Points of each cell."""
    import pyvista

    # pyvista's own name for the offsets changes from version to version.
    offsets = pyvista.convert_array(grid.GetCells().GetOffsetsArray())
    return np.split(grid.cell_connectivity, offsets[1:-1])


def _counted(cells: Sequence[Indices]) -> Indices:
    """Cells one after another, each after the number of its points, as pyvista takes them."""
    return np.concatenate([[len(points), *points] for points in cells])


def _stress(grid: Any) -> Array:
    """The von Mises stress of the cells, Pa; zero in rigid bodies."""
    known = grid.cell_data.get("von_mises", np.zeros(grid.n_cells))
    return np.asarray(known, dtype=float)


def _places(grid: Any) -> Array:
    """Where the points of a body stand, m, (n, 3)."""
    rest = np.asarray(grid.points, dtype=float)
    return np.asarray(rest + np.asarray(grid.point_data["displacement"]))


def polygons(surface: Any) -> list[Array]:
    """Corners of each face of a surface, m, (k, 3)."""
    points = np.asarray(surface.points)
    return [points[face] for face in _faces(np.asarray(surface.faces))]


def _faces(faces: Indices) -> Iterator[Indices]:
    """Points of each face in VTK's list of them: number of points, points, number, points, ..."""
    start = 0
    while start < len(faces):
        end = start + 1 + int(faces[start])
        yield faces[start + 1 : end]
        start = end


def _owned(grid: Any) -> Mask:
    """Cells that are no copies: the ghosts of a rank are in its neighbour's file, too."""
    copies = np.asarray(grid.cell_data.get("vtkGhostType", np.zeros(grid.n_cells)))
    return np.asarray(copies == 0)


def _around(points: Indices, cell_type: int) -> Indices:
    """Points of a cell in the order of its outline; 69 and 70 are VTK's triangle and quadrilateral.

    Corners come first, then the points inside the edges: one to an edge at degree 2.
    """
    corners = {5: 3, 9: 4, 22: 3, 23: 4, 69: 3, 70: 4}[cell_type]
    if len(points) < 2 * corners:
        return points[:corners]
    return np.stack([points[:corners], points[corners : 2 * corners]], axis=1).ravel()
