"""Communication among the ranks of a run: sums, broadcasts, and the surface layer they all hold."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from solver.errors import RockslipError
from solver.launcher import was_launched

if TYPE_CHECKING:
    from mpi4py import MPI


class Single:
    """The one rank of a command that shares no mesh, in place of a communicator."""

    rank, size = 0, 1

    def bcast(self, value: Any, root: int = 0) -> Any:
        """The value."""
        return value


Comm: TypeAlias = "MPI.Intracomm | Single"


def world(*, meshed: bool = False) -> Comm:
    """All ranks there are: without MPI, whose start takes a quarter of a second, where one will do.

    A mesh needs MPI even on one rank.

    Raises:
        ImportError: MPI is needed and not there.
    """
    if not meshed and not was_launched():
        return Single()
    from mpi4py import MPI

    return MPI.COMM_WORLD


def global_sum(comm: MPI.Intracomm, values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Sum of an array over all ranks."""
    if comm.size == 1:
        return values
    total = np.empty_like(values)
    comm.Allreduce(values, total)
    return total


def global_sums(comm: MPI.Intracomm, values: list[float]) -> list[float]:
    """Sums of several numbers over all ranks."""
    return values if comm.size == 1 else [*map(float, global_sum(comm, np.array(values)))]


def global_max(comm: MPI.Intracomm, values: list[float]) -> list[float]:
    """The largest value on any rank, of each of several."""
    if comm.size == 1:
        return values
    return [max(each) for each in zip(*comm.allgather(values), strict=True)]


def any_rank(comm: Comm, flag: bool) -> bool:
    """True on every rank where `flag` is true on one."""
    if isinstance(comm, Single) or comm.size == 1:
        return flag
    return bool(comm.allreduce(int(flag)))


def on_first_rank(comm: Comm, action: Callable[[], Any]) -> Any:
    """Run `action` on rank 0; its result, or the error that it raises, reaches every rank."""
    answer: Any = None
    if comm.rank == 0:
        try:
            answer = action()
        except RockslipError as error:
            answer = error
    answer = comm.bcast(answer, root=0)
    if isinstance(answer, RockslipError):
        raise answer
    return answer


def abort_on_exceptions(comm: Comm) -> None:
    """Let an unexpected exception on one rank end all of them, not leave the others waiting."""
    if isinstance(comm, Single) or comm.size == 1:
        return
    usual = sys.excepthook

    def hook(kind: Any, value: Any, trace: Any) -> None:
        usual(kind, value, trace)
        sys.stderr.flush()
        comm.Abort(1)

    sys.excepthook = hook


def abort_others(code: int) -> None:
    """End all ranks with an exit code where there are others, which may wait for this one."""
    loaded = sys.modules.get("mpi4py.MPI")
    if loaded is not None and loaded.COMM_WORLD.size > 1:
        sys.stderr.flush()
        loaded.COMM_WORLD.Abort(code)


class Layer:
    """The nodes of the cells next to a surface, in one order on every rank.

    Contact couples all points of a surface through the rigid motion of the body; there are few of
    them, so every rank holds them all and the contact problem is solved on each, with the same
    digits.
    """

    def __init__(
        self,
        comm: MPI.Intracomm,
        local: NDArray[np.int32],
        position: NDArray[np.int64],
        nodes: NDArray[np.int64],
    ):
        """Set up the exchange over the ranks of a mesh.

        `local` are the owned nodes of this rank that are in the layer, `position` where each of
        them stands in it, `nodes` the global numbers of all its nodes, in its order.
        """
        self.comm, self.local, self.position, self.nodes = comm, local, position, nodes
        self.size = size = len(nodes)
        self.direct = comm.size == 1
        """Whether its nodes are read and written where the owned ones stand."""
        if comm.size == 1:
            self.index = np.empty(size, dtype=np.int64)
            self.index[position] = local
        else:
            self.counts = np.array(comm.allgather(len(local)))
            self.order = np.concatenate(comm.allgather(position)).astype(np.int64)

    def numbers(self, nodes: NDArray[np.int64]) -> NDArray[np.int64]:
        """Where nodes of the layer stand in what `reached` and `room` give."""
        return self.index[nodes] if self.direct else nodes

    def reached(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Values of all nodes, (n, ...), from those of the owned ones; without a copy if `direct`.

        Else they are those of the layer.
        """
        return values if self.direct else self.gather(values)

    def room(self, target: NDArray[np.float64]) -> NDArray[np.float64]:
        """Where to add what belongs to owned nodes, (n, ...); `put` then takes it over."""
        return target if self.direct else np.zeros((self.size, *target.shape[1:]))

    def put(self, target: NDArray[np.float64], values: NDArray[np.float64]) -> None:
        """Add to a target what `room` gave for it, where it is not the target itself."""
        if values is not target:
            self.add(target, values)

    def part(self, chosen: NDArray[np.int64]) -> Layer:
        """The layer of some of its nodes, in the order of their places here; collective."""
        place = np.full(self.size, -1)
        place[chosen] = np.arange(len(chosen))
        mine = place[self.position]
        inside = mine >= 0
        return Layer(self.comm, self.local[inside], mine[inside], self.nodes[chosen])

    def gather(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Values of the layer, (size, ...), from those of the owned nodes, (n, ...)."""
        if self.comm.size == 1:
            return values.take(self.index, axis=0)  # five times as fast as values[self.index]
        mine = np.ascontiguousarray(values[self.local])
        width = int(np.prod(mine.shape[1:]))
        together = np.empty((len(self.order), *mine.shape[1:]))
        offsets = np.concatenate([[0], np.cumsum(self.counts)[:-1]])
        receive: Any = [together, (self.counts * width, offsets * width), "d"]
        self.comm.Allgatherv(mine, receive)
        result = np.empty((self.size, *mine.shape[1:]))
        result[self.order] = together
        return result

    def add(self, target: NDArray[np.float64], values: NDArray[np.float64]) -> None:
        """Add values of the layer to those of the owned nodes, in place."""
        if self.comm.size == 1:
            target[self.index] = target.take(self.index, axis=0) + values
        else:
            target[self.local] += values[self.position]
