"""Values of nodes, cell by cell; compiled."""

from __future__ import annotations

import numpy as np

from solver.law.compiled import compiled
from solver.types import Array, Indices


@compiled
def read_cells(values: Array, index: Indices, table: Array) -> None:
    """Fill in a table, (cells, k), by the places of its numbers among the values."""
    table[:] = np.take(values, index)


@compiled
def place_in_cells(u: Array, values: Array, index: Indices, table: Array) -> None:
    """Let u be the first of the values, and read the table anew, where it is not so already."""
    before = values[: len(u)]
    # The first number differs from iterate to iterate, and is looked at by itself.
    if len(u) == 0 or (before[0] == u[0] and np.array_equal(before, u)):
        return
    before[:] = u
    read_cells(values, index, table)
