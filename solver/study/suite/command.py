"""The study of a suite: one scene under many motions, side by side."""

from __future__ import annotations

import argparse
import re
from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from solver.arguments import add_overrides, add_scene, add_study_options, check_processes
from solver.errors import NotConverged, SceneError
from solver.run.streams import say
from solver.study.suite.ensemble import Ensemble, EnsemblePart, add_ensemble

if TYPE_CHECKING:
    from solver.study.suite.case import SuiteCase

TEXT = "one scene under many motions side by side: records, tables, synthetic ones"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the study."""
    add = parser.add_argument
    add_scene(parser, text="a TOML file; its motion and end are replaced")
    add(
        *("--motions", "--motion"),
        metavar="MOTION",
        nargs="+",
        action="extend",
        default=[],
        help="files, folders of files, @FILE with a name a line, or synthetic (the default)",
    )
    add("--count", type=int, metavar="N", help="number of synthetic motions, default 30")
    add("--seed", type=int, metavar="S", help="of the synthetic motions")
    add_overrides(parser)
    add(
        "--vary",
        metavar="KEY=V1,V2,...",
        nargs="+",
        action="extend",
        default=[],
        help="run all motions with each of these values, such as contact.friction=0.1,0.2",
    )
    add_ensemble(parser)
    add("--tail", type=float, default=0.0, metavar="S", help="go on after the motion, s; default 0")
    add("--reference", action="store_true", help="the rigid-body answer beside each run")
    add("--keep", action="store_true", help="keep all files of each run, in DIR/runs")
    add_study_options(parser, "suite", ".suite")


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """Plan of a suite: its folder, its cases, and what has been done.

    Attributes:
        folder: Where the suite goes.
        cases: All of them.
        varied: The columns that vary: keys, engine and level.
        ensemble: Engines and levels of intensity.
        blocks: Names of the blocks.
        notes: How motions are made up of components, and what is left out.
        rows: Rows of the cases that have been done before, by name.
    """

    folder: Path
    cases: tuple[SuiteCase, ...]
    varied: tuple[str, ...]
    ensemble: Ensemble
    blocks: tuple[str, ...]
    notes: tuple[str, ...]
    rows: dict[str, dict[str, Any]]


def run(options: argparse.Namespace) -> int:
    """`rockslip study suite`; 0 where all cases completed, 3 where one failed."""
    from mpi4py import MPI

    from solver.parallel import abort_on_exceptions, on_first_rank
    from solver.study.cases import finished_cases
    from solver.study.folder import store
    from solver.study.suite.case import run_case

    comm = MPI.COMM_WORLD
    abort_on_exceptions(comm)
    plan: Plan = on_first_rank(comm, lambda: prepare(options))
    waiting = [case for case in plan.cases if case.name not in plan.rows]
    rows = dict(plan.rows)
    outcomes = finished_cases(
        run_case, waiting, done=len(rows), processes=options.processes, quiet=options.quiet
    )
    try:
        with closing(outcomes):
            for case, outcome in outcomes:
                row = _row(case, outcome)
                if row["status"] != "interrupted":
                    rows[case.name] = row
                    store(plan.folder, case.name, row)
    finally:
        if comm.rank == 0:
            _write(plan, rows)
    failed = any(row["status"] != "completed" for row in rows.values())
    if comm.rank == 0 and not options.quiet:
        _tell(plan, rows)
    codes = comm.bcast(failed or len(rows) < len(plan.cases) if comm.rank == 0 else None)
    return NotConverged.exit_code if codes else 0


def prepare(options: argparse.Namespace) -> Plan:
    """Look at everything that can be refused before anything is run, and claim the folder."""
    from solver.scene import parse_scene, read_text, set_values
    from solver.scene.reader import read_toml
    from solver.study.folder import finished
    from solver.study.suite.case import variations
    from solver.study.suite.ensemble import read_ensemble
    from solver.study.suite.folder import FOLDER
    from solver.study.suite.motions import find_motions

    _check_numbers(options)
    path: Path = options.scene
    tables = read_toml(read_text(path), path.name)
    set_values(tables, options.overrides)
    motions, notes = find_motions(
        options.motions, tables.pop("motion", None), count=options.count, seed=options.seed
    )
    varied = list(variations(options.vary))
    base = parse_scene(tables, folder=path.parent, source=path.name)
    ensemble = read_ensemble(options, tables, path.parent, motions[0].beside)
    notes += ensemble.notes(motions[0].beside)
    for values in varied:  # one that is no valid scene is refused before anything is written
        sets = [f"{key}={value}" for key, value in values]
        moving = tables | {"motion": dict(motions[0].table)}
        parse_scene(moving, folder=path.parent, overrides=sets, source=path.name)
    if options.reference:
        from solver.reference.answer import reference_name

        reference_name(base)
    folder = options.output or Path(path.stem + ".suite")
    settings = _settings(options, base.to_dict(), motions) | ensemble.settings()
    FOLDER.claim(folder, settings, force=options.force, resume=options.resume)
    cases = tuple(
        _case(options, motion, values, tables, folder, part)
        for values in varied
        for part in ensemble.parts()
        for motion in motions
    )
    return Plan(
        folder=folder,
        cases=cases,
        varied=(*(key for key, _ in varied[0]), *ensemble.columns),
        ensemble=ensemble,
        blocks=tuple(block.name for block in base.blocks),
        notes=tuple(notes),
        rows=finished(folder),
    )


def _check_numbers(options: argparse.Namespace) -> None:
    """Refuse numbers out of range."""
    if not 0 <= options.tail < 1e6:
        raise SceneError("--tail", f"{options.tail:g}", "0 <= tail < 1e6 s")
    check_processes(options.processes)


def _settings(
    options: argparse.Namespace, scene: dict[str, Any], motions: list[Any]
) -> dict[str, Any]:
    """Settings that a suite is made from: one that is resumed must be made from the same."""
    from solver import VERSION
    from solver.study.suite.case import KEPT

    return {
        "version": VERSION,
        "kept": KEPT,
        "scene": scene,
        "vary": options.vary,
        "tail": options.tail,
        "reference": options.reference,
        "keep": options.keep,
        "motions": {motion.name: motion.table for motion in motions},
    }


def _case(
    options: argparse.Namespace,
    motion: Any,
    values: tuple[tuple[str, str], ...],
    tables: dict[str, Any],
    folder: Path,
    part: EnsemblePart,
) -> SuiteCase:
    """One motion with one combination of the varied values, for one engine and level."""
    from solver.study.suite.case import SuiteCase
    from solver.study.suite.folder import RUNS

    differing = (*values, *part.columns().items())
    parts = [motion.name, *(f"{key}={value}" for key, value in differing)]
    name = re.sub(r"[^\w.=+-]+", "_", ",".join(parts).replace(",", "__"))
    return SuiteCase(
        name=name,
        motion=motion,
        varied=values,
        engine=part.engine,
        level=part.level,
        intensity=part.intensity,
        tables=tables,
        folder=options.scene.parent,
        tail=options.tail,
        reference=options.reference,
        keep=folder / RUNS / name if options.keep else None,
    )


def _row(case: SuiteCase, outcome: Mapping[str, Any] | Exception) -> dict[str, Any]:
    """The row of a case in the table, whatever came of it."""
    from solver.study.cases import reason_of

    row: dict[str, Any] = {"motion": case.motion.name, **dict(case.varied), **_part(case).columns()}
    if case.intensity is not None:
        row["intensity"] = case.intensity.name
    if isinstance(outcome, Exception):
        return row | {"status": "failed", "reason": reason_of(outcome)}
    return row | dict(outcome)


def _part(case: SuiteCase) -> EnsemblePart:
    """Engine and level of a case."""
    return EnsemblePart(case.engine, case.level, case.intensity)


def _ordered(plan: Plan, rows: Mapping[str, dict[str, Any]]) -> list[dict[str, Any]]:
    """The rows that there are, in the order of the cases."""
    return [rows[case.name] for case in plan.cases if case.name in rows]


def _write(plan: Plan, rows: Mapping[str, dict[str, Any]]) -> None:
    """Write the tables of what has been done."""
    from solver.study.suite.folder import PICTURE, SUMMARY, TABLE, TEXT
    from solver.study.suite.table import as_csv, as_text, ratios
    from solver.study.tables import write

    ordered = _ordered(plan, rows)
    if not ordered:
        return
    write(plan.folder / TABLE, as_csv(ordered))
    write(plan.folder / TEXT, as_text(ordered, plan.varied, plan.notes))
    completed = sum(row["status"] == "completed" for row in ordered)
    counts = {"cases": len(plan.cases), "completed": completed}
    counts["failed"] = len(ordered) - completed
    found: dict[str, Any] = {"notes": plan.notes, "ratios": ratios(ordered, plan.varied)}
    if plan.ensemble.is_one:
        from solver.study.suite.findings import write_findings

        found |= write_findings(plan.folder, ordered, plan.varied, plan.blocks, plan.ensemble)
    write(plan.folder / SUMMARY, counts | found)
    if len(ordered) == len(plan.cases) and not plan.ensemble.is_one:
        from solver.study.suite.picture import suite_picture

        suite_picture(ordered, plan.varied, plan.folder / PICTURE)


def _tell(plan: Plan, rows: Mapping[str, dict[str, Any]]) -> None:
    """Print the table, of ensembles the statistics, and where it is."""
    from solver.study.suite.folder import FRAGILITY_TEXT
    from solver.study.suite.table import as_text, cautions, remarks

    ordered = _ordered(plan, rows)
    completed = sum(row["status"] == "completed" for row in ordered)
    if plan.ensemble.is_one and ordered:
        failed = [row for row in ordered if row["status"] != "completed"]
        text = (plan.folder / FRAGILITY_TEXT).read_text(encoding="utf-8")
        lines = remarks(failed, plan.varied) + cautions(ordered, plan.varied) + [*plan.notes]
        say(text + "".join(f"{line}\n" for line in lines))
    else:
        say(as_text(ordered, plan.varied, plan.notes) if ordered else "")
    say(f"{completed} of {len(plan.cases)} completed; written to {plan.folder}\n")
