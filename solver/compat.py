"""The one place that knows how versions of dolfinx differ (0.9 to 0.11)."""

from __future__ import annotations

from typing import Any

from petsc4py import PETSc

import numpy as np
from dolfinx import cpp, fem
from numpy.typing import NDArray


class PackedForm:
    """A compiled form whose constants are packed once: assembly in the time loop without set-up.

    Coefficients are packed anew at each assembly, constants by `refresh` only.
    """

    def __init__(self, form: Any):
        """Compile `form`."""
        self.form = fem.form(form)
        self.refresh()

    def refresh(self) -> None:
        """Read the constants again."""
        self.constants = cpp.fem.pack_constants(self.form._cpp_object)

    def _coefficients(self) -> Any:
        """The coefficient functions, cell by cell, as they are now."""
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
