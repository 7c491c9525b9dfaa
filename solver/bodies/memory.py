"""Memory that large bodies take of this machine.

Plain numbers: `rockslip check` says them without any mesh.
"""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Any

from solver.errors import RockslipError

BYTES_AN_ENTRY = 10.0
"""Memory of an entry of a factor, with its indices and the largest of its fronts, bytes."""

KEPT_PART = 0.5
"""Part of the memory for factorizations and compliances of several step sizes. Those used least
recently are dropped beyond it, and made anew when needed."""

LEFT_PART = 0.05
"""Part of the memory that compliances leave free."""

SMALL = 1e8
"""Memory below which free memory is not looked up, bytes."""

COPIES = 15
"""Matrices of the size of the compliance at the peak of a step: those of tangents and of the mass,
turned ones, and the factors and inverses of both local problems. 14.4 were counted where the points
of a block in space begin to slip."""

ASKED_PART = 0.5
"""Part of it that has to be free when the compliance of one tangent is computed: the other half is
either in use by then, or comes later."""

CONTROL_GROUP = Path("/sys/fs/cgroup/memory.max")
"""File with the memory that a container may use, on Linux."""


class MemoryExceeded(RockslipError):
    """Need of more memory than there is; its text is one line."""

    exit_code = 2


def total_memory() -> float:
    """Memory of this machine, or what a container may use of it, bytes."""
    total = float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    try:
        return min(total, float(CONTROL_GROUP.read_text()))
    except (OSError, ValueError):  # no limit, or none that can be read
        return total


def free_memory() -> float:
    """Memory that a process can still get, bytes."""
    try:
        text = Path("/proc/meminfo").read_text()
        free = 1024.0 * float(text.split("MemAvailable:")[1].split()[0])
    except (OSError, IndexError):
        return total_memory()
    try:
        used = float(CONTROL_GROUP.with_name("memory.current").read_text())
        files = CONTROL_GROUP.with_name("memory.stat").read_text()
        cached = float(files.split("inactive_file ")[1].split()[0])  # given back where needed
        return min(free, float(CONTROL_GROUP.read_text()) - used + cached)
    except (OSError, ValueError, IndexError):
        return free


def factor_bytes(unknowns: int, dimension: int) -> float:
    """Memory of the factor of a body, bytes: as measured with CHOLMOD on blocks of cubes."""
    each = 4.5 * math.log2(unknowns + 1) if dimension == 2 else 16.0 * math.cbrt(unknowns)
    return BYTES_AN_ENTRY * each * unknowns


def compliance_bytes(points: int, dimension: int) -> float:
    """Memory of the compliance among contact points with all matrices of its size, bytes."""
    return COPIES * 8.0 * (points * dimension) ** 2


def machines(comm: Any) -> int:
    """Number of machines that the ranks run on; collective."""
    if comm.size == 1:
        return 1
    from mpi4py import MPI

    shared = comm.Split_type(MPI.COMM_TYPE_SHARED)
    first = int(shared.rank == 0)
    shared.Free()
    return int(comm.allreduce(first))


def kept_limit(comm: Any) -> float:
    """Memory for factorizations and compliances of several step sizes, bytes.

    That of the first rank's machine, and so the same on every rank.
    """
    return float(comm.bcast(KEPT_PART * total_memory()))


def in_words(size: float) -> str:
    """An amount of memory."""
    unit, factor = ("GB", 1e9) if size >= 1e9 else ("MB", 1e6)
    number = size / factor
    if number < 0.1:
        return f"{size / 1e3:.0f} kB"
    return f"{number:.1f} {unit}" if number < 10 else f"{number:.0f} {unit}"


def require(needed: float, what: str, remedy: str, comm: Any) -> None:
    """Let what needs memory begin only where every rank finds as much, bytes; collective.

    Raises:
        MemoryExceeded: There is not, on all ranks alike.
    """
    if needed < SMALL:
        return
    free = max(0.0, free_memory() - LEFT_PART * total_memory()) * machines(comm) / comm.size
    free = min(comm.allgather(free))
    if needed > free:
        amounts = f"{in_words(needed)} of memory, {in_words(free)} are free"
        raise MemoryExceeded(f"{what} takes {amounts}: {remedy}")


def solver_in_words(unknowns: int, points: int, dimension: int) -> str:
    """The linear solver of a body, and the memory that it and contact take."""
    each = in_words(factor_bytes(unknowns, dimension))
    contact = f"{in_words(compliance_bytes(points, dimension))} for {points} points on its bottom"
    return f"CHOLMOD (MUMPS on ranks), {each} for each step size and rho_inf; {contact}"


def limits_in_words(ranks: int) -> str:
    """The linear solver of meshed bodies on so many ranks, and up to which size on this machine."""
    sizes = []
    for dimension in (2, 3):
        unknowns = 1000
        while factor_bytes(2 * unknowns, dimension) <= KEPT_PART * total_memory():
            unknowns *= 2
        sizes.append(f"{unknowns / 1e6:.2g} million unknowns in {dimension}-D")
    return f"{'CHOLMOD' if ranks == 1 else 'MUMPS'} to about {' and '.join(sizes)}"
