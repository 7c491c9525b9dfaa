"""The meshes of blocks and plates: boxes over graded tensor grids."""

from __future__ import annotations

from collections.abc import Sequence

from mpi4py import MPI

import numpy as np
from dolfinx.mesh import Mesh

from geometry.arrangement import Placement
from geometry.block import Block
from geometry.body_mesh import cells_of_parts
from geometry.convex import Convex
from geometry.foundation import Plate
from geometry.gmsh_model import MeshedBody, make, put
from geometry.grading import centred, graded, graded_to_both_ends
from geometry.grid import CELLS, grid_cells, tags_of_sides
from geometry.tags import FacetTag, tags_of_faces
from solver.types import Array, Mask


def block_mesh(
    shape: Block,
    *,
    dimension: int = 2,
    cells: tuple[int, ...] = (6, 16),
    cell: str | None = None,
    refinement: float = 1.0,
    comm: MPI.Intracomm = MPI.COMM_WORLD,
) -> MeshedBody:
    """Mesh a block in its own frame, whose origin is at the bottom centre; collective.

    Args:
        shape: The block.
        dimension: 2: its section, x in [-B/2, B/2], y in [0, H]; 3: all of it, x alike,
            y in [-t/2, t/2], z in [0, H].
        cells: Number of cells along width and height, in space along width, thickness and height,
            each >= 1. Even numbers along width and thickness make the mesh its own mirror image.
        cell: "quadrilateral" (None) or "triangle" (two for each quadrilateral); in space
            "hexahedron" (None) or "tetrahedron" (five for each hexahedron).
        refinement: The longest edges over those at the bottom corners, >= 1, along each direction
            for itself.
        comm: The ranks that share the mesh.
    """
    sides = (shape.width, shape.thickness)[: dimension - 1]
    across = [
        centred(side, graded_to_both_ends(count, refinement))
        for side, count in zip(sides, cells[:-1], strict=True)
    ]
    up = shape.height * graded(cells[-1], refinement)
    return grid_mesh("block", [*across, up], cell, comm)


def shape_mesh(part: Convex, size: float, comm: MPI.Intracomm = MPI.COMM_WORLD) -> MeshedBody:
    """Mesh a convex body in its own frame by triangles or tetrahedra; collective.

    Args:
        part: The body; its faces have the tags of `tags_of_faces`.
        size: Length of the edges of the cells, m.
        comm: The ranks that share the mesh.
    """
    tags = np.array(tags_of_faces([float(rise) for rise in part.normals[:, -1]]))

    def build() -> None:
        cells = cells_of_parts((part,), size)
        middles = cells.points[cells.boundary].mean(axis=1)
        put(cells, tags[np.argmax(middles @ part.normals.T - part.levels, axis=1)])

    return make("shape", build, part.dimension, comm)


def plate_mesh(
    plate: Plate,
    *,
    dimension: int = 2,
    cells: tuple[int, ...] = (24, 3),
    cell: str | None = None,
    comm: MPI.Intracomm = MPI.COMM_WORLD,
) -> MeshedBody:
    """Mesh a plate in its own frame, whose origin is at the centre of its top; collective.

    It has x in [-W/2, W/2], in space y in [-t/2, t/2], and goes from -h up to 0. Cells are those of
    `block_mesh`, all of one size in each direction.
    """
    sides = (plate.width, plate.thickness)[: dimension - 1]
    across = [
        centred(side, graded(count, 1.0)) for side, count in zip(sides, cells[:-1], strict=True)
    ]
    up = plate.height * (graded(cells[-1], 1.0) - 1)
    return grid_mesh("plate", [*across, up], cell, comm)


def grid_mesh(
    name: str,
    lines: Sequence[Array],
    cell: str | None,
    comm: MPI.Intracomm,
    *,
    there: Mask | None = None,
    lowest: FacetTag = FacetTag.BOTTOM,
) -> MeshedBody:
    """The mesh over a tensor grid, or over those of its boxes that are there; collective.

    See `grid_cells` and `tags_of_sides`; `cell` is as in `block_mesh`.
    """
    dimension = len(lines)

    def build() -> None:
        cells = grid_cells(lines, there, simplices=cell == CELLS[dimension][1])
        put(cells, tags_of_sides(cells, lowest))

    return make(name, build, dimension, comm)


def move(mesh: Mesh, placement: Placement) -> None:
    """Put a mesh somewhere else, in place: its undeformed body is then the moved one."""
    d = mesh.geometry.dim
    mesh.geometry.x[:, :d] = placement(mesh.geometry.x[:, :d])
