"""The mesh of a body, or of a rank's part of it, in VTK's form."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.convex import triangles_of
from solver.parallel import Comm, Single
from solver.types import Array, Indices

Values = NDArray[Any]
"""Numbers of nodes or of cells, (n,) or (n, components)."""

TRIANGLE = 5
"""VTK's number of a triangle."""

BOXES = {4: 9, 8: 12}
"""VTK's numbers of a quadrilateral and a hexahedron, by the number of their corners."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Part:
    """Nodes and the cells over them, of one kind: those that are the rank's own."""

    points: Array
    """Places of the nodes of the undeformed body, m, (n, 3)."""
    nodes: Indices
    """Numbers of the nodes of each cell among those of all ranks, one rank after the other, in
    VTK's order, (cells, nodes of a cell)."""
    kind: int
    """VTK's number of the cells."""
    comm: Comm = field(default_factory=Single)
    """The ranks that share the body."""

    def gathered(self, own: Values) -> Values:
        """Numbers of the nodes or cells of all ranks on the first one; its own on others.

        Collective.
        """
        if isinstance(self.comm, Single) or self.comm.size == 1:
            return own
        parts = self.comm.gather(own, root=0)
        return own if parts is None else np.concatenate(parts)


def one_cell(corners: Array) -> Part:
    """A body of one cell, by its corners, m, (4, 2) or (8, 3), in VTK's order."""
    count = len(corners)
    return Part(points=in_space(corners), nodes=np.arange(count)[None], kind=BOXES[count])


def triangles(corners: Array, faces: Sequence[Sequence[int]]) -> Part:
    """A body by the triangles of its faces, in the plane of itself; corners are (n, d), m."""
    return Part(points=in_space(corners), nodes=triangles_of(faces), kind=TRIANGLE)


def in_space(vectors: Array) -> Array:
    """Vectors (n, d) with the third component that VTK needs, (n, 3)."""
    spatial = np.zeros((len(vectors), 3))
    spatial[:, : vectors.shape[1]] = vectors
    return spatial


def rigid_fields(displacement: Array, velocity: Array) -> dict[str, Values]:
    """The fields of a rigid body at its corners, by the motion of these, (n, d), m and m/s.

    Displacements are places in the ground frame minus those where it stands upright. Contact
    pressure is zero: the forces of contact are points of their own (`solver.fields.contacts`).
    """
    return {
        "displacement": in_space(displacement),
        "velocity": in_space(velocity),
        "contact_pressure": np.zeros(len(displacement)),
    }
