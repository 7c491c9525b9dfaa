"""Gmsh models: made on rank 0, structured, and distributed by dolfinx."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from mpi4py import MPI

import gmsh
import numpy as np
from dolfinx.mesh import Mesh, MeshTags
from numpy.typing import NDArray

from geometry.cells import HEXAHEDRON, QUADRILATERAL, TETRAHEDRON, TRIANGLE
from geometry.compat import model_to_mesh
from geometry.convex import Convex
from geometry.gmsh_session import silent_model
from geometry.polygon import around
from geometry.tags import ALL_CELLS, FacetTag
from solver.types import Array, Indices, Mask

CELLS = {2: ("quadrilateral", "triangle"), 3: ("hexahedron", "tetrahedron")}
"""Shapes of cells in the plane and in space, the usual one first."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MeshedBody:
    """The mesh of a body in the body's own frame."""

    mesh: Mesh
    facet_tags: MeshTags
    """Values of `FacetTag`, on all of the boundary."""


def make(name: str, build: Callable[[], None], dimension: int, comm: MPI.Intracomm) -> MeshedBody:
    """The mesh that `build` makes in a new Gmsh model, called on rank 0; collective."""
    with silent_model(name) if comm.rank == 0 else nullcontext():
        if comm.rank == 0:
            build()
        mesh, _, facet_tags = model_to_mesh(gmsh.model, comm, dimension)
    return MeshedBody(mesh=mesh, facet_tags=facet_tags)


def rectangle(x: Array, y: Array, *, triangles: bool) -> None:
    """Mesh the rectangle over the tensor grid of x and y in the current Gmsh model, tags included.

    One straight line per cell edge, so that the grading is ours to the last digit.
    """
    surface, sides = _gridded_surface(x, y, triangles=triangles)
    gmsh.model.geo.synchronize()
    gmsh.model.addPhysicalGroup(2, [surface], ALL_CELLS)
    faces = (FacetTag.BOTTOM, FacetTag.RIGHT, FacetTag.TOP, FacetTag.LEFT)
    for face, lines in zip(faces, sides, strict=True):
        gmsh.model.addPhysicalGroup(1, lines, face)
    gmsh.model.mesh.generate(2)


def box(x: Array, y: Array, z: Array, *, tetrahedra: bool) -> None:
    """Mesh the box over the tensor grid of x, y and z in the current Gmsh model, tags included.

    Hexahedra are the bottom's quadrilaterals pulled up layer by layer. Tetrahedra are made of them,
    five of each.
    """
    geo = gmsh.model.geo
    bottom, sides = _gridded_surface(x, y, triangles=False, level=float(z[0]))
    height = z[-1] - z[0]
    layers = ((z[1:] - z[0]) / height).tolist()
    top, volume, *lateral = geo.extrude(
        [(2, bottom)], 0, 0, height, numElements=[1] * len(layers), heights=layers, recombine=True
    )
    geo.synchronize()
    gmsh.model.addPhysicalGroup(3, [volume[1]], ALL_CELLS)
    faces = {FacetTag.BOTTOM: [bottom], FacetTag.TOP: [top[1]]}
    # One lateral surface per line of the bottom, in their order.
    walls = iter(surface for _, surface in lateral)
    for face, lines in zip(
        (FacetTag.FRONT, FacetTag.RIGHT, FacetTag.BACK, FacetTag.LEFT), sides, strict=True
    ):
        faces[face] = [next(walls) for _ in lines]
    for face, surfaces in faces.items():
        gmsh.model.addPhysicalGroup(2, surfaces, face)
    gmsh.model.mesh.generate(3)
    if tetrahedra:
        split_into_simplices([x, y, z])


def convex(part: Convex, tags: Sequence[int], size: float) -> None:
    """Mesh a convex polygon or polyhedron by simplices in the current Gmsh model, tags included.

    Args:
        part: The polygon or polyhedron.
        tags: Of the faces, one for each.
        size: Length of the edges of the cells, m.
    """
    body, sides = convex_body(gmsh.model.geo, part, size)
    gmsh.model.geo.synchronize()
    gmsh.model.addPhysicalGroup(part.dimension, [body], ALL_CELLS)
    for number, side in zip(tags, sides, strict=True):
        gmsh.model.addPhysicalGroup(part.dimension - 1, [side], number)
    gmsh.model.mesh.generate(part.dimension)


def convex_body(kernel: Any, part: Convex, size: float = 0.0) -> tuple[int, list[int]]:
    """A convex polygon or polyhedron in a kernel of the current Gmsh model.

    Args:
        kernel: `gmsh.model.geo` or `gmsh.model.occ`.
        part: The polygon or polyhedron.
        size: Length of the edges of the cells at its corners, m; 0: not given there.

    Returns:
        Its number, and those of its sides.
    """
    places = np.pad(part.corners, ((0, 0), (0, 3 - part.dimension)))
    points = [kernel.addPoint(*place, size) for place in places]
    lines: dict[tuple[int, int], int] = {}

    def line(a: int, b: int) -> int:
        """The line from one corner to another; negative where it is there the other way round.

        Not for OpenCASCADE, which turns lines round by itself.
        """
        if (b, a) in lines:
            return lines[b, a] if kernel is gmsh.model.occ else -lines[b, a]
        return lines.setdefault((a, b), kernel.addLine(points[a], points[b]))

    if part.dimension == 2:
        sides = [line(*face) for face in part.faces]
        return kernel.addPlaneSurface([kernel.addCurveLoop(sides)]), sides
    sides = [
        kernel.addPlaneSurface([kernel.addCurveLoop([line(*ends) for ends in around(face)])])
        for face in part.faces
    ]
    return kernel.addVolume([kernel.addSurfaceLoop(sides)]), sides


def _gridded_surface(
    x: Array, y: Array, *, triangles: bool, level: float = 0.0
) -> tuple[int, list[list[int]]]:
    """A transfinite rectangle over a tensor grid; returns it and the lines of its four sides.

    The sides run round it from the first corner: along x, along y, and back.
    """
    geo = gmsh.model.geo
    sides = [
        [(a, y[0]) for a in x],
        [(x[-1], b) for b in y],
        [(a, y[-1]) for a in x[::-1]],
        [(x[0], b) for b in y[::-1]],
    ]
    # Every side gives its first corner; the last point of a side is the first of the next one.
    points = [[geo.addPoint(a, b, level) for a, b in side[:-1]] for side in sides]
    loop = [point for side in points for point in side]
    lines = [geo.addLine(a, b) for a, b in around(loop)]
    surface = geo.addPlaneSurface([geo.addCurveLoop(lines)])
    for line in lines:
        geo.mesh.setTransfiniteCurve(line, 2)
    # Alternating diagonals: for an even number of cells along the width the mesh is its own mirror
    # image and prefers no side. They meet the bottom corners, which thus belong to two cells.
    geo.mesh.setTransfiniteSurface(surface, "AlternateLeft", [side[0] for side in points])
    if not triangles:
        geo.mesh.setRecombine(2, surface)
    ends = np.cumsum([0, *(len(side) for side in points)])
    return surface, [lines[a:b] for a, b in pairwise(ends)]


# The corners of a cell that share an edge with each of its corners, in Gmsh's order of corners.
AROUND = {
    QUADRILATERAL: np.array([[1, 3], [0, 2], [1, 3], [0, 2]]),
    HEXAHEDRON: np.array(
        [[1, 3, 4], [0, 2, 5], [1, 3, 6], [0, 2, 7], [0, 5, 7], [1, 4, 6], [2, 5, 7], [3, 4, 6]]
    ),
}


def split_into_simplices(lines: list[Array]) -> None:
    """Replace the cells of the current Gmsh model: quads by two triangles, hexahedra by five tets.

    Colour the nodes like a chessboard: every diagonal joins two nodes of the same colour as the
    first corner of the grid. So neighbours agree, and for even numbers of cells the mesh is its own
    mirror image. Bottom corners then belong to several cells. The nodes lie on the lines of a
    tensor grid.
    """
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    grid = coordinates.reshape(-1, 3)
    steps = sum(
        np.abs(along[:, None] - line).argmin(axis=1)
        for along, line in zip(grid.T[: len(lines)], lines, strict=True)
    )
    odd = np.zeros(int(tags.max()) + 1, dtype=bool)
    odd[tags] = np.asarray(steps) % 2 == 1
    kinds = (2, QUADRILATERAL, TRIANGLE), (3, HEXAHEDRON, TETRAHEDRON)
    for dimension, whole, part in kinds[: len(lines) - 1]:
        for _, entity in gmsh.model.getEntities(dimension):
            _, nodes = gmsh.model.mesh.getElementsByType(whole, entity)
            cells = nodes.reshape(-1, len(AROUND[whole]))
            gmsh.model.mesh.removeElements(dimension, entity)
            pieces = _pieces(cells, odd[cells], AROUND[whole])
            gmsh.model.mesh.addElementsByType(entity, part, [], pieces.ravel())


def _pieces(cells: NDArray[np.uint64], odd: Mask, around: Indices) -> NDArray[np.uint64]:
    """A simplex at each odd corner with its neighbours; in hexahedra one more, of the even ones."""
    corner = np.column_stack([np.arange(len(around)), around])
    cut = cells[:, corner][odd]
    if around.shape[1] == 2:
        return cut
    rest: NDArray[np.uint64] = np.concatenate([cut, cells[~odd].reshape(-1, 4)])
    return rest
