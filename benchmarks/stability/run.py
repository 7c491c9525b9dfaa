"""The study of stability from beginning to end: what `rockslip study stability` does."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from contextlib import closing
from functools import partial
from pathlib import Path

from mpi4py import MPI

from benchmarks.stability.families import FAMILIES, matrix
from benchmarks.stability.matrix import StabilityCase
from benchmarks.stability.sampler import draw
from benchmarks.stability.table import as_csv, as_text, sentence
from benchmarks.stability.verdict import Verdict, judge, warm_up
from solver.errors import NotConverged, SceneError
from solver.parallel import on_first_rank
from solver.run.folders import make_folder
from solver.study.pool import finished_cases, reason_of
from solver.study.tables import write as write_file

#: What the study leaves; `--force` writes over these.
TABLE, LINES, PICTURE = "stability.csv", "stability.txt", "stability.png"


def run(options: argparse.Namespace) -> int:
    """Run and judge all scenes; 0 where none failed, 3 where one did."""
    comm = MPI.COMM_WORLD
    cases: list[StabilityCase] = on_first_rank(comm, lambda: prepare(options))
    order = {case.name: number for number, case in enumerate(cases)}
    verdicts: list[Verdict] = []
    try:
        for verdict in judged(cases, options.limit, options.processes, quiet=options.quiet):
            verdicts.append(verdict)
    finally:  # what was interrupted keeps what it has
        verdicts.sort(key=lambda verdict: order[verdict.name])
        if comm.rank == 0:
            write(options.output, verdicts)
    if comm.rank == 0:
        if not options.quiet:
            told = [f"{v.verdict}: {v.name}: {v.reason}\n" for v in verdicts if v.reason]
            sys.stdout.write(f"{''.join(told)}{sentence(verdicts)}\nwritten to {options.output}\n")
    failed = any(verdict.verdict == "failed" for verdict in verdicts)
    return NotConverged.exit_code if comm.bcast(failed) else 0


def prepare(options: argparse.Namespace) -> list[StabilityCase]:
    """The scenes that are asked for, and their folder; SceneError for what cannot be."""
    for name, value in (("--random", options.random), ("--limit", options.limit)):
        if value < 0:
            raise SceneError(name, str(value), "a number >= 0")
    for family in options.families:
        if not any(known.name.startswith(family) for known in FAMILIES):
            names = ", ".join(known.name for known in FAMILIES)
            raise SceneError("--family", family, f"the beginning of one of: {names}")
    cases = draw(options.random, options.seed) if options.random else matrix()
    if options.families:
        cases = [case for case in cases if case.family.startswith(tuple(options.families))]
    make_folder(options.output, force=options.force)
    return cases


def judged(
    cases: list[StabilityCase], limit: float, processes: int | None, *, quiet: bool = False
) -> Iterator[Verdict]:
    """The verdicts of all scenes as they finish; on rank 0, the others get none."""
    warm_up()
    outcomes = finished_cases(partial(judge, limit=limit), cases, processes=processes, quiet=quiet)
    with closing(outcomes):
        for case, outcome in outcomes:
            if isinstance(outcome, Exception):
                outcome = Verdict.of(case, "failed", reason_of(outcome))
            yield outcome


def write(folder: Path, verdicts: list[Verdict]) -> None:
    """Leave the tables and the picture."""
    from benchmarks.stability.picture import picture  # matplotlib, which only this needs

    write_file(folder / TABLE, as_csv(verdicts))
    write_file(folder / LINES, as_text(verdicts))
    picture(verdicts, folder / PICTURE)
