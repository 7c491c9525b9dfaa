"""The mesh of a body, or of a rank's part of it, as VTK wants it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from solver.types import Array, Indices


@dataclass(frozen=True, slots=True, kw_only=True)
class Cells:
    """Nodes and the cells over them, all of one kind."""

    points: Array
    """Places of the nodes of the undeformed body, m, (n, 3)."""
    nodes: Indices
    """Numbers of the nodes of each cell, in VTK's order, (cells, nodes of a cell)."""
    kind: int
    """VTK's number of the cells."""


BOXES = {4: 9, 8: 12}
"""VTK's numbers of a quadrilateral and a hexahedron, by the number of their corners."""


def one_cell(corners: Array) -> Cells:
    """A body of one cell, by its corners, m, (4, 2) or (8, 3), in VTK's order."""
    count = len(corners)
    return Cells(points=in_space(corners), nodes=np.arange(count)[None], kind=BOXES[count])


def in_space(vectors: Array) -> Array:
    """Vectors (n, d) with the third component that VTK wants, (n, 3)."""
    spatial = np.zeros((len(vectors), 3))
    spatial[:, : vectors.shape[1]] = vectors
    return spatial
