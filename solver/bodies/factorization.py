"""Solving with the symmetric matrix of a body: factorized, or by CG where that takes too much.

CHOLMOD on one rank where PETSc has it, MUMPS otherwise; of a few ranks the first factorizes for all
of them. Single vectors of large bodies in the plane have a factor of PETSc's own. Bodies whose
factor would leave no room for others are solved by conjugate gradients with algebraic multigrid,
which knows the rigid motions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from typing import Any, Protocol

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np
from numpy.typing import NDArray

from solver.bodies.memory import (
    BYTES_AN_ENTRY,
    has_vector_factor,
    linear_solver,
    memory_of,
    solves_on_first,
)
from solver.bodies.whole_vectors import WholeVectors
from solver.errors import EnvironmentTrouble, NotConverged
from solver.parallel import global_sum, on_first_rank
from solver.types import Array

REDUNDANT_UNKNOWNS = 20_000
"""Below this, each of several ranks factorizes the whole matrix: a distributed back substitution
would cost more in messages than the whole one does in arithmetic."""

BLOCK = 128
"""Most right-hand sides at a time: one after another, each would read all of the factor."""

BLOCK_BYTES = 64e6
"""Memory of a block of right-hand sides, of which a solver makes a few copies; at least 16."""

CG_TOLERANCE = 1e-11
"""Residual that CG leaves of the right-hand side. Corrections need no more: what they leave of an
error is as small a part of it."""

MOST_CG_ITERATIONS = 1000
"""Iterations after which CG is given up."""

PASSES = {"CHOLMOD": 2.0, "MUMPS": 1.0}
"""How often a solve passes over what a package counts as entries: of one factor or of both."""

CG_PASSES = 30.0
"""Work of a solve by CG, in passes over the matrix."""

CG_BYTES = 24.0
"""Memory of an entry of a matrix that CG solves with, bytes: 12 of its own, the others for what
multigrid makes of it, of which 2 to 8 were measured."""


class Inverse(Protocol):
    """A matrix to solve with, on vectors of the owned unknowns."""

    name: str
    """The solver."""

    @property
    def reads(self) -> float:
        """Numbers that a solve for one vector reads, on all ranks together."""

    @property
    def nbytes(self) -> float:
        """Memory that it takes, on all ranks together, bytes."""

    def solve(self, right: Array) -> Array:
        """K^-1 r for one vector."""

    def solve_many(self, right: Array) -> Array:
        """K^-1 B for columns, (owned, n) in the order of Fortran, as the answer is."""


class Factorization:
    """Back substitutions with one factorization, or CG in their place."""

    def __init__(
        self,
        matrix: PETSc.Mat,
        *,
        dimension: int = 2,
        modes: Callable[[], Sequence[Array]] | None = None,
    ):
        """Factorize `matrix`, which is kept.

        Args:
            matrix: Symmetric and positive definite.
            dimension: Of the mesh, by which the size of factors is judged.
            modes: Gives the rigid motions of the owned unknowns, for the multigrid alone; without
                it a matrix is factorized whatever its size.
        """
        self._comm: MPI.Intracomm = matrix.comm.tompi4py()
        self._size = size = matrix.size[0]
        self._dimension = dimension
        self._pcs: list[PETSc.PC] = []  # which own the factors
        self._of_vectors: PETSc.Mat | None = None
        self._whole: WholeVectors | None = None
        everywhere = size < REDUNDANT_UNKNOWNS
        if self._comm.size > 1 and (everywhere or solves_on_first(size, dimension, self._comm)):
            self._whole = WholeVectors(matrix, everywhere=everywhere)
            matrix = self._whole.matrix(matrix)
        self.matrix = matrix
        self._solver: PETSc.KSP | None = None
        self._b, self._x = matrix.createVecs()
        # Views that are kept: asking PETSc for an array costs as much as a back substitution.
        self._right, self._solution = self._b.array, self._x.array
        if self._whole is not None and not everywhere:
            self.name, self.entries = on_first_rank(self._comm, self._set_up)
        elif self._whole is None and modes is not None and self._is_too_large():
            self._iterate(modes())
        else:
            self._set_up()

    def _is_too_large(self) -> bool:
        """Whether the factor would leave no room for others; collective."""
        memory = memory_of(self._comm)
        return linear_solver(self._size, self._dimension, self._comm.size, memory) == "CG + GAMG"

    @property
    def reads(self) -> float:
        """Numbers that a solve for one vector reads, on all ranks together."""
        return self.entries * (CG_PASSES if self._solver is not None else PASSES[self.name])

    @property
    def nbytes(self) -> float:
        """Memory of all factors, or of multigrid, on all ranks together, bytes."""
        if self._solver is not None:
            return CG_BYTES * self.entries
        return BYTES_AN_ENTRY * self.entries * (2 if self._has_vector_factor else 1)

    @property
    def _has_vector_factor(self) -> bool:
        """Whether vectors have a factor of their own."""
        return self.name == "CHOLMOD" and has_vector_factor(self.entries, self._dimension)

    def _set_up(self) -> tuple[str, float]:
        """Factorize with the first package that can; its name, and the entries of the factor."""
        candidates = [("cholmod", "cholesky")] if self.matrix.comm.size == 1 else []
        for package, kind in [*candidates, ("mumps", "lu")]:
            try:
                self._factor = self._factorized(package, kind)
                self.name = package.upper()
                break
            except PETSc.Error as error:
                if package == "mumps":
                    size = self.matrix.size[0]
                    raise EnvironmentTrouble(
                        f"MUMPS did not factorize a matrix of {size} unknowns: {error}"
                    ) from error
        used = self._factor.getInfo(PETSc.Mat.InfoType.GLOBAL_SUM)["nz_used"]
        self.entries = max(float(used), float(self.matrix.size[0]))
        return self.name, self.entries

    def _factorized(self, package: str, kind: str, ordering: str | None = None) -> PETSc.Mat:
        """Set up a factorization with one of PETSc's packages; PETSc.Error where it is missing."""
        pc = PETSc.PC().create(self.matrix.comm)
        pc.setOperators(self.matrix)
        pc.setType(kind)
        pc.setFactorSolverType(package)
        if ordering is not None:
            pc.setFactorOrdering(ordering)
        pc.setUp()
        self._pcs.append(pc)
        return pc.getFactorMatrix()

    def _vector_factor(self) -> PETSc.Mat:
        """The factor that single vectors are solved for with, made when it is first asked for."""
        if self._has_vector_factor:
            with suppress(PETSc.Error):  # such as no memory: that of CHOLMOD serves, too
                return self._factorized("petsc", "cholesky", "nd")
        return self._factor

    def _substitute(self) -> None:
        """Solve for the one vector that is kept."""
        if self._of_vectors is None:
            self._of_vectors = self._vector_factor()
        self._of_vectors.solve(self._b, self._x)

    def _iterate(self, modes: Sequence[Array]) -> None:
        """Set up CG, preconditioned by algebraic multigrid."""
        basis: list[PETSc.Vec] = []
        for mode in modes:
            vector = self.matrix.createVecRight()
            vector.array[:] = mode
            for other in basis:
                vector.axpy(-vector.dot(other), other)
            vector.normalize()
            basis.append(vector)
        self.matrix.setNearNullSpace(PETSc.NullSpace().create(vectors=basis, comm=self.matrix.comm))
        solver = PETSc.KSP().create(self.matrix.comm)
        solver.setOperators(self.matrix)
        solver.setType("cg")
        solver.getPC().setType("gamg")
        solver.setTolerances(rtol=CG_TOLERANCE, max_it=MOST_CG_ITERATIONS)
        solver.setUp()
        self._solver, self.name = solver, "CG + GAMG"
        self.entries = float(self.matrix.getInfo(PETSc.Mat.InfoType.GLOBAL_SUM)["nz_used"])

    def solve(self, right: Array) -> Array:
        """K^-1 r for one vector."""
        if self._whole is not None:
            self._whole.gather(right, self._right)
            if self._whole.here:
                self._substitute()
            return self._whole.part(self._solution)
        self._right[:] = right
        if self._solver is None:
            self._substitute()
        else:
            self._solver.solve(self._b, self._x)
            if self._solver.getConvergedReason() <= 0:
                raise NotConverged(f"CG with multigrid did not end in {MOST_CG_ITERATIONS} rounds")
        return self._solution.copy()

    def solve_many(self, right: Array) -> Array:
        """K^-1 B for columns, (owned, n) in the order of Fortran, as the answer is."""
        result: Array = np.empty(right.shape, order="F")
        for columns in blocks(right.shape[1], self._size):
            if self._whole is not None:
                whole = self._whole.gather_columns(right[:, columns])
                if self._whole.here:
                    whole = self._solved_block(whole)
                result[:, columns] = self._whole.part_columns(whole)
            elif self._solver is None:
                result[:, columns] = self._solved_block(right[:, columns])
            else:
                for k in range(columns.start, columns.stop):
                    result[:, k] = self.solve(np.ascontiguousarray(right[:, k]))
        return result

    def _solved_block(self, right: Array) -> Array:
        """K^-1 B for as many columns as are solved for at a time."""
        size = self.matrix.size[0]
        given, found = np.asfortranarray(right), np.empty(right.shape, order="F")
        shape: Any = (right.shape[0], size), (None, right.shape[1])
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
    """The inverse of a mass matrix, direction by direction: it knows of no other.

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

    @property
    def reads(self) -> float:
        """Numbers that a solve for one vector reads, on all ranks together."""
        return sum(factor.reads for factor in self._factors)

    @property
    def nbytes(self) -> float:
        """Memory of all factors, on all ranks together, bytes."""
        return sum(factor.nbytes for factor in set(self._factors))

    def _everywhere(self, flag: bool) -> bool:
        """Whether something is so on every rank."""
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
