"""The meshes of blocks and plates: boxes over graded tensor grids."""

from __future__ import annotations

from mpi4py import MPI

from dolfinx.mesh import Mesh

from geometry.arrangement import Placement
from geometry.block import Block
from geometry.convex import Convex
from geometry.foundation import Plate
from geometry.gmsh_model import CELLS, MeshedBody, box, convex, make, rectangle
from geometry.grading import centred, graded, graded_to_both_ends
from geometry.tags import tags_of_faces
from solver.types import Array


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
    # Checked before anything collective, alike on every rank.
    if not (_allowed(dimension, cells, cell) and refinement >= 1):
        raise ValueError(
            f"block_mesh: dimension={dimension}, cells={cells}, cell={cell!r},"
            f" refinement={refinement}"
        )
    sides = (shape.width, shape.thickness)[: dimension - 1]
    across = [
        centred(side, graded_to_both_ends(count, refinement))
        for side, count in zip(sides, cells[:-1], strict=True)
    ]
    up = shape.height * graded(cells[-1], refinement)
    return _tensor_mesh("block", [*across, up], cell, comm)


def shape_mesh(part: Convex, size: float, comm: MPI.Intracomm = MPI.COMM_WORLD) -> MeshedBody:
    """Mesh a convex body in its own frame by triangles or tetrahedra; collective.

    Args:
        part: The body; its faces have the tags of `tags_of_faces`.
        size: Length of the edges of the cells, m.
        comm: The ranks that share the mesh.
    """
    tags = tags_of_faces([float(rise) for rise in part.normals[:, -1]])

    def build() -> None:
        convex(part, tags, size)

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
    if not _allowed(dimension, cells, cell):
        raise ValueError(f"plate_mesh: dimension={dimension}, cells={cells}, cell={cell!r}")
    sides = (plate.width, plate.thickness)[: dimension - 1]
    across = [
        centred(side, graded(count, 1.0)) for side, count in zip(sides, cells[:-1], strict=True)
    ]
    up = plate.height * (graded(cells[-1], 1.0) - 1)
    return _tensor_mesh("plate", [*across, up], cell, comm)


def _allowed(dimension: int, cells: tuple[int, ...], cell: str | None) -> bool:
    """True if there are cells of this kind and number."""
    return (
        dimension in CELLS
        and len(cells) == dimension
        and min(cells) >= 1
        and cell in (None, *CELLS[dimension])
    )


def _tensor_mesh(
    name: str, lines: list[Array], cell: str | None, comm: MPI.Intracomm
) -> MeshedBody:
    """The mesh over the tensor grid of lines."""

    def build() -> None:
        if len(lines) == 2:
            rectangle(lines[0], lines[1], triangles=cell == "triangle")
        else:
            box(lines[0], lines[1], lines[2], tetrahedra=cell == "tetrahedron")

    return make(name, build, len(lines), comm)


def move(mesh: Mesh, placement: Placement) -> None:
    """Put a mesh somewhere else, in place: its undeformed body is then the moved one."""
    d = mesh.geometry.dim
    mesh.geometry.x[:, :d] = placement(mesh.geometry.x[:, :d])
