"""A factorized symmetric matrix: CHOLMOD on one rank where PETSc has it, MUMPS otherwise."""

from __future__ import annotations

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np

from solver.types import Array

REDUNDANT_UNKNOWNS = 20_000
"""Below this, each of several ranks factorizes the whole matrix: a distributed back substitution
would cost more in messages than the whole one does in arithmetic."""


class Factorization:
    """Back substitutions with one factorization, on vectors of the owned unknowns."""

    def __init__(self, matrix: PETSc.Mat):
        """Factorize `matrix`, which is kept."""
        self._comm: MPI.Intracomm = matrix.comm.tompi4py()
        start, end = matrix.getOwnershipRange()
        self._own = slice(start, end)
        self._redundant = self._comm.size > 1 and matrix.size[0] < REDUNDANT_UNKNOWNS
        if self._redundant:
            matrix = matrix.getRedundantMatrix(self._comm.size, MPI.COMM_SELF)
            self._counts = np.array(self._comm.allgather(end - start))
        self.matrix = matrix
        candidates = [("cholmod", "cholesky")] if matrix.comm.size == 1 else []
        for package, kind in [*candidates, ("mumps", "lu")]:
            try:
                self._factor = self._factorize(package, kind)
                break
            except PETSc.Error:
                if package == "mumps":
                    raise
        self._b, self._x = matrix.createVecs()
        # Views that are kept: asking PETSc for an array costs as much as a back substitution.
        self._right, self._solution = self._b.array, self._x.array

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
        if self._redundant:
            offsets = np.concatenate([[0], np.cumsum(self._counts)[:-1]])
            self._comm.Allgatherv(right, [self._right, (self._counts, offsets), MPI.DOUBLE])
        else:
            self._right[:] = right
        self._factor.solve(self._b, self._x)
        return self._solution[self._own].copy() if self._redundant else self._solution.copy()

    def solve_many(self, right: Array) -> Array:
        """K^-1 B, column by column."""
        result = np.empty_like(right)
        for k in range(right.shape[1]):
            result[:, k] = self.solve(np.ascontiguousarray(right[:, k]))
        return result
