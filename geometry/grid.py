"""Cells over tensor grids: all boxes of one, or some of them, whole or cut into simplices."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geometry.cells import HEXAHEDRON, QUADRILATERAL, TETRAHEDRON, TRIANGLE, Cells
from geometry.convex import normals_of
from geometry.tags import FacetTag
from solver.types import Array, Indices, Mask

CELLS = {2: ("quadrilateral", "triangle"), 3: ("hexahedron", "tetrahedron")}
"""Shapes of cells in the plane and in space, the usual one first."""

KINDS = {2: (QUADRILATERAL, TRIANGLE), 3: (HEXAHEDRON, TETRAHEDRON)}
"""Gmsh's numbers of these."""

RING = ((0, 0), (1, 0), (1, 1), (0, 1))
"""Corners of a box in the plane, in Gmsh's order: steps along each direction."""

AROUND = {
    2: np.array([[1, 3], [0, 2], [1, 3], [0, 2]]),
    3: np.array(
        [[1, 3, 4], [0, 2, 5], [1, 3, 6], [0, 2, 7], [0, 5, 7], [1, 4, 6], [2, 5, 7], [3, 4, 6]]
    ),
}
"""The corners of a box that share an edge with each of its corners."""


def grid_cells(lines: Sequence[Array], there: Mask | None = None, *, simplices: bool) -> Cells:
    """The cells of a tensor grid.

    Simplices are two triangles of a box in the plane, five tetrahedra in space. Every diagonal
    joins two nodes of the colour of the first one, coloured like a chessboard. So neighbours agree,
    and for even numbers of cells the mesh is its own mirror image and prefers no side. Bottom
    corners then belong to several cells.

    Args:
        lines: Places of the lines along each direction, m.
        there: True where a box belongs to the body, one direction of the grid after the other;
            None: all do.
        simplices: Cut the boxes.
    """
    d, shape = len(lines), [len(line) for line in lines]
    places = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, d)
    nodes = np.arange(len(places)).reshape(shape)
    steps = RING if d == 2 else [(*step, up) for up in (0, 1) for step in RING]
    corners = [
        nodes[tuple(slice(k, count - 1 + k) for k, count in zip(step, shape, strict=True))]
        for step in steps
    ]
    boxes = np.stack(corners, axis=-1)
    cells = boxes.reshape(-1, len(steps)) if there is None else boxes[there]
    if simplices:
        cells = _simplices(cells, np.indices(shape).sum(axis=0).ravel()[cells] % 2 == 1, d)
    used, numbers = np.unique(cells, return_inverse=True)
    return Cells(places[used], numbers.reshape(cells.shape), KINDS[d][simplices])


def _simplices(boxes: Indices, odd: Mask, dimension: int) -> Indices:
    """A simplex at each odd corner with its neighbours; in space one more, of the even ones."""
    corner = np.column_stack([np.arange(len(AROUND[dimension])), AROUND[dimension]])
    cut = boxes[:, corner][odd]
    return cut if dimension == 2 else np.concatenate([cut, boxes[~odd].reshape(-1, 4)])


def tags_of_sides(cells: Cells, lowest: FacetTag = FacetTag.BOTTOM) -> Indices:
    """Tags of the facets of a body over a grid, by where they look, and upwards by their level.

    The uppermost ones are its top, those that look up below that are free; the tag of the lowest
    ones is given.
    """
    normals, level = normals_of(cells.points, cells.boundary), cells.points[cells.boundary][..., -1]
    sides = [(FacetTag.LEFT, FacetTag.RIGHT), (FacetTag.FRONT, FacetTag.BACK)]
    sides[cells.dimension - 1 :] = [(FacetTag.BOTTOM, FacetTag.FREE)]
    axis = np.argmax(np.abs(normals), axis=1)
    up = np.take_along_axis(normals, axis[:, None], axis=1)[:, 0] > 0
    tags = np.array(sides)[axis, up.astype(int)]
    tags[(level == level.max()).all(axis=1)] = FacetTag.TOP
    tags[(level == level.min()).all(axis=1)] = lowest
    return tags
