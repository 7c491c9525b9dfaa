"""The mesh of a block: a Gmsh model, made on rank 0 and distributed by dolfinx."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from mpi4py import MPI

import gmsh
import numpy as np
from dolfinx.mesh import Mesh, MeshTags
from numpy.typing import NDArray

from geometry.block import Block
from geometry.compat import model_to_mesh
from geometry.tags import CellTag, FacetTag

CELLS = ("quadrilateral", "triangle")


@dataclass(frozen=True, slots=True, kw_only=True)
class BlockMesh:
    """A block's mesh in its own frame: x in [-B/2, B/2], y in [0, H]."""

    mesh: Mesh
    cell_tags: MeshTags
    """Values of `CellTag`."""
    facet_tags: MeshTags
    """Values of `FacetTag`, on all of the boundary."""


def graded(count: int, ratio: float) -> NDArray[np.float64]:
    """Points 0 ... 1 of `count` cells growing geometrically, the last `ratio` times the first."""
    sizes = ratio ** (np.arange(count) / max(count - 1, 1))
    return _points(sizes)


def graded_to_both_ends(count: int, ratio: float) -> NDArray[np.float64]:
    """Points 0 ... 1 of `count` cells, in the middle `ratio` times as long as at both ends."""
    to_end = np.minimum(np.arange(count), np.arange(count)[::-1])
    sizes = ratio ** (to_end / max((count - 1) // 2, 1))
    return _points(sizes)


def _points(sizes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points 0 ... 1 between cells of these relative sizes."""
    points = np.concatenate([[0.0], np.cumsum(sizes)])
    fractions: NDArray[np.float64] = points / points[-1]
    return fractions


def block_mesh(
    shape: Block,
    *,
    cells: tuple[int, int] = (6, 16),
    cell: str = "quadrilateral",
    refinement: float = 1.0,
    comm: MPI.Intracomm = MPI.COMM_WORLD,
) -> BlockMesh:
    """Mesh a block in its own frame; collective.

    Args:
        shape: The block.
        cells: Number of cells along width and height, each >= 1.
        cell: "quadrilateral" or "triangle" (two for each quadrilateral).
        refinement: The longest edges over those at the bottom corners, >= 1, along width and along
            height each for itself.
        comm: The ranks that share the mesh.
    """
    # Checked before anything collective, alike on every rank.
    if min(cells) < 1 or cell not in CELLS or not refinement >= 1:
        raise ValueError(f"block_mesh: cells={cells}, cell={cell!r}, refinement={refinement}")
    x = graded_to_both_ends(cells[0], refinement)
    x = shape.width / 2 * (x - x[::-1])  # symmetric to the last digit
    y = shape.height * graded(cells[1], refinement)
    with _gmsh_model("block", comm):
        if comm.rank == 0:
            _structured_rectangle(x, y, triangles=cell == "triangle")
        mesh, cell_tags, facet_tags = model_to_mesh(gmsh.model, comm, 2)
    return BlockMesh(mesh=mesh, cell_tags=cell_tags, facet_tags=facet_tags)


@contextmanager
def _gmsh_model(name: str, comm: MPI.Intracomm) -> Iterator[None]:
    """A silent Gmsh model on rank 0; leaves no trace, also in a Gmsh that the caller has open."""
    if comm.rank != 0:
        yield
        return
    ours = not gmsh.isInitialized()
    if ours:
        gmsh.initialize(readConfigFiles=False, interruptible=False)
    terminal = gmsh.option.getNumber("General.Terminal")
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.add(name)
    try:
        yield
    finally:
        gmsh.model.remove()
        gmsh.option.setNumber("General.Terminal", terminal)
        if ours:
            gmsh.finalize()


def _structured_rectangle(
    x: NDArray[np.float64], y: NDArray[np.float64], *, triangles: bool
) -> None:
    """Mesh the rectangle over the tensor grid of x and y in the current Gmsh model, tags included.

    One straight line per cell edge, so that the grading is ours to the last digit.
    """
    geo = gmsh.model.geo
    sides = {
        FacetTag.BOTTOM: [(a, y[0]) for a in x],
        FacetTag.RIGHT: [(x[-1], b) for b in y],
        FacetTag.TOP: [(a, y[-1]) for a in x[::-1]],
        FacetTag.LEFT: [(x[0], b) for b in y[::-1]],
    }
    # Every side gives its first corner; the last point of a side is the first of the next one.
    points = {tag: [geo.addPoint(a, b, 0.0) for a, b in side[:-1]] for tag, side in sides.items()}
    loop = [point for side in points.values() for point in side]
    lines = [geo.addLine(a, b) for a, b in zip(loop, loop[1:] + loop[:1], strict=True)]
    surface = geo.addPlaneSurface([geo.addCurveLoop(lines)])
    for line in lines:
        geo.mesh.setTransfiniteCurve(line, 2)
    # Alternating diagonals: for an even number of cells along the width the mesh is its own mirror
    # image and prefers no side. They meet the bottom corners, which thus belong to two cells.
    geo.mesh.setTransfiniteSurface(surface, "AlternateLeft", [side[0] for side in points.values()])
    if not triangles:
        geo.mesh.setRecombine(2, surface)
    geo.synchronize()
    gmsh.model.addPhysicalGroup(2, [surface], CellTag.BLOCK)
    first = 0
    for tag, side in points.items():
        gmsh.model.addPhysicalGroup(1, lines[first : first + len(side)], tag)
        first += len(side)
    gmsh.model.mesh.generate(2)
