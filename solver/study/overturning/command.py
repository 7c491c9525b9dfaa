"""`rockslip study overturning`: which pulses overturn a block, amplitude against frequency."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from solver.errors import SceneError
from solver.study.cases import check_processes

if TYPE_CHECKING:
    from solver.study.overturning.case import OverturningCase
    from solver.study.overturning.rounds import Wanted

ENOUGH_FRICTION = 1.7
"""Friction with which no block slides that a sudden acceleration can rock (Shenton 1996)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """Plan of a study.

    Attributes:
        folder: Where the study goes.
        wanted: What is asked for.
        rows: Rows of the cases that have been done before, by name.
    """

    folder: Path
    wanted: Wanted
    rows: dict[str, dict[str, Any]]


def run(options: argparse.Namespace) -> int:
    """The study; 0 where all cases completed, 3 where one failed."""
    from solver.study.cases import run_study

    cases: list[OverturningCase] = []
    return run_study(
        options,
        prepare,
        lambda plan, rows: _run_all(plan, cases, rows, options),
        lambda plan, rows: _write(plan, cases, rows, quiet=options.quiet),
    )


def _run_all(
    plan: Plan,
    cases: list[OverturningCase],
    rows: dict[str, dict[str, Any]],
    options: argparse.Namespace,
) -> None:
    """Run round after round, and add their cases and rows; collective on all ranks."""
    from mpi4py import MPI

    from solver.study.cases import kept_rows
    from solver.study.overturning.case import run_case

    comm, wanted, more = MPI.COMM_WORLD, plan.wanted, plan.wanted.first()
    for number in range(wanted.rounds + 2):
        cases += more
        kept_rows(run_case, more, rows, plan.folder, options)
        # Rank 0 alone has the rows.
        last = number == wanted.rounds
        found = (wanted.others(rows) if last else wanted.more(cases, rows)) if not comm.rank else []
        more = comm.bcast(found) if number <= wanted.rounds else []


def prepare(options: argparse.Namespace) -> Plan:
    """Look at everything that can be refused before anything is run, and claim the folder."""
    from solver import VERSION
    from solver.study.folder import finished
    from solver.study.overturning.folder import FOLDER
    from solver.study.standing import variant

    check_processes(options.processes)
    wanted = _wanted(options)
    folder: Path = options.output or Path(options.scene.stem + ".overturning")
    settings = {
        "version": VERSION,
        "scene": variant(wanted.tables).to_dict(),
        "amplitudes": list(wanted.amplitudes),
    }
    FOLDER.claim(folder, settings, force=options.force, resume=options.resume)
    return Plan(folder=folder, wanted=wanted, rows=finished(folder))


def _wanted(options: argparse.Namespace) -> Wanted:
    """What is asked for on the command line."""
    from solver.errors import Statement
    from solver.study.overturning.case import scan
    from solver.study.overturning.pulses import PULSES as KNOWN
    from solver.study.overturning.rounds import Wanted
    from solver.study.standing import is_elastic, numbers, standing_block, words

    amplitudes = numbers("--amplitudes", options.amplitudes)
    if options.amplitudes.count(":") != 2 or len(amplitudes) < 3 or amplitudes[-1] <= amplitudes[0]:
        raise SceneError("--amplitudes", options.amplitudes, "LOW:HIGH:COUNT, COUNT >= 3")
    restitutions = numbers("--restitution", options.restitution) if options.restitution else []
    if any(e > 1 for e in restitutions):
        raise SceneError("--restitution", options.restitution, "0 < e <= 1")
    if not 0 <= options.rounds <= 10:
        raise SceneError("--rounds", f"{options.rounds}", "0 <= rounds <= 10")
    tables = standing_block(options.scene, options.overrides)
    if options.elastic and not is_elastic(tables):
        raise Statement("block", "has no young and poisson, which --elastic needs")
    own = tables["block"][0].get("restitution")
    beside = {"ode": options.ode, "elastic": options.elastic}
    return Wanted(
        tables=tables,
        pulses=tuple(words("--pulses", options.pulses, tuple(KNOWN))),
        frequencies=tuple(numbers("--frequencies", options.frequencies)),
        restitutions=tuple(restitutions) or (own,),
        amplitudes=scan(amplitudes[0], amplitudes[-1], len(amplitudes)),
        rounds=options.rounds,
        beside={name: tuple(numbers(f"--{name}", text)) for name, text in beside.items() if text},
    )


def _write(
    plan: Plan,
    cases: list[OverturningCase],
    rows: Mapping[str, dict[str, Any]],
    *,
    quiet: bool,
) -> bool:
    """Write tables and pictures of what has been done, and tell; whether all of it was done."""
    from solver.study.cases import tell
    from solver.study.overturning import table
    from solver.study.overturning.folder import SUMMARY, TABLE
    from solver.study.overturning.folder import TEXT as TEXT_FILE
    from solver.study.tables import as_csv, write

    known = [rows[case.name] for case in cases if case.name in rows]
    done, text = [row for row in known if row["status"] == "completed"], ""
    if done:
        edges = table.boundary_rows(done, plan.wanted.restitutions[0])
        text = table.as_text(edges)
        write(plan.folder / TABLE, as_csv(edges, table.NAMES))
        write(plan.folder / TEXT_FILE, text)
        counts = {"cases": len(cases), "completed": len(done)}
        counts["runs"] = sum(row["runs"] for row in done)
        write(plan.folder / SUMMARY, counts | {"largest_difference": table.differences(edges)})
        _draw(plan, done)
    if not quiet:
        tell(text, known, plan.folder)
    return len(done) == len(cases)


def _draw(plan: Plan, done: list[dict[str, Any]]) -> None:
    """Draw the pictures."""
    from solver.study.overturning.folder import OVER_RESTITUTION, PICTURE
    from solver.study.overturning.picture import overturning_picture, restitution_picture

    wanted, file = plan.wanted, plan.folder / PICTURE
    rigid = [row for row in done if row["engine"] == "rigid"]
    first = [row for row in rigid if row["restitution"] == wanted.restitutions[0]]
    others = [
        row
        for row in done
        if row["engine"] == "elastic"
        or (row["engine"] == "ode" and row["restitution"] == wanted.restitutions[0])
    ]
    if len({row["frequency"] for row in first}) > 1:
        words = _title(wanted, wanted.restitutions[0])
        overturning_picture(first, others, words, wanted.amplitudes[-1], file)
    if len(wanted.restitutions) > 1 and len({row["frequency"] for row in rigid}) <= 6:
        restitution_picture(rigid, _title(wanted), plan.folder / OVER_RESTITUTION)


def _title(wanted: Wanted, restitution: float | None = None) -> str:
    """Slenderness, restitution and friction of the rigid block, in words."""
    from solver.reference.housner import housner_restitution
    from solver.study.standing import variant

    scene = variant(wanted.tables, model="rigid")
    block = scene.blocks[0]
    parts = [f"H/B = {block.height / block.width:g}"]
    if len(wanted.restitutions) == 1 or restitution is not None:
        housners = max(0.0, housner_restitution(block.shape))
        parts.append(f"e = {restitution or housners:.4g}")
        if restitution is None:
            parts[-1] += " (Housner's)"
    mu = scene.friction_of(block).dynamic
    parts.append(f"mu = {mu:g}" + (", blocks may slide" if mu < ENOUGH_FRICTION else ""))
    return ", ".join(parts)
