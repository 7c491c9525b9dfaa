"""Contact compliance (Delassus operator) of an elastic body.

It is computed many columns at a time, as points come near contact.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from solver.bodies.elastic_body import ElasticBody
from solver.bodies.factorization import Inverse, blocks
from solver.bodies.memory import ASKED_PART, compliance_bytes, require
from solver.bodies.reduced.body import ReducedBody
from solver.contact.nitsche_points import same
from solver.stepping.columns import COPIED, FEW, Columns, rows_of
from solver.stepping.ports import InterfaceDofs, PointRows
from solver.types import Array, Indices

TOGETHER = 1.0 / 6.0
"""Back substitutions that each column costs, beside one for all, where several are solved for at a
time: 2.2 for six and 5 for 24 in all, from 6 to 53 thousand unknowns in the plane and in space."""

KEPT_AT_ONCE = 0.25
"""Time to read all columns, over that of a back substitution, up to which they are kept as they are
computed. To get the memory for more takes a fifth of the time of W, which rocking never wins back.
"""

WORTH_READING = 0.75
"""Time to read the columns of the ports that forces act at, over that of a back substitution, up to
which they are worth having."""

MOST_KEPT = 1.0
"""Time to read all columns kept of such ports, over that of a back substitution, at most."""

MOST_MEMORY = 2.0
"""Memory of these columns, over that of the factor, at most: CG reads much more than it takes."""

NONE: Indices = np.empty(0, dtype=np.int64)
"""No ports."""


@dataclass(frozen=True, slots=True)
class PortCompliance:
    """What unit forces at some ports of a body move."""

    ports: Indices
    """Numbers of the ports."""
    matrix: Array
    """Compliance among them, (m d, m d), m/N."""


class SavedCompliance(NamedTuple):
    """What the digits of further answers of a compliance depend on.

    Attributes:
        batches: Ports whose compliance was computed together, and ports whose columns were to be
            kept with that because forces act there; either may be none. In order.
        gathered: Ports that were asked for last.
        without: Back substitutions' time that columns of such ports would have saved since then.
    """

    batches: list[tuple[Indices, Indices]]
    gathered: Indices
    without: float


class Compliance:
    """What unit forces at the ports of a body move: K^-1 (force rows)^T, read through other rows.

    In the frame that rotates with the body all of it is constant. A column is computed when its
    point first comes near contact, so that a standing block never pays for its sides and top; and
    only the rows of such points are kept.
    """

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
        self._batches: list[tuple[Indices, Indices]] = []
        self._matrix = np.empty((0, 0))
        self.columns: Columns | None = self._no_columns()
        """Columns of all ports that have been near; None where these are too many."""
        self._acting, self._without = self._no_columns(), 0.0
        """Where not all columns are kept, those of ports that are pressed, or were."""
        self._gathered = PortCompliance(self._known, self._matrix)

    @property
    def nbytes(self) -> float:
        """Memory of the factor and of what is kept of its columns, on all ranks together, bytes."""
        columns = len(self._acting.values.T)
        if self.columns is not None:
            columns += len(self.columns.values.T)
        compliance = self.body.comm.size * self._matrix.nbytes
        return self.factor.nbytes + 8.0 * columns * self.body.unknowns + compliance

    def among(
        self, chosen: Indices, pressed: Callable[[], Indices] = lambda: NONE
    ) -> PortCompliance:
        """The compliance of some ports; kept for as long as the same ports are asked for.

        Where some of it has to be computed, it is asked which ports are pressed.
        """
        if not same(chosen, self._gathered.ports):
            self._compute_missing(chosen, pressed)
            self._gathered = self._gather(chosen)
        return self._gathered

    def _compute_missing(
        self, ports: Indices, pressed: Callable[[], Indices] = lambda: NONE
    ) -> None:
        """Compute the columns that some of these ports still lack; collective."""
        if same(ports, self._gathered.ports):
            return
        missing = ports[self._place[ports] < 0]
        if len(missing):
            self._compute(missing, pressed())

    def saved(self) -> SavedCompliance:
        """What `repeat` needs to find the same digits."""
        return SavedCompliance(list(self._batches), self._gathered.ports, self._without)

    def repeat(self, saved: SavedCompliance) -> None:
        """Compute what another compliance of the same body and factor has; collective."""
        for ports, acting in saved.batches:
            if len(ports):
                self._compute(ports, acting)
            elif self.columns is None and len(missing := self._acting.lacks(acting)):
                self._make_acting(missing)  # more ranks may have some of them already
        self._without = saved.without
        if len(saved.gathered):
            self.among(saved.gathered)

    def _gather(self, chosen: Indices) -> PortCompliance:
        """The compliance of known ports: what is kept itself where these are all of them."""
        if same(chosen, self._known):
            return PortCompliance(chosen, self._matrix)
        rows = self._expand(self._place[chosen])
        return PortCompliance(chosen, self._matrix[np.ix_(rows, rows)])

    def few_columns(self, ports: Indices) -> Array | None:
        """Columns of some ports as rows, (m d, owned unknowns); None where they are not few."""
        self._compute_missing(ports)
        return None if self.columns is None else self.columns.of_few(ports)

    def displacement(self, ports: Indices, vectors: Array) -> Array:
        """What forces (m, d) at some ports do to the owned unknowns, m."""
        self._compute_missing(ports)
        if self.columns is not None:
            return self.columns.under(ports, vectors)
        acting = vectors.any(axis=1)
        ports, vectors = ports[acting], vectors[acting]
        if self._has_acting(ports):
            return self._acting.under(ports, vectors)
        right = np.zeros((self.body.owned, self.body.dimension))
        for port, own, mine in self._groups(ports):
            rows = port.force_rows[self._expand(own)]
            nodal = rows.T @ vectors[mine].ravel()
            port.layer.add(right, np.asarray(nodal).reshape(port.layer.size, -1))
        flat = right.ravel()
        flat[self.body.fixed] = 0.0
        return self.factor.solve(flat)

    def _no_columns(self) -> Columns:
        """Columns of none of the ports."""
        return Columns(self.body.size, self.body.dimension, int(self._first[-1]))

    def _reading(self, ports: int) -> float:
        """Time to read the columns of so many ports, over that of a back substitution."""
        return ports * self.body.dimension * self.body.unknowns / self.factor.reads

    def _reading_of(self, ports: int, kept: int) -> float:
        """Time to read the columns of so many ports among those that are kept of acting ones.

        Over that of a back substitution; infinite where too many are kept, by the time to read them
        all or by their memory.
        """
        numbers = kept * self.body.dimension * self.body.unknowns
        if self._reading(kept) > MOST_KEPT or 8.0 * numbers > MOST_MEMORY * self.factor.nbytes:
            return math.inf
        return self._reading(min(COPIED * ports, kept))

    def _has_acting(self, ports: Indices) -> bool:
        """Whether there are columns of the ports that forces act at.

        Columns that are missing are made once they would have saved as much time as they cost:
        forces that go on to act there, as under a block that stands or the corner on which one
        rocks, save it from then on, and others lose no more than that. Those that are kept make way
        where to read beside them takes too long.
        """
        missing = self._acting.lacks(ports)
        read = self._reading_of(len(ports), len(self._acting.ports) + len(missing))
        anew = read > WORTH_READING
        if anew:
            missing, read = ports, self._reading_of(len(ports), len(ports))
            if read > WORTH_READING:
                return False
        if len(missing):
            self._without += 1.0 - read
            if self._without < 1.0 + TOGETHER * self.body.dimension * len(missing):
                return False
            self._without = 0.0
            if anew:
                self._acting = self._no_columns()
                self._batches = [(known, NONE) for known, _ in self._batches if len(known)]
            self._make_acting(missing)
        return True

    def _make_acting(self, ports: Indices) -> None:
        """Solve for the columns of ports that forces act at, and keep them."""
        self._batches.append((NONE, ports.copy()))
        acting, count = self._parts(ports), len(ports) * self.body.dimension
        self._acting.extend(ports)
        unit = self._unit_forces(acting, slice(0, count), forces=True)
        self._acting.values[:, -count:] = self.factor.solve_many(unit)

    def _expand(self, points: Indices) -> Indices:
        """Row numbers of the d directions of points."""
        return rows_of(points, self.body.dimension)

    def _groups(self, points: Indices) -> Iterator[tuple[InterfaceDofs, Indices, Indices]]:
        """For each group that has any of the points: itself, their numbers in it, places here."""
        for port, first in zip(self.ports, self._first[:-1], strict=True):
            mine = np.flatnonzero((points >= first) & (points < first + port.count))
            if len(mine):
                yield port, points[mine] - first, mine

    def _compute(self, missing: Indices, pressed: Indices) -> None:
        """Solve for the columns of further points, and keep their rows beside those known before.

        Where columns are not kept, those of ports that are pressed are, if they pay.

        Raises:
            MemoryExceeded: There is no room for as many.
        """
        self._batches.append((missing.copy(), pressed.copy()))
        d, before = self.body.dimension, len(self._matrix)
        known = np.concatenate([self._known, missing])
        require(
            ASKED_PART * (compliance_bytes(len(known), d) - compliance_bytes(len(self._known), d)),
            f"{self.body.name}: the compliance of {len(known)} contact points",
            "use larger cells on the faces that touch",
            self.body.comm,
        )
        matrix = np.empty((len(known) * d, len(known) * d))
        matrix[:before, :before] = self._matrix
        self._make_room(missing, pressed, len(known))
        wanted = self._expand(self._keep(missing, pressed))
        kept = self._acting.values.T[len(self._acting.values.T) - len(wanted) :]
        acting, near = self._parts(missing), self._parts(known)
        for block in blocks(len(matrix) - before, self.body.unknowns):
            place = slice(before + block.start, before + block.stop)
            response = self.factor.solve_many(self._unit_forces(acting, block, forces=True))
            matrix[:, place] = self._read(near, response, forces=False)
            if self.columns is not None:
                self.columns.values[:, place] = response
            first, last = wanted.searchsorted((block.start, block.stop))
            kept[first:last] = response.T[wanted[first:last] - block.start]
            if before and not self._symmetric:
                response = self.factor.solve_many(self._unit_forces(acting, block, forces=False))
                matrix[place, :before] = self._read(near, response, forces=True)[:before].T
        if self._symmetric:
            matrix[before:, :before] = matrix[:before, before:].T
            own = matrix[before:, before:]
            own[:] = 0.5 * (own + own.T)
        self._place[missing] = len(self._known) + np.arange(len(missing))
        self._known, self._matrix = known, matrix

    def _make_room(self, missing: Indices, pressed: Indices, count: int) -> None:
        """Room for the columns of further ports, `count` of them in all.

        If these are too many, for none of them; of ports that are pressed those that are there stay
        if they pay. A back substitution with the mass of a small body reads next to nothing, but
        what comes before it takes longer than to read a few columns.
        """
        before, numbers = self.columns, count * self.body.dimension * self.body.unknowns
        if before is None:
            return
        if numbers <= FEW or self._reading(count) <= KEPT_AT_ONCE:
            before.extend(missing)
            return
        self.columns = None
        known = np.setdiff1d(pressed, before.lacks(pressed))
        if self._reading_of(len(known), len(known)) <= WORTH_READING:
            self._acting.take(known, before)

    def _keep(self, missing: Indices, pressed: Indices) -> Indices:
        """Make room for the columns of ports that are pressed; their places among the missing.

        They are solved for anyway, and to read them takes less than a back substitution.
        """
        kept = np.flatnonzero(np.isin(missing, pressed))
        read = self._reading_of(len(kept), len(self._acting.ports) + len(kept))
        if self.columns is not None or read > WORTH_READING:
            kept = np.empty(0, dtype=np.int64)
        self._acting.extend(missing[kept])
        return kept

    def _parts(self, points: Indices) -> list[PointRows]:
        """Rows of points, and of their layers the nodes that these touch; collective."""
        found, d = [], self.body.dimension
        for port, own, mine in self._groups(points):
            chosen = self._expand(own)
            force = sp.csr_matrix(port.force_rows[chosen])
            read = sp.csr_matrix(port.read_rows[chosen])
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
