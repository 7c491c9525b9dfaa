"""What `study.py` replaces: it goes with the last study that is not yet a `Study`."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any, Protocol, TypeVar

from solver.errors import NotConverged, SceneError
from solver.run.streams import say
from solver.study.folder import store
from solver.study.pool import finished_cases as finished_cases
from solver.study.pool import reason_of as reason_of


class NamedCase(Protocol):
    """A case of a study."""

    @property
    def name(self) -> str:
        """Name of the case in the study."""


class StudyPlan(Protocol):
    """A study before its cases are run."""

    @property
    def rows(self) -> Mapping[str, dict[str, Any]]:
        """Rows of the cases that have been done before, by name."""


Case = TypeVar("Case", bound=NamedCase)
Plan = TypeVar("Plan", bound=StudyPlan)


def kept_rows(
    function: Callable[[Case], dict[str, Any]],
    cases: Sequence[Case],
    rows: dict[str, dict[str, Any]],
    folder: Path,
    options: argparse.Namespace,
) -> None:
    """Run the cases that have no row yet, keep and add their rows; collective on all ranks.

    Args:
        function: What makes the row of a case; as for `finished_cases`.
        cases: What is wanted; the same on all ranks.
        rows: Rows that there are, by the names of their cases; added to on rank 0.
        folder: Where rows are kept.
        options: Of the command.
    """
    from mpi4py import MPI

    waiting = MPI.COMM_WORLD.bcast([case for case in cases if case.name not in rows])
    done, processes = len(cases) - len(waiting), options.processes
    outcomes = finished_cases(
        function, waiting, done=done, processes=processes, quiet=options.quiet
    )
    with closing(outcomes):
        for case, outcome in outcomes:
            if isinstance(outcome, Exception):
                reason = f"{case.name}: {reason_of(outcome)}"
                outcome = {"status": "failed", "reason": reason}
            rows[case.name] = outcome
            store(folder, case.name, outcome)


def run_study(
    options: argparse.Namespace,
    prepare: Callable[[argparse.Namespace], Plan],
    run_all: Callable[[Plan, dict[str, dict[str, Any]]], None],
    write: Callable[[Plan, dict[str, dict[str, Any]]], bool],
) -> int:
    """Prepare a study, run its cases, write what came of them; returns the exit code.

    Args:
        options: Of the command.
        prepare: What is refused is refused there, on rank 0, before anything is run.
        run_all: Adds the rows of the cases, on rank 0; collective on all ranks.
        write: Also after an interruption, on rank 0; whether all of it is done and right.
    """
    from mpi4py import MPI

    from solver.parallel import abort_on_exceptions, on_first_rank

    comm = MPI.COMM_WORLD
    abort_on_exceptions(comm)
    plan: Plan = on_first_rank(comm, lambda: prepare(options))
    rows = dict(plan.rows)
    try:
        run_all(plan, rows)
    finally:
        good = write(plan, rows) if comm.rank == 0 else None
    return 0 if comm.bcast(good) else NotConverged.exit_code


def tell(text: str, rows: Iterable[Mapping[str, Any]], folder: Path) -> None:
    """Say what a study found, what of it failed, and where everything stands."""
    failed = (row["reason"] for row in rows if row["status"] != "completed")
    say(text + "".join(f"failed: {reason}\n" for reason in failed))
    say(f"written to {folder}\n")


def check_processes(processes: int | None) -> None:
    """Refuse a number of processes below one."""
    if processes is not None and processes < 1:
        raise SceneError("-j", f"{processes}", "a whole number > 0")
