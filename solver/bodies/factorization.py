"""Solving with the symmetric matrix of a body, factorized: CHOLMOD on one rank, MUMPS on several.

Where PETSc has no CHOLMOD, MUMPS takes its place. Small bodies are factorized whole by every rank.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Protocol

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np
from numpy.typing import NDArray

from solver.bodies.memory import BYTES_AN_ENTRY, factor_bytes, require
from solver.errors import EnvironmentTrouble
from solver.parallel import global_sum
from solver.types import Array

REDUNDANT_UNKNOWNS = 20_000
"""Below this, each of several ranks factorizes the whole matrix: a distributed back substitution
would cost more in messages than the whole one does in arithmetic."""

BLOCK = 128
"""Most right-hand sides at a time: one after another, each would read all of the factor."""

BLOCK_BYTES = 64e6
"""Memory of a block of right-hand sides, of which a solver makes a few copies; at least 16."""


class Inverse(Protocol):
    """A matrix to solve with, on vectors of the owned unknowns."""

    name: str
    """The solver."""

    nbytes: float
    """Memory that it takes, on all ranks together, bytes."""

    def solve(self, right: Array) -> Array:
        """K^-1 r for one vector."""

    def solve_many(self, right: Array) -> Array:
        """K^-1 B for columns, (owned, n) in the order of Fortran, as the answer is."""


class Factorization:
    """Back substitutions with one factorization."""

    def __init__(self, matrix: PETSc.Mat, *, dimension: int = 2, what: str = "a body"):
        """Factorize `matrix`, which is kept: symmetric and positive definite; collective.

        The dimension is that of the mesh, by which the size of the factor is judged beforehand;
        `what` is its body, for messages.

        Raises:
            MemoryExceeded: There is no room for the factor.
            EnvironmentTrouble: No package factorized it.
        """
        self._comm: MPI.Intracomm = matrix.comm.tompi4py()
        self._size = matrix.size[0]
        self._own = slice(*matrix.getOwnershipRange())
        self._counts = self._comm.allgather(self._own.stop - self._own.start)
        self._gathers = 1 < self._comm.size and self._size < REDUNDANT_UNKNOWNS
        copies = self._comm.size if self._gathers else 1
        if self._gathers:
            matrix = matrix.getRedundantMatrix(copies, MPI.COMM_SELF)
        require(
            factor_bytes(self._size, dimension) * copies / self._comm.size,
            f"{what}: the factor of {self._size} unknowns",
            "use larger cells, or ranks on several machines",
            self._comm,
        )
        self.matrix = matrix
        self._b, self._x = matrix.createVecs()
        # Views that are kept: asking PETSc for an array costs as much as a back substitution.
        self._right, self._solution = self._b.array, self._x.array
        self._factorize()
        used = self._factor.getInfo(PETSc.Mat.InfoType.GLOBAL_SUM)["nz_used"]
        self.nbytes = copies * BYTES_AN_ENTRY * max(float(used), float(self._size))
        """Memory of the factor, on all ranks together, bytes."""

    def _factorize(self) -> None:
        """Factorize with the first package that can."""
        candidates = [("cholmod", "cholesky")] if self.matrix.comm.size == 1 else []
        for package, kind in [*candidates, ("mumps", "lu")]:
            self._pc = PETSc.PC().create(self.matrix.comm)  # which owns the factor
            self._pc.setOperators(self.matrix)
            self._pc.setType(kind)
            try:
                self._pc.setFactorSolverType(package)
                self._pc.setUp()
            except PETSc.Error as error:
                if package == "mumps":
                    raise EnvironmentTrouble(
                        f"MUMPS did not factorize a matrix of {self._size} unknowns: {error}"
                    ) from error
            else:
                break
        self._factor, self.name = self._pc.getFactorMatrix(), package.upper()

    def solve(self, right: Array) -> Array:
        """K^-1 r for one vector."""
        if self._gathers:
            self._comm.Allgatherv(right, [self._right, self._counts])
        else:
            self._right[:] = right
        self._factor.solve(self._b, self._x)
        return self._solution[self._own].copy() if self._gathers else self._solution.copy()

    def solve_many(self, right: Array) -> Array:
        """K^-1 B for columns, (owned, n) in the order of Fortran, as the answer is."""
        result: Array = np.empty(right.shape, order="F")
        for columns in blocks(right.shape[1], self._size):
            part = right[:, columns]
            if self._gathers:
                part = np.concatenate(self._comm.allgather(part))
            part = self._solved_block(part)
            result[:, columns] = part[self._own] if self._gathers else part
        return result

    def _solved_block(self, right: Array) -> Array:
        """K^-1 B for as many columns as are solved for at a time."""
        given, found = np.asfortranarray(right), np.empty(right.shape, order="F")
        shape: Any = (right.shape[0], self._size), (None, right.shape[1])
        b, x = (
            PETSc.Mat().createDense(shape, array=values, comm=self.matrix.comm)
            for values in (given, found)
        )
        self._factor.matSolve(b, x)
        b.destroy()
        x.destroy()
        return found


def blocks(columns: int, unknowns: int) -> Iterator[slice]:
    """Columns that are solved for at a time."""
    most = min(BLOCK, max(16, int(BLOCK_BYTES / (8 * max(unknowns, 1)))))
    for first in range(0, columns, most):
        yield slice(first, min(first + most, columns))


class MassInverse:
    """The inverse of a mass matrix, direction by direction: they are independent.

    Directions in which the same nodes are held share a factorization, of 1/d of the unknowns.
    """

    def __init__(self, matrix: PETSc.Mat, fixed: NDArray[np.int32], dimension: int):
        """Factorize the mass of one direction, and of others where other unknowns are held."""
        self._comm: MPI.Intracomm = matrix.comm.tompi4py()
        self._d = d = dimension
        start, end = matrix.getOwnershipRange()
        rows = PETSc.IS().createStride((end - start) // d, start, d, comm=matrix.comm)
        scalar = matrix.createSubMatrix(rows, rows)
        held = [fixed[fixed % d == k] // d for k in range(d)]
        self._factors: list[Factorization] = []
        for k in range(d):
            same = [j for j in range(k) if self._everywhere(np.array_equal(held[j], held[k]))]
            if same:
                self._factors.append(self._factors[same[0]])
                continue
            mass = scalar.copy()
            mass.zeroRowsColumns((held[k] + start // d).astype(np.int32), 1.0)
            self._factors.append(Factorization(mass, dimension=dimension))
        self.name = self._factors[0].name
        self.nbytes = sum(factor.nbytes for factor in set(self._factors))
        """Memory of all factors, on all ranks together, bytes."""

    def _everywhere(self, flag: bool) -> bool:
        """True if something is so on every rank."""
        return bool(self._comm.allreduce(int(flag), MPI.MIN))

    def solve(self, right: Array) -> Array:
        """M^-1 r for one vector."""
        result = np.empty_like(right)
        for k, factor in enumerate(self._factors):
            result[k :: self._d] = factor.solve(np.ascontiguousarray(right[k :: self._d]))
        return result

    def solve_many(self, right: Array) -> Array:
        """M^-1 B for columns; where a column has no part in a direction, nothing is solved for."""
        result: Array = np.zeros(right.shape, order="F")
        for k, factor in enumerate(self._factors):
            part = right[k :: self._d]
            some = global_sum(self._comm, np.any(part != 0, axis=0).astype(float)) > 0
            result[k :: self._d, some] = factor.solve_many(np.asfortranarray(part[:, some]))
        return result
