"""Values of nodes, cell by cell; compiled."""

from __future__ import annotations

from solver.law.compiled import compiled
from solver.types import Array, Indices


@compiled
def read_cells(values: Array, index: Indices, table: Array) -> None:
    """Fill in a table, (cells, k), by the places of its numbers among the values."""
    for cell in range(len(index)):
        for k in range(index.shape[1]):
            table[cell, k] = values[index[cell, k]]


@compiled
def place_in_cells(u: Array, values: Array, index: Indices, table: Array) -> None:
    """Let u be the first of the values, and read the table anew, where it is not so already."""
    for k in range(len(u)):
        if values[k] != u[k]:
            values[: len(u)] = u
            read_cells(values, index, table)
            return
