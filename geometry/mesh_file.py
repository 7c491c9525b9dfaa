"""Meshes of Gmsh's files, which are taken as they are, and bodies of STEP files."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from geometry.cells import Cells, cells_of_model
from geometry.gmsh_session import (
    elements_of_model,
    failures,
    nodes_of_model,
    options,
    silent_model,
)
from geometry.polygon import told
from solver.types import Array, Indices

STEPS = (".step", ".stp")
"""Ends of the names of files with a body of which Gmsh makes a mesh."""

FINE = 16
"""Parts of the geometric mean of the sides of the box around the body of a STEP file that the edges
of its surface have."""


UNREAD = "got what Gmsh does not read ({}), allowed a body"
"""What is said of a file at which Gmsh fails."""


@lru_cache(maxsize=16)
def read_cells(path: Path, scale: float = 1.0) -> Cells:
    """The cells in space of a mesh, one body by their corners; physical groups are left aside.

    Args:
        path: A file of Gmsh, .msh.
        scale: m per unit of the file.

    Raises:
        ValueError: There are none, or several kinds, or some without a volume, or several bodies.
    """
    with _named(path):
        with silent_model("mesh") as gmsh, failures(UNREAD):
            gmsh.merge(str(path))
            found = cells_of_model(3)
        cells = Cells(scale * found.points, found.numbers, found.kind)
        thin = cells.volumes <= 1e-9 * cells.volumes.mean()
        if thin.any():
            place = cells.points[cells.numbers[int(np.argmax(thin))]].mean(axis=0)
            count = int(thin.sum())
            raise ValueError(
                f"got {count} cells without a volume, one at {told(place)}, allowed none"
            )
        if cells.pieces > 1:
            raise ValueError(
                f"got {cells.pieces} pieces that have no facet in common, allowed one body"
            )
        return cells


def cells_of_step(path: Path, scale: float, size: float) -> Cells:
    """Tetrahedra of the body of a STEP file, by OpenCASCADE.

    Args:
        path: The file, whose own units are made m.
        scale: Times these.
        size: Length of the edges of the cells, m.
    """
    with _named(path), _step_model(path) as gmsh:
        _generate(gmsh, 3, size / scale)
        found = cells_of_model(3)
    return Cells(scale * found.points, found.numbers, found.kind)


def surface_of_step(path: Path) -> tuple[Array, Indices]:
    """Points, m, and triangles of the surface of the body of a STEP file, some 16 along a side."""
    with _step_model(path) as gmsh:
        low, high = np.array(gmsh.model.getBoundingBox(-1, -1)).reshape(2, 3)
        _generate(gmsh, 2, float(np.prod(high - low)) ** (1 / 3) / FINE)
        points, numbers = nodes_of_model()
        (triangles,) = elements_of_model(2, numbers)
        return points, triangles.nodes


def _generate(gmsh: Any, dimension: int, size: float) -> None:
    """Make the mesh of the current model up to a dimension, with edges of a length, m."""
    gmsh.model.mesh.setSize(gmsh.model.getEntities(0), size)
    with options({"Mesh.MeshSizeMax": size}):
        gmsh.model.mesh.generate(dimension)


@contextmanager
def _step_model(path: Path) -> Iterator[Any]:
    """A Gmsh model of the one body of a STEP file, in m."""
    _refuse_no_step(path)
    metres = {"Geometry.OCCTargetUnit": "M"}
    with silent_model("step") as gmsh, failures(UNREAD), options(metres):
        gmsh.model.occ.importShapes(str(path))
        gmsh.model.occ.synchronize()
        bodies = gmsh.model.getEntities(3)
        if len(bodies) != 1:
            what = f"{len(bodies)} solids" if bodies else "no solid, only surfaces or lines"
            raise ValueError(f"got {what}, allowed one")
        yield gmsh


def _refuse_no_step(path: Path) -> None:
    """ValueError for a file that does not begin as those of ISO 10303-21: OpenCASCADE prints."""
    with path.open("rb") as opened:
        if not opened.read(64).lstrip().startswith(b"ISO-10303-21"):
            raise ValueError(
                "got a file that does not begin with ISO-10303-21, allowed a STEP file"
            )


@contextmanager
def _named(path: Path) -> Iterator[None]:
    """ValueErrors that name the file."""
    try:
        yield
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
