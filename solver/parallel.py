"""The ranks of a run: which one this process is, sums, and broadcasts."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeAlias

from solver.errors import RockslipError

if TYPE_CHECKING:
    from mpi4py import MPI

    from solver.types import Array


#: Variables that launchers set to the rank of a process.
VARIABLES = ("OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK", "SLURM_PROCID")


def _rank() -> int | None:
    """The rank that a launcher gave to this process; None without one."""
    for variable in VARIABLES:
        if os.environ.get(variable, "").isdigit():
            return int(os.environ[variable])
    return None


def was_launched() -> bool:
    """True if a launcher started this process, so that there may be other ranks."""
    return _rank() is not None


def launched_rank() -> int:
    """Rank of this process in what was launched; 0 for one that stands alone."""
    return _rank() or 0


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


def global_sum(comm: MPI.Intracomm, values: Array) -> Array:
    """Sum of an array over all ranks."""
    if comm.size == 1:
        return values
    total = values.copy()
    comm.Allreduce(values, total)
    return total


def global_sums(comm: MPI.Intracomm, values: list[float]) -> list[float]:
    """Sums of several numbers over all ranks."""
    if comm.size == 1:
        return values
    return [sum(each) for each in zip(*comm.allgather(values), strict=True)]


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
