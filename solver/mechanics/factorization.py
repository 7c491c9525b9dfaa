"""A factorized symmetric matrix: CHOLMOD on one rank where PETSc has it, MUMPS otherwise."""

from __future__ import annotations

from petsc4py import PETSc

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Factorization:
    """Back substitutions with one factorization, on vectors of the owned unknowns."""

    def __init__(self, matrix: PETSc.Mat):
        """Factorize `matrix`, which is kept."""
        self.matrix = matrix
        candidates = [("cholmod", "cholesky")] if matrix.comm.size == 1 else []
        for package, kind in [*candidates, ("mumps", "lu")]:
            try:
                self._factor = self._factorize(package, kind)
                self.package = package
                break
            except PETSc.Error:
                if package == "mumps":
                    raise
        self._b, self._x = matrix.createVecs()

    def _factorize(self, package: str, kind: str) -> PETSc.Mat:
        """Set up a factorization with one of PETSc's packages; PETSc.Error where it is missing."""
        self._pc = PETSc.PC().create(self.matrix.comm)
        self._pc.setOperators(self.matrix)
        self._pc.setType(kind)
        self._pc.setFactorSolverType(package)
        self._pc.setUp()
        return self._pc.getFactorMatrix()

    def solve(self, right: Array) -> Array:
        """K^-1 r for one vector."""
        self._b.array[:] = right
        self._factor.solve(self._b, self._x)
        return self._x.array_r.copy()

    def solve_many(self, right: Array) -> Array:
        """K^-1 B, column by column."""
        result = np.empty_like(right)
        for k in range(right.shape[1]):
            result[:, k] = self.solve(right[:, k])
        return result
