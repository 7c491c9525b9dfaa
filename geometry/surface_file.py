"""Files of surfaces: STL, OBJ, PLY, STEP, and meshes of Gmsh and VTK, whose boundary it is."""

from __future__ import annotations

import math
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from geometry.cells import TETRAHEDRON, Cells
from geometry.gmsh_session import elements_of_model, failures, nodes_of_model, silent_model
from geometry.mesh_file import UNREAD, surface_of_step
from geometry.ply_file import read_ply
from geometry.polygon import size_of, told
from geometry.surface import MOST, Surface, merged, refuse_too_many
from solver.types import Array, Indices

LARGEST = 100.0
"""The longest side that a body may have, m: one of more is in other units."""


def read_surface(path: str | Path, scale: float = 1.0) -> Surface:
    """The closed surface in a file: .stl, .obj, .vtu (read by VTK), .ply, .msh, .step (by Gmsh).

    Of meshes with cells it is the boundary of these, of others their facets; quadrilaterals are cut
    into triangles. Points that are one place are one point (`geometry.surface.merged`).

    Args:
        path: The file.
        scale: m per unit of the file, such as 0.001 for millimetres.

    Raises:
        ValueError: a file that is not there, empty, not readable or of another kind, without
            facets, with more than 10^6, larger than 100 m, or whose surface is refused by
            `geometry.surface.Surface`.
    """
    file = Path(path)
    if not (math.isfinite(scale) and scale > 0):
        raise ValueError(f"scale: got {scale}, allowed a number > 0, m per unit of the file")
    reader = READERS.get(file.suffix.lower())
    if reader is None:
        raise ValueError(
            f"{file}: got a file of the kind '{file.suffix}', allowed {', '.join(READERS)}"
        )
    _refuse_unreadable(file)
    try:
        points, triangles = reader(file)
    except ValueError as error:
        raise ValueError(f"{file}: {error}") from None
    if not len(triangles):
        raise ValueError(f"{file}: got no facets, allowed a closed surface")
    refuse_too_many(len(triangles), str(file))
    if triangles.min() < 0 or triangles.max() >= len(points):
        worst = triangles.min() if triangles.min() < 0 else triangles.max()
        raise ValueError(f"{file}: got a facet with point {worst}, allowed 0 to {len(points) - 1}")
    bad = ~np.isfinite(points).all(axis=1)
    if bad.any():
        raise ValueError(
            f"{file}: got {told(points[np.argmax(bad)])} as a point, allowed finite numbers"
        )
    points, triangles = merged(scale * points, triangles)
    if not len(triangles):
        raise ValueError(f"{file}: got facets without an area only, allowed a closed surface")
    size = size_of(points)
    if size > LARGEST:
        raise ValueError(
            f"{file}: got a body of {size:.6g} m, allowed at most {LARGEST:g} m; it looks like"
            f" millimetres: scale = {0.001 * scale:g}"
        )
    return Surface(points=points, triangles=triangles, name=str(file))


def _refuse_unreadable(file: Path) -> None:
    """ValueError for a file that cannot be opened, or is empty."""
    try:
        with file.open("rb") as opened:
            if not opened.read(1):
                raise ValueError(f"{file}: got an empty file, allowed a closed surface")
    except OSError as error:
        said = (error.strerror or str(error)).lower()
        raise ValueError(f"{file}: got {said}, allowed a file to read") from None


def _from_stl(file: Path) -> tuple[Array, Indices]:
    """Points and triangles of an STL file, ASCII or binary."""
    size = file.stat().st_size
    with file.open("rb") as opened:
        head = opened.read(1024)
    count = int.from_bytes(head[80:84], "little") if len(head) >= 84 else -1
    # By its length, not as VTK by its first bytes: some programs begin binary files by `solid`.
    if size != 84 + 50 * count:
        if not head.lstrip().lower().startswith(b"solid") or b"\0" in head:
            raise ValueError(
                f"got {size} bytes, {max(count, 0)} facets announced, allowed an STL file of"
                " 84 + 50 bytes a facet, or one of text that begins with 'solid'"
            )
        return _by_vtk("vtkIOGeometry", "vtkSTLReader", file)
    refuse_too_many(count, "binary STL")
    facet = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("colour", "<u2")])
    corners = np.fromfile(file, dtype=facet, offset=84)["corners"].astype(np.float64)
    return corners.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3)


def _from_obj(file: Path) -> tuple[Array, Indices]:
    """Points and triangles of a Wavefront OBJ file."""
    return _by_vtk("vtkIOGeometry", "vtkOBJReader", file)


def _from_ply(file: Path) -> tuple[Array, Indices]:
    """Points and triangles of a PLY file."""
    return read_ply(file, MOST)


def _from_vtu(file: Path) -> tuple[Array, Indices]:
    """Points and boundary of an unstructured grid of VTK."""
    import pyvista

    return _boundary(pyvista.wrap(_output("vtkIOXML", "vtkXMLUnstructuredGridReader", file)))


def _from_msh(file: Path) -> tuple[Array, Indices]:
    """Points and boundary of a mesh of Gmsh, of any of its formats; cells by their corners."""
    with silent_model("surface file") as gmsh, failures(UNREAD):
        gmsh.merge(str(file))
        return _of_gmsh_model()


VTK_CELLS = {(2, 3): 5, (2, 4): 9, (3, 4): 10, (3, 8): 12, (3, 6): 13, (3, 5): 14}
"""VTK's number of a cell by its dimension and its corners."""


def _of_gmsh_model() -> tuple[Array, Indices]:
    """Points and boundary of the cells of Gmsh's current model, or its facets if it has none."""
    import pyvista

    points, numbers = nodes_of_model()
    for dimension in (3, 2):
        cells: dict[int, Indices] = {}
        for _, rows in elements_of_model(dimension, numbers):
            vtk = VTK_CELLS[dimension, rows.shape[1]]
            cells[vtk] = np.concatenate([cells.get(vtk, rows[:0]), rows])
        if cells:
            return _boundary(pyvista.UnstructuredGrid(cells, points))
    return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)


def _boundary(grid: Any) -> tuple[Array, Indices]:
    """Boundary of the cells of a grid of VTK, or its facets where it has no cells."""
    tetra = 10
    if not grid.n_cells:
        return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
    solid = {tetra, 11, 12, 13, 14, 24, 25, 26, 27, 29, 32, 33}  # those of three dimensions
    kinds = np.isin(grid.celltypes, list(solid))
    if not kinds.any():
        return _triangles(grid.extract_geometry())
    grid = grid.extract_cells(np.flatnonzero(kinds))
    if (grid.celltypes != tetra).any():
        grid = grid.triangulate()
    points = np.asarray(grid.points, dtype=np.float64)
    tetrahedra = np.asarray(grid.cells_dict[tetra], dtype=np.int64)
    return points, Cells(points, tetrahedra, TETRAHEDRON).boundary


def _by_vtk(module: str, reader: str, file: Path) -> tuple[Array, Indices]:
    """Points and triangles of a file that a class of VTK reads."""
    import pyvista

    return _triangles(pyvista.wrap(_output(module, reader, file)))


def _triangles(surface: Any) -> tuple[Array, Indices]:
    """Points and triangles of a surface of VTK."""
    empty = np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
    if not surface.n_cells:
        return empty
    facets = surface.triangulate()
    if not facets.n_cells:
        return empty
    triangles = np.asarray(facets.faces, dtype=np.int64).reshape(-1, 4)[:, 1:]
    return np.asarray(facets.points, dtype=np.float64), triangles


def _output(module: str, name: str, file: Path) -> Any:
    """What a reader of VTK makes of a file; ValueError, and no word on the screen, if it fails."""
    from vtkmodules.vtkCommonCore import vtkLogger, vtkOutputWindow, vtkStringOutputWindow

    before, ours = vtkOutputWindow.GetInstance(), vtkStringOutputWindow()
    loudness = vtkLogger.GetCurrentVerbosityCutoff()
    vtkOutputWindow.SetInstance(ours)
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    try:
        reader = getattr(import_module(f"vtkmodules.{module}"), name)()
        reader.SetFileName(str(file))
        reader.Update()
        found, said = reader.GetOutput(), ours.GetOutput()
    finally:
        vtkOutputWindow.SetInstance(before)
        vtkLogger.SetStderrVerbosity(loudness)
    if isinstance(said, bytes):  # words of the file that are no text
        said = said.decode("utf-8", "replace")
    lines = said.splitlines()
    # Warnings are of what is no shape, such as the colours of points.
    wrong = [k for k, line in enumerate(lines[:-1]) if line.startswith("ERROR")]
    if wrong:
        words = lines[wrong[0] + 1].split("): ")[-1].strip().replace(str(file), "it")
        raise ValueError(f"got what VTK does not read ({words[:100]}), allowed a surface")
    return found


READERS: dict[str, Callable[[Path], tuple[Array, Indices]]] = {
    ".stl": _from_stl,
    ".obj": _from_obj,
    ".ply": _from_ply,
    ".msh": _from_msh,
    ".vtu": _from_vtu,
    ".step": surface_of_step,
    ".stp": surface_of_step,
}
"""What reads a file, by the end of its name."""
