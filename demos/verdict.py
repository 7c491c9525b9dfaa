"""The verdict of a program on its own results."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from mpi4py import MPI


def verdict(program: str, results: Sequence[tuple[bool, str]]) -> int:
    """Say which checks hold, and in one line which do not; returns the exit code.

    Under `mpirun` one rank speaks.

    Args:
        program: Whose line it is.
        results: Whether each check holds, and what it says.
    """
    failed = [line for good, line in results if not good]
    if MPI.COMM_WORLD.rank:
        return 1 if failed else 0
    sys.stdout.writelines(f"  holds: {line}\n" for good, line in results if good)
    if failed:
        sys.stdout.flush()
        sys.stderr.write(f"{program}: check failed: {'; '.join(failed)}\n")
    return 1 if failed else 0
