"""The one place that knows how versions of dolfinx differ (0.9 to 0.11); PETSc and signals."""

from __future__ import annotations

import signal
import threading
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

from petsc4py import PETSc

import numpy as np
from dolfinx import cpp, fem
from numpy.typing import NDArray


def _ignore_closed_pipes() -> None:
    """Ignore SIGPIPE, as Python does: PETSc took it over when it was imported, and would abort."""
    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGPIPE, signal.SIG_IGN)


_ignore_closed_pipes()


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
        self.packed = {
            key: table.copy() for key, table in cpp.fem.pack_coefficients(form._cpp_object).items()
        }
        for array, before in zip(self._arrays, kept, strict=True):
            array[:] = before
        (self._table,) = self.packed.values()
        order = self._table.astype(np.int64)
        self._parts = []
        for start, end in pairwise(starts):
            columns = ((order[:1] >= start) & (order[:1] < end)).ravel().nonzero()[0]
            part = slice(columns[0], columns[-1] + 1) if len(columns) else slice(0, 0)
            self._parts.append((part, np.ascontiguousarray(order[:, part] - start)))
        for number in range(len(functions)):
            self.read(number)

    def read(self, number: int) -> None:
        """Take the present values of a function."""
        part, index = self._parts[number]
        self._table[:, part] = self._arrays[number].take(index)


class PackedForm:
    """A compiled form whose constants are packed once: assembly in the time loop without set-up.

    Constants are packed anew by `refresh` only; coefficients at each assembly, unless the form has
    been given `cells`, which then holds their values.
    """

    def __init__(self, form: Any):
        """Compile `form`."""
        self.form = fem.form(form)
        self.cells: CellValues | None = None
        self.refresh()

    def refresh(self) -> None:
        """Read the constants again."""
        self.constants = cpp.fem.pack_constants(self.form._cpp_object)

    def _coefficients(self) -> Any:
        """The coefficient functions, cell by cell, as they are now."""
        if self.cells is not None:
            return self.cells.packed
        return cpp.fem.pack_coefficients(self.form._cpp_object)

    def scalar(self) -> float:
        """Integral over the cells of this rank."""
        value = cpp.fem.assemble_scalar(self.form._cpp_object, self.constants, self._coefficients())
        return float(value)

    def vector(self, target: NDArray[np.float64]) -> None:
        """Assemble into `target` (owned and ghost entries), which is overwritten."""
        target[:] = 0
        cpp.fem.assemble_vector(target, self.form._cpp_object, self.constants, self._coefficients())

    def matrix(self) -> PETSc.Mat:
        """Assemble a PETSc matrix."""
        from dolfinx.fem.petsc import assemble_matrix

        matrix = assemble_matrix(self.form)
        matrix.assemble()
        return matrix
