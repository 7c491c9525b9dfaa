"""Vectors of all ranks at those ranks that hold a whole factorization, and back."""

from __future__ import annotations

from typing import Any

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np

from solver.types import Array


class WholeVectors:
    """Brings the owned parts of vectors together on each rank, or on the first alone."""

    def __init__(self, matrix: PETSc.Mat, *, everywhere: bool):
        """Learn who owns what of a matrix; collective."""
        self._comm: MPI.Intracomm = matrix.comm.tompi4py()
        self._everywhere = everywhere
        self.here = everywhere or self._comm.rank == 0
        """Whether this rank holds whole vectors."""
        self._size: int = matrix.size[0]
        start, end = matrix.getOwnershipRange()
        self._own = slice(start, end)
        self._counts = np.array(self._comm.allgather(end - start))
        self._ends = np.cumsum(self._counts)
        self._part = np.empty(end - start)

    def matrix(self, distributed: PETSc.Mat) -> PETSc.Mat:
        """The whole matrix where it is held, an empty one elsewhere; collective."""
        whole = distributed.getRedundantMatrix(self._comm.size, MPI.COMM_SELF)
        if not self.here:
            whole.destroy()
            whole = PETSc.Mat().createAIJ((0, 0), comm=MPI.COMM_SELF)
            whole.setUp()
        return whole

    def gather(self, own: Array, whole: Array) -> None:
        """Fill a whole vector from the parts of all ranks."""
        offsets = self._ends - self._counts
        target: Any = [whole, (self._counts, offsets), MPI.DOUBLE]
        if self._everywhere:
            self._comm.Allgatherv(own, target)
        else:
            self._comm.Gatherv(own, target if self.here else None, root=0)

    def part(self, whole: Array) -> Array:
        """This rank's part of a whole vector."""
        if self._everywhere:
            return whole[self._own].copy()
        offsets = self._ends - self._counts
        source: Any = [whole, (self._counts, offsets), MPI.DOUBLE]
        self._comm.Scatterv(source if self.here else None, self._part, root=0)
        return self._part.copy()

    def gather_columns(self, own: Array) -> Array:
        """Whole columns, in the order of Fortran, from those of all ranks; empty elsewhere."""
        mine = np.ascontiguousarray(own.T)
        parts = self._comm.allgather(mine) if self._everywhere else self._comm.gather(mine)
        whole: Array = np.empty((own.shape[1], self._size if self.here else 0))
        if parts is not None:
            np.concatenate(parts, axis=1, out=whole)
        return whole.T

    def part_columns(self, whole: Array) -> Array:
        """This rank's rows of whole columns."""
        if self._everywhere:
            return whole[self._own]
        parts = None
        if self.here:
            parts = [rows.T.copy() for rows in np.split(whole, self._ends[:-1])]
        return np.asarray(self._comm.scatter(parts)).T
