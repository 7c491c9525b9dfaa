"""The nodes of a face of a reduced body: unknowns of its own, or rows of all its unknowns."""

from __future__ import annotations

from mpi4py import MPI

import numpy as np
from numpy.typing import NDArray

from solver.bodies.surface_layer import Layer
from solver.types import Array, Indices


class ReducedLayer(Layer):
    """Nodes of a face whose unknowns all are on rank 0: some are kept, others follow from them."""

    def __init__(self, comm: MPI.Intracomm, places: Indices, rows: Array, size: int):
        """Take the parts of the face.

        Args:
            comm: Communicator of the run.
            places: Where the kept nodes 0, 1, ... of the body stand on the face; known on rank 0.
            rows: Rows of the unknowns for the other nodes in their order, (m d, unknowns); the
                same.
            size: Number of nodes on the face.
        """
        self.comm, self.size, self.direct = comm, size, False
        self._places, self._rows = places, rows
        others = np.ones(size, dtype=np.bool_)
        others[places] = False
        self._others = np.flatnonzero(others)

    def part(self, chosen: NDArray[np.int64]) -> Layer:
        """The layer of some of its nodes, in the order of their places here."""
        return _PartOfLayer(self, chosen)

    def gather(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Values of the face, (size, ...), from those of the owned unknowns, (n, ...)."""
        shape = self.size, *values.shape[1:]
        result = np.empty(shape)
        if self.comm.rank == 0:
            result[self._places] = values[: len(self._places)]
            if len(self._others):
                flat = values.reshape(self._rows.shape[1], -1)
                result[self._others] = (self._rows @ flat).reshape(-1, *values.shape[1:])
        if self.comm.size > 1:
            self.comm.Bcast(result, root=0)
        return result

    def add(self, target: NDArray[np.float64], values: NDArray[np.float64]) -> None:
        """Add values of the face to those of the owned unknowns, in place."""
        if self.comm.rank != 0:
            return
        target[: len(self._places)] += values[self._places]
        if len(self._others):
            others = values[self._others]
            flat = others.reshape(len(self._rows), -1)
            target += (self._rows.T @ flat).reshape(target.shape)


class _PartOfLayer(Layer):
    """Some nodes of a layer."""

    def __init__(self, whole: Layer, chosen: NDArray[np.int64]):
        """Take the layer and the places of the nodes in it."""
        self._whole, self._chosen = whole, chosen
        self.size, self.direct = len(chosen), False

    def gather(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Values of the chosen nodes."""
        return self._whole.gather(values)[self._chosen]

    def add(self, target: NDArray[np.float64], values: NDArray[np.float64]) -> None:
        """Add to their values."""
        all_of_them = np.zeros((self._whole.size, *values.shape[1:]))
        all_of_them[self._chosen] = values
        self._whole.add(target, all_of_them)
