"""Columns of a compliance on all unknowns of a body: what unit forces at some of its ports do."""

from __future__ import annotations

import numpy as np

from solver.contact.nitsche_points import same
from solver.types import Array, Indices

FEW = 50_000
"""Numbers in all columns that are few: to read them takes no longer than to prepare a back
substitution, and those of the ports asked for last are kept together."""

COPIED = 3
"""Times that columns are passed over which are copied from among others to be read."""


def rows_of(points: Indices, d: int) -> Indices:
    """Row numbers of the d directions of points."""
    return (points[:, None] * d + np.arange(d)).ravel()


class Columns:
    """Displacements of the owned unknowns under unit forces at some ports of a body, m/N."""

    def __init__(self, size: int, dimension: int, ports: int):
        """Begin without columns, for a body with so many owned unknowns and ports."""
        self._d, self._room = dimension, np.empty((size, 0), order="F")
        self.values: Array = self._room
        """(owned unknowns, ports d)."""
        self.ports: Indices = np.empty(0, dtype=np.int64)
        """The ports, in the order of their columns."""
        self._place = np.full(ports, -1)
        self._last: tuple[Indices, Array] = self.ports, np.empty((0, size))
        """Ports asked for last, and their columns as rows, one after another."""

    def lacks(self, ports: Indices) -> Indices:
        """Ports, of those given, that have no columns here."""
        return ports[self._place[ports] < 0]

    def extend(self, ports: Indices) -> None:
        """Make room for the columns of further ports, which the caller fills."""
        size, before = self.values.shape
        self._place[ports] = len(self.ports) + np.arange(len(ports))
        self.ports = np.concatenate([self.ports, ports])
        end = len(self.ports) * self._d
        if end > self._room.shape[1]:
            # Twice as much: few copies of all columns then; pages that are not used take no memory.
            self._room = np.empty((size, max(end, 2 * before)), order="F")
            self._room[:, :before] = self.values
        self.values = self._room[:, :end]

    def take(self, ports: Indices, others: Columns) -> None:
        """Take over the columns that others have of further ports."""
        self.extend(ports)
        count = len(ports) * self._d
        if count:
            self.values[:, -count:] = others.values[:, rows_of(others._place[ports], self._d)]

    def of_few(self, ports: Indices) -> Array | None:
        """Columns of some of the ports as rows, (m d, owned unknowns); None where all are many."""
        if self.values.size > FEW:
            return None
        if not same(ports, self._last[0]):
            self._last = ports, self.values.T[rows_of(self._place[ports], self._d)]
        return self._last[1]

    def under(self, ports: Indices, forces: Array) -> Array:
        """What forces (m, d) at some of the ports do to the owned unknowns, m.

        Of many columns, those of ports without force are not read.
        """
        few = self.of_few(ports)
        if few is not None:
            return forces.reshape(-1).dot(few)
        acting = forces.any(axis=1)
        rows = rows_of(self._place[ports[acting]], self._d)
        flat, count = forces[acting].reshape(-1), len(self.values.T)
        if COPIED * len(rows) < count:
            return np.asarray(flat @ self.values.T[rows])
        whole = np.zeros(count)
        whole[rows] = flat
        return np.asarray(self.values @ whole)
