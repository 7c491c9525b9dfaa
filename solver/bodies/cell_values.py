"""Values of functions cell by cell, kept for forms that are assembled again and again."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from dolfinx import fem

from solver.bodies.kernels.cells import place_in_cells, read_cells
from solver.bodies.packed_form import packed_coefficients
from solver.types import Array


class CellValues:
    """Values of some functions cell by cell, as the forms of cells take them.

    dolfinx packs all functions of a form at each assembly, which takes a third of its time.
    """

    def __init__(self, form: Any, functions: Sequence[fem.Function]):
        """Ask dolfinx for the order of the values, of a compiled form of these functions."""
        self._arrays = [function.x.array for function in functions]
        kept = [array.copy() for array in self._arrays]
        starts = np.cumsum([0, *map(len, kept)])
        for array, start in zip(self._arrays, starts, strict=False):
            array[:] = start + np.arange(len(array))
        self.packed = packed_coefficients(form)
        for array, before in zip(self._arrays, kept, strict=True):
            array[:] = before
        (table,) = self.packed.values()
        order = table.astype(np.int64)
        self._parts = []
        for start, end in pairwise(starts):
            columns = ((order[:1] >= start) & (order[:1] < end)).ravel().nonzero()[0]
            part = slice(columns[0], columns[-1] + 1) if len(columns) else slice(0, 0)
            self._parts.append((np.ascontiguousarray(order[:, part] - start), table[:, part]))
        for number in range(len(functions)):
            self.read(number)

    def read(self, number: int) -> None:
        """Take the present values of a function."""
        read_cells(self._arrays[number], *self._parts[number])

    def place(self, number: int, u: Array) -> None:
        """Let u be the values of a function whose nodes are all on this rank, and take them.

        Nothing is done where they are so already, as after the last residual of a step.
        """
        place_in_cells(u, self._arrays[number], *self._parts[number])
