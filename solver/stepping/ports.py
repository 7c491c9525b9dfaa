"""Ports: points of a meshed body where forces act and motions are read, as rows on its nodes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import scipy.sparse as sp

from solver.bodies.surface_layer import Layer
from solver.types import Indices


@dataclass(frozen=True, slots=True)
class InterfaceDofs:
    """Points of a body where forces act and motions are read."""

    layer: Layer
    """The nodes that the rows refer to."""
    force_rows: Any
    """(points d, layer unknowns): its transpose turns point forces into nodal ones."""
    read_rows: Any
    """Rows of the same shape that read the response."""
    count: int
    """Number of points."""
    symmetric: bool
    """Whether both are the same numbers."""


class PointRows(NamedTuple):
    """Points of one group in a set of points.

    Attributes:
        layer: The nodes that their rows refer to.
        force: Their force rows, (rows, layer unknowns).
        read: Their read rows, likewise.
        place: Where their rows are among those of the set.
    """

    layer: Layer
    force: sp.csr_matrix
    read: sp.csr_matrix
    place: Indices
