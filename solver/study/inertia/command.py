"""`rockslip study inertia`: the portion of the live load that counts as inertia."""

from __future__ import annotations

import argparse
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from solver.arguments import add_overrides, add_scene, add_study_options, check_processes
from solver.errors import NotConverged, SceneError
from solver.run.streams import say

if TYPE_CHECKING:
    from collections.abc import Sequence

    from solver.scene import Scene
    from solver.study.inertia.cells import Grid, Structure
    from solver.study.inertia.findings import Finding, Line
    from solver.study.inertia.folder import Runs
    from solver.study.inertia.runs import BlockTask, Task
    from solver.study.suite.motions import SuiteMotion

TEXT = "the portion of the live load that counts as inertia, with its interval, over maps"

COUNT = 300
"""Synthetic motions where the command line says nothing."""

FIRST = 30
"""Motions of the first round where as many are taken as an interval needs."""

MOST_CELLS = 12
"""Cells for which finite elements are offered."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the study."""
    add = parser.add_argument
    add_scene(parser, text="a TOML file; its motion and end are replaced")
    add_overrides(parser, example="foundation.mass_ratio=1")
    add(
        "--of", metavar="NAME=V1,V2,...", nargs="+", action="extend", default=[],
        help="axes of the map: period, friction or friction_over_pga, mass_ratio, damping_ratio, "
        "aspect; default 6 periods x 8 friction coefficients",
    )  # fmt: skip
    add(
        "--by", nargs="+", choices=("rigid", "elements"), action="extend", default=[],
        help="besides the closed form of the sliding block: rigid blocks, finite elements",
    )  # fmt: skip
    add(
        *("--motions", "--motion"), metavar="MOTION", nargs="+", action="extend", default=[],
        help="files, folders of files, @FILE with a name a line, or synthetic (the default)",
    )  # fmt: skip
    add("--count", type=int, metavar="N", help=f"number of synthetic motions, default {COUNT}")
    add("--seed", type=int, metavar="S", help="of the synthetic motions")
    add(
        "--within", type=float, metavar="W",
        help="stop at fewer motions once all intervals of 90 %% are within +-W, such as 0.05",
    )  # fmt: skip
    add_study_options(parser, "study", ".inertia")


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """Plan of a study.

    Attributes:
        folder: Where the study goes.
        scene: Of the command line, as plain tables that name no motion.
        source: Folder from which names in the scene start.
        grid: The cells.
        ladders: Friction from infinity down, for each structure.
        motions: All motions that may be used.
        notes: How they are made up, and what is left out.
        by: Ways to compute besides the closed form.
        title: Of the scene.
        text: The scene as TOML.
        runs: Numbers of the runs that there are, by key; added to on rank 0.
    """

    folder: Path
    scene: dict[str, Any]
    source: Path
    grid: Grid
    ladders: dict[Structure, list[float]]
    motions: tuple[SuiteMotion, ...]
    notes: tuple[str, ...]
    by: tuple[str, ...]
    title: str
    text: str
    runs: Runs


def run(options: argparse.Namespace) -> int:
    """The study; 0 where all runs completed, 3 where one failed."""
    from mpi4py import MPI

    from solver.parallel import abort_on_exceptions, on_first_rank

    comm = MPI.COMM_WORLD
    abort_on_exceptions(comm)
    plan: Plan = on_first_rank(comm, lambda: prepare(options))
    failed: dict[str, str] = {}
    for count in _rounds(options, len(plan.motions)):
        for closed in (True, False):
            waiting = comm.bcast(_missing(plan, count, closed=closed) if comm.rank == 0 else None)
            _run_tasks(waiting, plan, failed, options)
        if on_first_rank(comm, partial(_write, plan, count, failed, options)):
            break
    if comm.rank == 0 and not options.quiet:
        say((plan.folder / "inertia.md").read_text(encoding="utf-8"))
        say("".join(f"failed: {name}: {reason}\n" for name, reason in failed.items()))
        say(f"written to {plan.folder}\n")
    return NotConverged.exit_code if comm.bcast(bool(failed)) else 0


def prepare(options: argparse.Namespace) -> Plan:
    """Look at everything that can be refused before anything is run, and claim the folder."""
    from solver import VERSION
    from solver.scene import parse_scene, read_text, scene_to_toml, set_values
    from solver.scene.reader import read_toml
    from solver.study.inertia.folder import FOLDER, known_runs
    from solver.study.inertia.runs import ladder
    from solver.study.standing import refuse_components
    from solver.study.suite.motions import find_motions

    _check_numbers(options)
    path: Path = options.scene
    tables = read_toml(read_text(path), path.name)
    set_values(tables, options.overrides)
    synthetic = not options.motions or "synthetic" in options.motions
    count = COUNT if options.count is None and synthetic else options.count
    motion = tables.pop("motion", None)
    refuse_components(motion if isinstance(motion, dict) else ())
    motions, notes = find_motions(options.motions, motion, count=count, seed=options.seed)
    scene = parse_scene(tables, folder=path.parent, source=path.name)
    by = tuple(sorted(set(options.by), reverse=True))
    grid = _grid(options, scene, tables, by)
    frictions: dict[Structure, set[float]] = {}
    for cell in grid.cells:
        frictions.setdefault(cell.structure, set()).add(cell.friction)
    folder: Path = options.output or Path(path.stem + ".inertia")
    if folder.exists() and path.resolve().parent == folder.resolve():
        raise SceneError("-o", f"{folder}, which holds the scene itself", "another folder")
    # Runs are known by what they compute, so that a study may go on with other axes and motions.
    settings = {"version": VERSION, "scene": scene.to_dict()}
    FOLDER.claim(folder, settings, force=options.force, resume=options.resume)
    return Plan(
        folder=folder,
        scene=tables,
        source=path.parent,
        grid=grid,
        ladders={structure: ladder(several) for structure, several in frictions.items()},
        motions=tuple(motions),
        notes=tuple(notes),
        by=by,
        title=scene.title or path.stem,
        text=scene_to_toml(scene),
        runs=known_runs(folder),
    )


def _grid(
    options: argparse.Namespace, scene: Scene, tables: dict[str, Any], by: Sequence[str]
) -> Grid:
    """The cells that the command line asks for; those that no way can compute are refused."""
    from solver.scene import parse_scene
    from solver.study.inertia.cells import cells_of, chosen, tables_of

    axes = chosen(options.of)
    grid = cells_of(scene, axes)
    if "aspect" in axes and not by:
        raise SceneError("--of", "aspect", "it with --by rigid or elements: sliding has no height")
    if "elements" in by and len(grid.cells) > MOST_CELLS:
        raise SceneError("--by", f"elements, {len(grid.cells)} cells", f"at most {MOST_CELLS}")
    for cell in grid.cells:
        for how in by or ("rigid",):
            parse_scene(tables_of(tables, cell, "rigid" if how == "rigid" else "elastic"))
    return grid


def _check_numbers(options: argparse.Namespace) -> None:
    """Refuse numbers out of range."""
    if options.within is not None and not 0 < options.within < 1:
        raise SceneError("--within", f"{options.within:g}", "0 < W < 1")
    check_processes(options.processes)


def command_of(options: argparse.Namespace) -> str:
    """The command that repeats a study, without what only says how and where it is run."""
    import shlex

    words = ["rockslip", "study", "inertia", options.scene.name]
    lists = {"--set": options.overrides, "--of": options.of, "--by": options.by}
    lists["--motions"] = options.motions
    for name, several in lists.items():
        words += [name, *several] if several else []
    for name in ("count", "seed", "within"):
        value = getattr(options, name)
        words += [f"--{name}", f"{value:g}"] if value is not None else []
    return shlex.join(words)


def _rounds(options: argparse.Namespace, most: int) -> list[int]:
    """Numbers of motions after which intervals are looked at: doubled where they decide."""
    if options.within is None:
        return [most]
    counts, count = [], FIRST
    while count < most:
        counts.append(count)
        count *= 2
    return [*counts, most]


def _missing(plan: Plan, count: int, *, closed: bool) -> list[Task]:
    """Tasks whose numbers are not known yet, for so many motions."""
    from solver.study.inertia.runs import closed_tasks

    if closed:
        return list(
            closed_tasks(plan.ladders, plan.motions[:count], plan.scene, plan.source, plan.runs)
        )
    tasks = {task.key: task for _, _, task in _block_tasks(plan, count)}
    return [task for key, task in tasks.items() if key not in plan.runs]


def _block_tasks(plan: Plan, count: int) -> list[tuple[int, str, BlockTask]]:
    """Number of the cell, way to compute, and run, for all motions and cells."""
    from solver.study.inertia.runs import block_tasks

    motions = plan.motions[:count]
    return [
        (number, how, task)
        for how in plan.by
        for number, cell in enumerate(plan.grid.cells)
        for task in block_tasks(cell, motions, plan.scene, plan.source, how)
    ]


def _run_tasks(
    tasks: Sequence[Task], plan: Plan, failed: dict[str, str], options: argparse.Namespace
) -> None:
    """Run tasks and keep their numbers; collective on all ranks."""
    from solver.study.cases import finished_cases, reason_of
    from solver.study.inertia.folder import keep
    from solver.study.inertia.runs import run_task

    outcomes = finished_cases(run_task, tasks, processes=options.processes, quiet=options.quiet)
    with closing(outcomes):
        for task, outcome in outcomes:
            if isinstance(outcome, Exception):
                failed[task.name] = reason_of(outcome)
            else:
                plan.runs.update(keep(plan.folder, outcome))


def _write(plan: Plan, count: int, failed: dict[str, str], options: argparse.Namespace) -> bool:
    """Write what is known with so many motions; returns whether intervals are narrow enough."""
    from solver.study.inertia.findings import widest
    from solver.study.inertia.report import write_all

    lines = _lines(plan, count)
    if len(lines) < len(plan.ladders):
        raise NotConverged(f"runs by the closed form failed: {next(iter(failed.values()))}")
    findings = _findings(plan, lines, count)
    enough = options.within is not None and widest(findings) <= options.within
    if enough or count == len(plan.motions):
        write_all(
            plan.folder,
            list(lines.values()),
            findings,
            failed,
            plan.notes,
            title=f"Portion of the live load that counts as inertia: {plan.title}",
            scene=plan.text,
            command=command_of(options),
        )
    return enough


def _lines(plan: Plan, count: int) -> dict[Structure, Line]:
    """All structures whose runs are known."""
    from solver.study.inertia.findings import Line
    from solver.study.inertia.runs import content_of

    contents, lines = [content_of(motion) for motion in plan.motions[:count]], {}
    for structure, frictions in plan.ladders.items():
        try:
            lines[structure] = Line.of(structure, frictions, contents, plan.runs)
        except KeyError:
            continue
    return lines


def _findings(plan: Plan, lines: dict[Structure, Line], count: int) -> list[Finding]:
    """All cells by the closed form, then by the engines."""
    from solver.study.inertia.runs import ENGINES

    cells = plan.grid.cells
    found = [lines[cell.structure].finding(cell) for cell in cells]
    outcomes: dict[tuple[int, str], list[list[float] | None]] = {}
    for number, how, task in _block_tasks(plan, count):
        outcomes.setdefault((number, how), []).append(plan.runs.get(task.key))
    for (number, how), several in outcomes.items():
        if any(outcome is not None for outcome in several):
            cell = cells[number]
            found.append(lines[cell.structure].finding_by(cell, ENGINES[how], several))
    return found
