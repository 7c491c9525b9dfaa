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
"""Of a factor, with its indices and the largest of its fronts."""

DIRECT_PART = 0.25
"""Part of the memory that one factorization may take; beyond it bodies are solved by CG."""

KEPT_PART = 0.5
"""Part of the memory for factorizations and compliances of several step sizes. Those used least
recently are dropped beyond it, and made anew when they are asked for."""

LEFT_PART = 0.05
"""Part of the memory that no compliance may take the last of."""

SMALL = 1e8
"""Memory that is had without asking, bytes."""

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
        return min(free, float(CONTROL_GROUP.read_text()) - used)
    except (OSError, ValueError):
        return free


def factor_bytes(unknowns: int, dimension: int) -> float:
    """Memory of one factorization, bytes: as measured with CHOLMOD on blocks of cubes."""
    each = 4.5 * math.log2(unknowns + 1) if dimension == 2 else 16.0 * math.cbrt(unknowns)
    return BYTES_AN_ENTRY * each * unknowns


def compliance_bytes(points: int, dimension: int) -> float:
    """Memory of the compliance among contact points with all its copies, bytes.

    It is kept for two tangents and the mass; one is turned, and the local problem of its size
    factorized.
    """
    return 5 * 8.0 * (points * dimension) ** 2


def linear_solver(unknowns: int, dimension: int, ranks: int) -> str:
    """The solver of a body: by one factorization wherever that leaves room for a few of them."""
    if factor_bytes(unknowns, dimension) > DIRECT_PART * ranks * total_memory():
        return "CG + GAMG"
    return "CHOLMOD" if ranks == 1 else "MUMPS"


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
    free = max(0.0, free_memory() - LEFT_PART * total_memory()) / comm.size
    free = min(comm.allgather(free))
    if needed > free:
        amounts = f"{in_words(needed)} of memory, {in_words(free)} can be had"
        raise MemoryExceeded(f"{what} takes {amounts}: {remedy}")


def solver_in_words(unknowns: int, points: int, dimension: int) -> str:
    """The linear solver of a body on one rank, and the memory that it and contact take."""
    solver = linear_solver(unknowns, dimension, 1)
    contact = f"{in_words(compliance_bytes(points, dimension))} for {points} points on its bottom"
    if solver == "CG + GAMG":
        return f"{solver}; {contact}"
    each = in_words(factor_bytes(unknowns, dimension))
    return f"{solver} (MUMPS with ranks), {each} for each step size and rho_inf; {contact}"


def limits_in_words(ranks: int) -> str:
    """The linear solver of meshed bodies on so many ranks, and up to which size on this machine."""
    sizes = []
    for dimension in (2, 3):
        unknowns = 1000
        while unknowns < 1e9 and linear_solver(2 * unknowns, dimension, ranks) != "CG + GAMG":
            unknowns *= 2
        sizes.append(f"{unknowns / 1e6:.2g} million unknowns in {dimension}-D")
    return f"{linear_solver(1000, 2, ranks)} to about {' and '.join(sizes)}, CG + GAMG beyond"
