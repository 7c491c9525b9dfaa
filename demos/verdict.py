"""The verdict of a program on its own results, and what every run has to keep."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from mpi4py import MPI

from solver.results.runs import Run

Results = list[tuple[bool, str]]
"""Results of checks: true if one holds, and its text."""


def kept(run: Run, name: str | None = None) -> Results:
    """Three checks of every run: that it reached its end, gained no energy, and lost track of none.

    Args:
        run: Which run.
        name: What the lines call it; None: its own name.
    """
    energy, status = run.summary["energy"], run.summary["status"]
    gain, ledger = energy["largest_gain_fraction"], energy["ledger_error_fraction"]
    name = run.label if name is None else name
    return [
        (status == "completed", f"{name}: status {status}"),
        (gain < 1e-6, f"{name}: largest energy gain {gain:.1e} of the scale, below 1e-6"),
        (ledger < 1e-8, f"{name}: ledger error {ledger:.1e} of the scale, below 1e-8"),
    ]


def all_kept(runs: Sequence[Run]) -> Results:
    """The same of many runs: one line, or those of the checks that fail."""
    lines = [line for run in runs for line in kept(run)]
    failed = [line for line in lines if not line[0]]
    whole = f"{len(runs)} runs completed, gained no energy (1e-6) and kept their ledgers (1e-8)"
    return failed or [(True, whole)]


def verdict(program: str, results: Sequence[tuple[bool, str]]) -> int:
    """Say which checks hold, and in one line which do not; returns the exit code.

    Under `mpirun` one rank speaks.

    Args:
        program: Whose line it is.
        results: Of the checks.
    """
    failed = [line for good, line in results if not good]
    if MPI.COMM_WORLD.rank:
        return 1 if failed else 0
    sys.stdout.writelines(f"  holds: {line}\n" for good, line in results if good)
    if failed:
        sys.stdout.flush()
        sys.stderr.write(f"{program}: check failed: {'; '.join(failed)}\n")
    return 1 if failed else 0
