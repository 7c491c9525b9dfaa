"""Contact compliance (Delassus operator) of an elastic body.

It is computed column by column, as points come near contact.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from solver.bodies.elastic_body import ElasticBody
from solver.bodies.factorization import Factorization
from solver.contact.nitsche_points import same
from solver.parallel import Layer
from solver.types import Array, Indices


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


@dataclass(frozen=True, slots=True)
class PortCompliance:
    """What unit forces at some ports of a body move."""

    ports: Indices
    """Their numbers."""
    matrix: Array
    """Compliance among them, (m d, m d), m/N."""
    responses: Array
    """Displacements of the owned unknowns, (owned, m d), m/N."""


class Compliance:
    """What unit forces at the ports of a body move: K^-1 (force rows)^T, read through other rows.

    In the frame that rotates with the body all of it is constant. A column is computed when its
    point first comes near contact, so that a standing block never pays for its sides and top.
    """

    def __init__(self, body: ElasticBody, factor: Factorization, ports: Sequence[InterfaceDofs]):
        """Start without any column; the factor is that of a tangent or mass.

        Ports are groups of points, which are numbered on from group to group.
        """
        self.body, self.factor, self.ports = body, factor, tuple(ports)
        self._first = np.concatenate([[0], np.cumsum([port.count for port in ports])])
        count = int(self._first[-1])
        self._place = np.full(count, -1)
        self._response = np.empty((body.size, 0))
        self._matrix = np.empty((count * body.dimension, 0))
        nothing = np.empty(0, dtype=np.int64)
        self._batches: list[Indices] = []
        self._gathered = PortCompliance(nothing, np.empty((0, 0)), np.empty((body.size, 0)))

    def among(self, chosen: Indices) -> PortCompliance:
        """The compliance of some ports; kept for as long as the same ports are asked for."""
        if not same(chosen, self._gathered.ports):
            missing = chosen[self._place[chosen] < 0]
            if len(missing):
                self._compute(missing)
            rows, columns = self._expand(chosen), self._expand(self._place[chosen])
            self._gathered = PortCompliance(
                chosen, self._matrix[np.ix_(rows, columns)], self._response[:, columns]
            )
        return self._gathered

    def saved(self) -> tuple[list[Indices], Indices]:
        """Which columns were computed together, in their order, and which are gathered now.

        The digits of columns depend on it: `repeat` finds the same ones.
        """
        return list(self._batches), self._gathered.ports

    def repeat(self, saved: tuple[list[Indices], Indices]) -> None:
        """Compute what another compliance of the same body and factor has; collective."""
        batches, gathered = saved
        for batch in batches:
            self._compute(batch)
        if len(gathered):
            self.among(gathered)

    def _expand(self, points: Indices) -> Indices:
        """Row numbers of the d directions of points."""
        d = self.body.dimension
        return (points[:, None] * d + np.arange(d)).ravel()

    def _compute(self, missing: Indices) -> None:
        """Solve for the columns of further points."""
        self._batches.append(missing.copy())
        d, owned = self.body.dimension, self.body.owned
        right = np.zeros((owned, d, len(missing) * d))
        for port, first in zip(self.ports, self._first[:-1], strict=True):
            mine = np.flatnonzero((missing >= first) & (missing < first + port.count))
            if len(mine):
                rows = port.force_rows[self._expand(missing[mine] - first)]
                unit = (rows if isinstance(rows, np.ndarray) else rows.toarray()).T
                columns = np.zeros((owned, d, unit.shape[1]))
                port.layer.add(columns, unit.reshape(port.layer.size, d, -1))
                right[:, :, self._expand(mine)] = columns
        right = right.reshape(self.body.size, -1)
        right[self.body.fixed] = 0.0
        response = self.factor.solve_many(right)
        read = []
        for port in self.ports:
            near = port.layer.gather(response.reshape(owned, -1)).reshape(port.layer.size * d, -1)
            read.append(port.read_rows @ near)
        self._place[missing] = self._matrix.shape[1] // d + np.arange(len(missing))
        self._matrix = np.hstack([self._matrix, np.vstack(read)])
        self._response = np.hstack([self._response, response])
