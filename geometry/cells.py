"""Cells of one kind, their boundary, and how they come out of a Gmsh model."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from geometry.convex import normals_of
from geometry.gmsh_session import elements_of_model, nodes_of_model
from solver.types import Array, Indices

TRIANGLE, QUADRILATERAL, TETRAHEDRON, HEXAHEDRON = 2, 3, 4, 5
"""Gmsh's numbers of kinds of cells with straight edges."""

NAMES = {
    TRIANGLE: "triangle",
    QUADRILATERAL: "quadrilateral",
    TETRAHEDRON: "tetrahedron",
    HEXAHEDRON: "hexahedron",
}
"""Names of these."""

CORNERS = {(2, 3): TRIANGLE, (2, 4): QUADRILATERAL, (3, 4): TETRAHEDRON, (3, 8): HEXAHEDRON}
"""The kind of a cell by its dimension and the number of its corners."""

SIDES = {
    TRIANGLE: ((0, 1), (1, 2), (2, 0)),
    QUADRILATERAL: ((0, 1), (1, 2), (2, 3), (3, 0)),
    TETRAHEDRON: ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)),
    HEXAHEDRON: (
        *((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4)),
        *((1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
    ),
}
"""Corners around each facet of a cell, in Gmsh's order of corners."""

SIMPLICES = {
    TRIANGLE: ((0, 1, 2),),
    QUADRILATERAL: ((0, 1, 2), (0, 2, 3)),
    TETRAHEDRON: ((0, 1, 2, 3),),
    HEXAHEDRON: ((0, 1, 3, 4), (2, 1, 3, 6), (5, 1, 4, 6), (7, 3, 4, 6), (1, 3, 4, 6)),
}
"""Simplices of which cells are made."""

FACETS = {2: 1, 3: TRIANGLE, 4: QUADRILATERAL}
"""Gmsh's number of the kind of a facet by its corners."""


@dataclass(frozen=True, slots=True, eq=False)
class Cells:
    """Cells of one kind.

    Raises:
        ValueError: Cells without a volume.
    """

    points: Array
    """Nodes, (n, d), m; some may be of no cell."""
    numbers: Indices
    """Nodes at the corners of each cell in Gmsh's order, (m, k)."""
    kind: int
    """Gmsh's number of their kind."""
    boundary: Indices = field(init=False)
    """Nodes of the facets that one cell has alone, anticlockwise seen from outside."""
    pieces: int = field(init=False)
    """How many bodies they are: cells hang together by facets."""

    def __post_init__(self) -> None:
        """Find the boundary."""
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import connected_components

        sides = np.array(SIDES[self.kind])
        facets = self.numbers[:, sides].reshape(-1, sides.shape[1])
        owner = np.repeat(np.arange(len(self.numbers)), len(sides))
        _, first, which, uses = np.unique(
            np.sort(facets, axis=1),
            axis=0,
            return_index=True,
            return_inverse=True,
            return_counts=True,
        )
        which = which.reshape(-1)
        alone = uses[which] == 1
        outside = self._outwards(facets[alone], owner[alone])
        pairs = coo_array(
            (np.ones(len(facets)), (owner, owner[first][which])), shape=(len(self.numbers),) * 2
        )
        object.__setattr__(self, "boundary", outside)
        count = int(connected_components(pairs, directed=False)[0]) if len(self.numbers) else 0
        object.__setattr__(self, "pieces", count)

    def _outwards(self, facets: Indices, owner: Indices) -> Indices:
        """Facets of cells turned so that they are seen anticlockwise from outside."""
        middles = self.points[facets].mean(axis=1)
        away = middles - self.points[self.numbers[owner]].mean(axis=1)
        across = normals_of(self.points, facets)
        inwards = np.einsum("ij,ij->i", across, away) < 0
        return np.where(inwards[:, None], facets[:, ::-1], facets)

    @property
    def dimension(self) -> int:
        """2 in the plane, 3 in space."""
        return self.points.shape[1]

    @property
    def name(self) -> str:
        """Name of their kind."""
        return NAMES[self.kind]

    @property
    def kind_of_facets(self) -> int:
        """Gmsh's number of the kind of their facets."""
        return FACETS[len(SIDES[self.kind][0])]

    @property
    def nodes(self) -> int:
        """How many nodes they have."""
        return len(np.unique(self.numbers))

    @property
    def shortest_edge(self) -> float:
        """Length of the shortest edge, m."""
        sides = np.array(SIDES[self.kind])
        ends = self.points[self.numbers[:, sides]]
        return float(np.linalg.norm(ends - np.roll(ends, 1, axis=2), axis=3).min())

    @property
    def volumes(self) -> Array:
        """Volumes of the cells, by simplices, m^3; in the plane areas, m^2."""
        total: Array = np.zeros(len(self.numbers))
        for corners in SIMPLICES[self.kind]:
            x: Array = self.points[self.numbers[:, corners]]
            total += np.abs(np.linalg.det(x[:, 1:] - x[:, :1]))
        return total / (2 if self.dimension == 2 else 6)

    def moved(self, by: ArrayLike) -> Cells:
        """The cells moved by a vector (d,), m."""
        return Cells(self.points + np.asarray(by), self.numbers, self.kind)


def cells_of_model(dimension: int) -> Cells:
    """The cells of Gmsh's current model, by their corners.

    Raises:
        ValueError: There are none, of several kinds, or of another one than triangles,
            quadrilaterals, tetrahedra and hexahedra.
    """
    points, numbers = nodes_of_model()
    found: dict[int, list[Indices]] = {}
    for name, rows in elements_of_model(dimension, numbers):
        kind = CORNERS.get((dimension, rows.shape[1]))
        if kind is None:
            raise ValueError(f"got cells of the kind '{name}', allowed tetrahedra or hexahedra")
        found.setdefault(kind, []).append(rows)
    if not found:
        raise ValueError(f"got no cells in {'space' if dimension == 3 else 'the plane'}")
    if len(found) > 1:
        raise ValueError(
            f"got {' and '.join(NAMES[kind] for kind in found)} cells, allowed those of one kind"
        )
    ((kind, all_rows),) = found.items()
    return Cells(np.ascontiguousarray(points[:, :dimension]), np.concatenate(all_rows), kind)
