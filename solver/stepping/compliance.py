"""Contact compliance (Delassus operator) of a meshed body among its ports.

Ports are points where forces act and motions are read, as rows on the nodes of the body: contact
points, and places of links. Columns
K^-1 (force rows)^T are solved for many at a time, as points first come near contact, so that a
standing block never pays for its sides and top. In the frame that turns with the body all of it is
constant. The compliance among the ports is kept; whole columns are kept with it for as long as they
take no more memory than the factor, or than 16 MB. What forces on further ports do is a back
substitution.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from solver.bodies.elastic_body import ElasticBody
from solver.bodies.factorization import Inverse, blocks
from solver.bodies.memory import ASKED_PART, compliance_bytes, require
from solver.bodies.reduced_body import ReducedBody
from solver.bodies.surface_layer import Layer
from solver.contact.nitsche_points import same
from solver.kernels import meshed
from solver.types import Array, Indices

SMALL = 2.0**24
"""Memory of columns that are kept whatever the factor takes, bytes."""


@dataclass(frozen=True, slots=True)
class InterfaceDofs:
    """Points of a body where forces act and motions are read."""

    layer: Layer
    """The nodes that the rows refer to."""
    force_rows: sp.csr_matrix
    """(points d, layer unknowns): its transpose turns point forces into nodal ones."""
    read_rows: sp.csr_matrix
    """Rows of the same shape that read the response."""
    count: int
    """Number of points."""

    @classmethod
    def of_nodes(cls, layer: Layer, d: int) -> InterfaceDofs:
        """The nodes of a layer themselves, in d dimensions."""
        rows = sp.identity(layer.size * d, format="csr")
        return cls(layer, rows, rows, layer.size)

    @property
    def symmetric(self) -> bool:
        """True if both are the same."""
        return self.force_rows is self.read_rows


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


class Compliance:
    """Motion of the ports of a body under unit forces, K^-1 (force rows)^T by other rows."""

    def __init__(
        self, body: ElasticBody | ReducedBody, factor: Inverse, ports: Sequence[InterfaceDofs]
    ):
        """Start without any column; the factor is that of a tangent or mass.

        Ports are groups of points, which are numbered on from group to group.
        """
        self.body, self.factor, self.ports = body, factor, tuple(ports)
        self._symmetric = all(port.symmetric for port in ports)
        self._first = np.concatenate([[0], np.cumsum([port.count for port in ports])])
        self._place = np.full(int(self._first[-1]), -1)
        self._known: Indices = np.empty(0, dtype=np.int64)
        self._matrix: Array = np.empty((0, 0))
        self._chosen: Indices = self._known
        self._among: Array = self._matrix  # of the ports chosen last
        self.columns: Array = np.empty((0, body.size))
        """Displacements of the owned unknowns under unit forces at the ports that were known first,
        one after another in (ports d, owned unknowns), m/N."""
        self.batches: list[Indices] = []
        """Ports whose columns were solved for together: solved for so again they have the same
        digits."""

    @property
    def nbytes(self) -> float:
        """Memory of the factor and of what is kept of its columns, on all ranks together, bytes."""
        columns = self._column_bytes(self.kept)
        return self.factor.nbytes + columns + self.body.comm.size * self._matrix.nbytes

    @property
    def kept(self) -> int:
        """Number of ports whose columns are kept."""
        return len(self.columns) // self.body.dimension

    def among(self, chosen: Indices) -> Array:
        """The compliance of some ports, (m d, m d), m/N; collective."""
        self._compute_missing(chosen)
        if not same(chosen, self._chosen):
            rows = self._expand(self._place[chosen])
            self._chosen = chosen
            self._among = np.ascontiguousarray(self._matrix[np.ix_(rows, rows)])
        return self._among

    def displacement(self, ports: Indices, forces: Array) -> Array:
        """Displacement of the owned unknowns by forces (m, d) at some ports, m; collective."""
        self._compute_missing(ports)
        kept, place = self.kept, self._place[ports]
        if kept == len(self._known) or not forces[place >= kept].any():
            moved: Array = np.zeros(self.body.size)
            meshed.add_columns(self.columns, place, forces, moved)
            return moved
        right = np.zeros((self.body.owned, self.body.dimension))
        for port, own, mine in self._groups(ports):
            nodal = port.force_rows[self._expand(own)].T @ forces[mine].ravel()
            port.layer.add(right, np.asarray(nodal).reshape(port.layer.size, -1))
        flat = right.ravel()
        flat[self.body.fixed] = 0.0
        return self.factor.solve(flat)

    def repeat(self, batches: Sequence[Indices]) -> None:
        """Solve for the same columns as another compliance of the same body; collective."""
        for ports in batches:
            self._compute(ports)

    def _column_bytes(self, ports: int) -> float:
        """Memory of the columns of so many ports, on all ranks together, bytes."""
        return 8.0 * ports * self.body.dimension * self.body.unknowns

    def _expand(self, points: Indices) -> Indices:
        """Row numbers of the d directions of points."""
        return (points[:, None] * self.body.dimension + np.arange(self.body.dimension)).ravel()

    def _groups(self, points: Indices) -> Iterator[tuple[InterfaceDofs, Indices, Indices]]:
        """For each group that has any of the points: itself, their numbers in it, places here."""
        for port, first in zip(self.ports, self._first[:-1], strict=True):
            mine = np.flatnonzero((points >= first) & (points < first + port.count))
            if len(mine):
                yield port, points[mine] - first, mine

    def _compute_missing(self, ports: Indices) -> None:
        """Solve for the columns that some of these ports still lack; collective."""
        missing = ports[self._place[ports] < 0]
        if len(missing):
            self._compute(missing)

    def _compute(self, missing: Indices) -> None:
        """Solve for the columns of further points, and keep their rows beside those known before.

        Raises:
            MemoryExceeded: There is no room for as many.
        """
        self.batches.append(missing)
        d, before = self.body.dimension, len(self._matrix)
        known = np.concatenate([self._known, missing])
        require(
            ASKED_PART * (compliance_bytes(len(known), d) - compliance_bytes(len(self._known), d)),
            f"{self.body.name}: the compliance of {len(known)} contact points",
            "use larger cells on the faces that touch",
            self.body.comm,
        )
        keeps = self._column_bytes(len(known)) <= max(self.factor.nbytes, SMALL)
        matrix = np.empty((len(known) * d, len(known) * d))
        matrix[:before, :before] = self._matrix
        acting, near = self._parts(missing), self._parts(known)
        columns = []
        for block in blocks(len(matrix) - before, self.body.unknowns):
            place = slice(before + block.start, before + block.stop)
            response = self.factor.solve_many(self._unit_forces(acting, block, forces=True))
            matrix[:, place] = self._read(near, response, forces=False)
            if keeps:
                columns.append(response.T)
            if before and not self._symmetric:
                response = self.factor.solve_many(self._unit_forces(acting, block, forces=False))
                matrix[place, :before] = self._read(near, response, forces=True)[:before].T
        if keeps:
            self.columns = np.vstack([self.columns, *columns])
        if self._symmetric:
            matrix[before:, :before] = matrix[:before, before:].T
            own = matrix[before:, before:]
            own[:] = 0.5 * (own + own.T)
        self._place[missing] = len(self._known) + np.arange(len(missing))
        self._known, self._matrix = known, matrix

    def _parts(self, points: Indices) -> list[PointRows]:
        """Rows of points, and of their layers the nodes that these touch; collective."""
        found, d = [], self.body.dimension
        for port, own, mine in self._groups(points):
            chosen = self._expand(own)
            force, read = port.force_rows[chosen], port.read_rows[chosen]
            nodes = np.unique(np.concatenate([force.indices, read.indices]) // d).astype(np.int64)
            columns = self._expand(nodes)
            rows = force[:, columns], read[:, columns]
            found.append(PointRows(port.layer.part(nodes), *rows, self._expand(mine)))
        return found

    def _unit_forces(self, parts: Sequence[PointRows], block: slice, *, forces: bool) -> Array:
        """Nodal forces of unit forces at points, those of a block of rows, (owned, rows).

        With `forces` by the rows that make nodal forces, else by those that read.
        """
        d, count = self.body.dimension, block.stop - block.start
        right: Array = np.zeros((self.body.size, count), order="F")
        columns = right.T.reshape(count, self.body.owned, d).transpose(1, 2, 0)
        for part in parts:
            inside = np.flatnonzero((part.place >= block.start) & (part.place < block.stop))
            unit = (part.force if forces else part.read)[inside].toarray()
            whole = np.zeros((part.layer.size * d, count))
            whole[:, part.place[inside] - block.start] = unit.T
            part.layer.add(columns, whole.reshape(part.layer.size, d, count))
        right[self.body.fixed] = 0.0
        return right

    def _read(self, parts: Sequence[PointRows], response: Array, *, forces: bool) -> Array:
        """Rows of points in displacements (owned, n), all of them on every rank, (m d, n)."""
        d, count = self.body.dimension, response.shape[1]
        nodes = response.T.reshape(count, self.body.owned, d).transpose(1, 2, 0)
        result = np.empty((sum(len(part.place) for part in parts), count))
        for part in parts:
            near = part.layer.gather(nodes).reshape(part.layer.size * d, count)
            result[part.place] = (part.force if forces else part.read) @ near
        return result
