"""`rockslip study damping`: what impacts lose, and what decides it; calibration of the damping."""

from __future__ import annotations

import argparse
from contextlib import closing
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from solver.arguments import add_overrides, add_scene, add_study_options, check_processes
from solver.errors import NotConverged, SceneError
from solver.run.streams import say

if TYPE_CHECKING:
    from collections.abc import Sequence

    from solver.study.damping.case import BaseScene, DampingCase
    from solver.study.damping.sweep import Sweep

TEXT = "restitution of impacts over step, mesh, damping and others; damping for a restitution"

IMPACTS = 4
"""Impacts that count where the command line says nothing."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the study."""
    add = parser.add_argument
    add_scene(parser)
    add_overrides(parser, example="time.end=1.5")
    add(
        "--of", metavar="NAME[=V1,V2,...]", nargs="+", action="extend", default=[],
        help="what is varied, such as beta=0,1e-5,1e-4: step, tolerance, mesh, gamma, rho_inf, "
        "damped_steps, beta, contact, young, floor; default all",
    )  # fmt: skip
    add(
        "--at", metavar="NAME=V1,V2,...", nargs="+", action="extend", default=[],
        help="repeat all of it with each of these values, such as mesh=1,2",
    )  # fmt: skip
    add(
        "--target", metavar="WHAT",
        help="find the damping instead: restitution=0.936, or history=FILE (time, angle)",
    )  # fmt: skip
    add("--impacts", type=int, default=IMPACTS, metavar="N", help=f"that count, default {IMPACTS}")
    add("--block", metavar="NAME", help="whose impacts count; default the first with a mesh")
    add("--histories", action="store_true", help="run to the scene's end and draw the angles, too")
    add_study_options(parser, "study", ".damping")


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """Plan of a study.

    Attributes:
        base: What is varied.
        folder: Where the study goes.
        impacts: Number of impacts that count.
        sweep: What is swept.
        rows: Rows of the cases that have been done before, by key.
    """

    base: BaseScene
    folder: Path
    impacts: int
    sweep: Sweep
    rows: dict[str, dict[str, Any]]


def run(options: argparse.Namespace) -> int:
    """The study; 0 where all runs completed, 3 where one failed."""
    from mpi4py import MPI

    from solver.parallel import abort_on_exceptions, on_first_rank

    comm = MPI.COMM_WORLD
    abort_on_exceptions(comm)
    if options.target is not None:
        from solver.study.damping.calibration import calibrate

        return calibrate(options, comm)
    plan: Plan = on_first_rank(comm, lambda: prepare(options))
    rows = dict(plan.rows)
    try:
        run_cases(plan.sweep.cases, rows, plan.folder, options)
    finally:
        if comm.rank == 0:
            _write(plan, rows, options)
    failed = any(rows.get(case.key, {}).get("status") != "completed" for case in plan.sweep.cases)
    if comm.rank == 0 and not options.quiet:
        _tell(plan, rows)
    return NotConverged.exit_code if comm.bcast(failed) else 0


def prepare(options: argparse.Namespace) -> Plan:
    """Look at everything that can be refused before anything is run, and claim the folder."""
    from solver.study.damping.sweep import sweep
    from solver.study.folder import finished

    base = base_scene(options)
    swept = sweep(base, options.of, options.at)
    folder = claimed(options, base)
    return Plan(
        base=base, folder=folder, impacts=options.impacts, sweep=swept, rows=finished(folder)
    )


def base_scene(options: argparse.Namespace) -> BaseScene:
    """The scene of the command line, and the block whose impacts count."""
    from solver.scene import parse_scene, read_text, set_values
    from solver.scene.reader import read_toml
    from solver.study.damping.case import BaseScene, time_for, watched

    if options.impacts < 1:
        raise SceneError("--impacts", f"{options.impacts}", "a whole number > 0")
    check_processes(options.processes)
    path: Path = options.scene
    tables = read_toml(read_text(path), path.name)
    set_values(tables, options.overrides)
    scene = parse_scene(tables, folder=path.parent, source=path.name)
    block = watched(scene, options.block)
    if scene.motion is not None:  # with names of files that hold in every folder
        tables["motion"] = scene.to_dict()["motion"]
    whole = options.histories
    end = scene.time.end if whole else time_for(scene, block, options.impacts)
    return BaseScene(tables=deepcopy(tables), scene=scene, block=block, end=end)


def claimed(options: argparse.Namespace, base: BaseScene) -> Path:
    """The folder of the study, made or refused."""
    from solver import VERSION
    from solver.study.damping.folder import FOLDER

    folder: Path = options.output or Path(options.scene.stem + ".damping")
    if folder.exists() and options.scene.resolve().parent == folder.resolve():
        raise SceneError("-o", f"{folder}, which holds the scene itself", "another folder")
    settings = {
        "version": VERSION,
        "scene": base.scene.to_dict(),
        "block": base.block.name,
    }
    FOLDER.claim(folder, settings, force=options.force, resume=options.resume)
    return folder


def run_cases(
    cases: Sequence[DampingCase],
    rows: dict[str, dict[str, Any]],
    folder: Path,
    options: argparse.Namespace,
) -> None:
    """Run the cases that have no row yet, and add their rows; collective on all ranks.

    Args:
        cases: What is wanted; the same on all ranks.
        rows: Rows that there are, by the keys of their cases; added to on rank 0.
        folder: Where rows are kept.
        options: Of the command.
    """
    from mpi4py import MPI

    from solver.study.cases import finished_cases, reason_of
    from solver.study.damping.case import run_case
    from solver.study.damping.folder import keep

    waiting = MPI.COMM_WORLD.bcast([case for case in cases if case.key not in rows])
    outcomes = finished_cases(
        run_case,
        waiting,
        done=len(cases) - len(waiting),
        processes=options.processes,
        quiet=options.quiet,
    )
    with closing(outcomes):
        for case, outcome in outcomes:
            if isinstance(outcome, Exception):
                outcome = {"status": "failed", "reason": reason_of(outcome)}
            if outcome["status"] != "interrupted":
                rows[case.key] = keep(folder, case.key, outcome)


def _write(plan: Plan, rows: dict[str, dict[str, Any]], options: argparse.Namespace) -> None:
    """Write the tables and pictures of what has been done."""
    from solver.study.damping import table
    from solver.study.damping.findings import as_json, lines, restitution_of
    from solver.study.tables import early_ends, write

    if not any(case.key in rows for case in plan.sweep.cases):
        return
    found = lines(plan.sweep, rows, plan.impacts)
    own = restitution_of(rows.get(plan.sweep.base), plan.impacts)
    whole = list(table.rows_of_table(plan.sweep, rows, plan.impacts))
    cells = table.words(whole, plan.sweep, plan.impacts)
    told = list(table.remarks(whole, plan.sweep, found))
    title = plan.base.scene.title or "Restitution of impacts"
    write(plan.folder / "damping.csv", table.csv_text(whole))
    write(plan.folder / "damping.md", table.markdown(title, cells, told, early_ends(whole)))
    summary = {
        "block": plan.base.block.name,
        "impacts": plan.impacts,
        "scene": None if own is None else table.measures(own),
        "lines": [as_json(line) for line in found],
    }
    write(plan.folder / "summary.json", summary)
    _draw(plan, rows, options)


def _draw(plan: Plan, rows: dict[str, dict[str, Any]], options: argparse.Namespace) -> None:
    """Draw the pictures."""
    from solver.study.damping.findings import lines, restitution_of
    from solver.study.damping.folder import kept_angle
    from solver.study.damping.picture import history_picture, restitution_picture

    found = [line for line in lines(plan.sweep, rows, plan.impacts) if line.values]
    own = restitution_of(rows.get(plan.sweep.base), plan.impacts)
    if found:
        restitution_picture(found, own, plan.sweep.at, plan.folder / "damping.png")
    if not options.histories:
        return
    for line in found:
        curves = {
            f"{line.axis.key} {swept.value:g} {line.axis.unit}".strip(): kept_angle(
                plan.folder, swept.case
            )
            for swept in plan.sweep.values
            if (swept.axis, swept.at) == (line.axis, line.at) and swept.value in line.values
        }
        at = "" if line.at is None else f"_{line.at:g}"
        history_picture(curves, plan.folder / f"histories_{line.axis.name}{at}.png")


def _tell(plan: Plan, rows: dict[str, dict[str, Any]]) -> None:
    """Print the table, what it shows, and where it is."""
    from solver.study.damping import table
    from solver.study.damping.findings import lines
    from solver.study.tables import early_ends

    whole = list(table.rows_of_table(plan.sweep, rows, plan.impacts))
    cells = table.words(whole, plan.sweep, plan.impacts)
    found = lines(plan.sweep, rows, plan.impacts)
    told = list(table.remarks(whole, plan.sweep, found))
    say(table.plain_text(cells, told, early_ends(whole)))
    say(f"written to {plan.folder}\n")
