"""What large bodies take of the memory of this machine, and the linear solver that this allows.

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

PLANE_ENTRIES = 1.5e6
"""Entries of CHOLMOD's factor of a body in the plane beyond which vectors have a factor of PETSc's
own. CHOLMOD takes 6.6 ms for one of 52 000 unknowns (3.7e6 entries), PETSc 3.4 ms, and both 1.0 ms
for 19 000 (1.2e6): there a cache holds the factor. To make it, 0.5 s, takes as long as 150 of the
times that are saved. In blocks of many right-hand sides CHOLMOD takes 1.7 ms for each. In space
PETSc would factorize for minutes."""

DIRECT_PART = 0.25
"""Part of the memory that one factorization may take; beyond it bodies are solved by CG."""

ALONE_RANKS = 4
"""Most ranks of which the first alone factorizes a body, if it has the memory. A back substitution
is bound by the memory that a processor reads, and MUMPS takes 1.6 times as long for it on one rank
as CHOLMOD: two ranks gain nothing on that, and wait for each other in hundreds of messages."""

KEPT_PART = 0.5
"""Part of the memory for factorizations and compliances of several step sizes. Those used least
recently are dropped beyond it, and made anew when they are asked for."""

LEFT_PART = 0.05
"""Part of the memory that compliances leave free."""

SMALL = 1e8
"""Memory below which free memory is not asked for, bytes."""

COPIES = 13
"""Matrices of the size of the compliance at the peak of a step: those of two tangents and the mass,
turned ones of a tangent and the mass, factors and inverses of both their local problems, and while
impulses are found two more of W and one of equations. These are 12; 12.6 of them are in use at the
peak while the points of a block in space begin to slip."""

ASKED_PART = 0.5
"""Part of it that is asked for when one of the three is computed: at that time there are either
fewer of the matrices than half, or the other half stands already."""

CONTROL_GROUP = Path("/sys/fs/cgroup/memory.max")
"""Where Linux says how much memory a container may use."""


class MemoryExceeded(RockslipError):
    """What would not fit into memory; its text is one line."""

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
    """Memory of one factor, bytes."""
    return BYTES_AN_ENTRY * factor_entries(unknowns, dimension)


def factor_entries(unknowns: int, dimension: int) -> float:
    """Entries of the factor of a body: as measured with CHOLMOD on blocks of cubes."""
    each = 4.5 * math.log2(unknowns + 1) if dimension == 2 else 16.0 * math.cbrt(unknowns)
    return each * unknowns


def has_vector_factor(entries: float, dimension: int) -> bool:
    """Whether single vectors are solved for with a factor of their own, on one rank."""
    return dimension == 2 and entries > PLANE_ENTRIES


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


def memory_of(comm: Any) -> float:
    """Memory of all machines that the ranks run on, bytes, the same on every rank; collective."""
    return machines(comm) * float(min(comm.allgather(total_memory())))


def linear_solver(unknowns: int, dimension: int, ranks: int, memory: float) -> str:
    """The solver of a body: by one factorization wherever that leaves room for a few of them."""
    if factor_bytes(unknowns, dimension) > DIRECT_PART * memory:
        return "CG + GAMG"
    return "CHOLMOD" if ranks == 1 else "MUMPS"


def solves_on_first(unknowns: int, dimension: int, comm: Any) -> bool:
    """Whether the first of a few ranks is to solve for all of them; collective."""
    if comm.size > ALONE_RANKS:
        return False
    memory = min(comm.allgather(total_memory()))
    return linear_solver(unknowns, dimension, 1, memory) == "CHOLMOD"


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
    """The linear solver of a body on one rank, and the memory that it and contact take."""
    solver = linear_solver(unknowns, dimension, 1, total_memory())
    contact = f"{in_words(compliance_bytes(points, dimension))} for {points} points on its bottom"
    if solver == "CG + GAMG":
        return f"{solver}; {contact}"
    factors = 2 if has_vector_factor(factor_entries(unknowns, dimension), dimension) else 1
    each = in_words(factors * factor_bytes(unknowns, dimension))
    ranks = f"MUMPS on more than {ALONE_RANKS} ranks"
    return f"{solver} ({ranks}), {each} for each step size and rho_inf; {contact}"


def limits_in_words(ranks: int) -> str:
    """The linear solver of meshed bodies on so many ranks, and up to which size on this machine."""
    sizes = []
    for dimension in (2, 3):
        unknowns = 1000
        while factor_bytes(2 * unknowns, dimension) <= DIRECT_PART * total_memory():
            unknowns *= 2
        sizes.append(f"{unknowns / 1e6:.2g} million unknowns in {dimension}-D")
    direct = "CHOLMOD" if ranks <= ALONE_RANKS else "MUMPS"
    return f"{direct} to about {' and '.join(sizes)}, CG + GAMG beyond"
