"""Meshes of Gmsh's files, which are taken as they are, and bodies of STEP files."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from geometry.cells import Cells, cells_of_model, silent_model
from geometry.polygon import told
from solver.types import Array, Indices

STEPS = (".step", ".stp")
"""Ends of the names of files with a body of which Gmsh makes a mesh."""

FINE = 16
"""Parts of the geometric mean of the sides of the box around the body of a STEP file that the edges
of its surface have."""


@lru_cache(maxsize=16)
def read_cells(path: Path, scale: float = 1.0) -> Cells:
    """The cells in space of a mesh, one body by their corners; physical groups are left aside.

    Args:
        path: A file of Gmsh, .msh.
        scale: m per unit of the file.

    Raises:
        ValueError: There are none, or several kinds, or some without a volume, or several bodies.
    """
    with silent_model("mesh") as gmsh, _told(path):
        gmsh.merge(str(path))
        found = cells_of_model(3)
    cells = Cells(scale * found.points, found.numbers, found.kind)
    thin = cells.volumes <= 1e-9 * cells.volumes.mean()
    if thin.any():
        place = cells.points[cells.numbers[int(np.argmax(thin))]].mean(axis=0)
        raise ValueError(
            f"{path}: got {int(thin.sum())} cells without a volume, one at {told(place)}, allowed"
            " none"
        )
    if cells.pieces > 1:
        raise ValueError(
            f"{path}: got {cells.pieces} pieces that have no facet in common, allowed one body"
        )
    return cells


def cells_of_step(path: Path, scale: float, size: float) -> Cells:
    """Tetrahedra of the body of a STEP file, by OpenCASCADE.

    Args:
        path: The file, whose own units are made m.
        scale: Times these.
        size: Length of the edges of the cells, m.
    """
    with _step_model(path) as gmsh:
        _set_size(gmsh, size / scale)
        gmsh.model.mesh.generate(3)
        found = cells_of_model(3)
    return Cells(scale * found.points, found.numbers, found.kind)


def surface_of_step(path: Path) -> tuple[Array, Indices]:
    """Points, m, and triangles of the surface of the body of a STEP file, some 16 along a side."""
    with _step_model(path) as gmsh:
        low, high = np.array(gmsh.model.getBoundingBox(-1, -1)).reshape(2, 3)
        _set_size(gmsh, float(np.prod(high - low)) ** (1 / 3) / FINE)
        gmsh.model.mesh.generate(2)
        tags, points, _ = gmsh.model.mesh.getNodes()
        place = np.zeros(int(tags.max()) + 1, dtype=np.int64)
        place[tags] = np.arange(len(tags))
        _, nodes = gmsh.model.mesh.getElementsByType(2)
        return points.reshape(-1, 3), place[nodes.astype(np.int64)].reshape(-1, 3)


def _set_size(gmsh: Any, size: float) -> None:
    """Let all edges of cells have a length, m."""
    gmsh.model.mesh.setSize(gmsh.model.getEntities(0), size)
    gmsh.option.setNumber("Mesh.MeshSizeMax", size)


@contextmanager
def _step_model(path: Path) -> Iterator[Any]:
    """A Gmsh model of the one body of a STEP file, in m."""
    with silent_model("step") as gmsh, _told(path):
        before = gmsh.option.getString("Geometry.OCCTargetUnit")
        largest = gmsh.option.getNumber("Mesh.MeshSizeMax")
        gmsh.option.setString("Geometry.OCCTargetUnit", "M")
        _refuse_no_step(path)
        try:
            gmsh.model.occ.importShapes(str(path))
            gmsh.model.occ.synchronize()
            bodies = gmsh.model.getEntities(3)
            if len(bodies) != 1:
                what = f"{len(bodies)} solids" if bodies else "no solid, only surfaces or lines"
                raise ValueError(f"{path}: got {what}, allowed one")
            yield gmsh
        finally:
            gmsh.option.setString("Geometry.OCCTargetUnit", before)
            gmsh.option.setNumber("Mesh.MeshSizeMax", largest)


def _refuse_no_step(path: Path) -> None:
    """ValueError for a file that does not begin as those of ISO 10303-21: OpenCASCADE prints."""
    with path.open("rb") as opened:
        if not opened.read(64).lstrip().startswith(b"ISO-10303-21"):
            raise ValueError(
                f"{path}: got a file that does not begin with ISO-10303-21, allowed a STEP file"
            )


@contextmanager
def _told(path: Path) -> Iterator[None]:
    """Gmsh's failures as ValueErrors that name the file."""
    try:
        yield
    except ValueError as error:
        said = str(error)
        raise ValueError(said if said.startswith(str(path)) else f"{path}: {said}") from None
    except Exception as error:  # Gmsh has no narrower class
        said = " ".join(str(error).split())
        raise ValueError(f"{path}: got what Gmsh does not read ({said}), allowed a body") from None
