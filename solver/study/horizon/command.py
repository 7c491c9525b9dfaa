"""`rockslip study horizon`: up to when a history means something."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from solver.arguments import add_overrides, add_scene, add_study_options, check_processes
from solver.errors import SceneError

if TYPE_CHECKING:
    from solver.study.horizon.case import HorizonCase

TEXT = "up to when a history means something: runs of which amplitudes differ by a millionth"

PERTURBATIONS = "1e-6"
"""Differences where the command line says nothing."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the study."""
    add = parser.add_argument
    add_scene(parser)
    add_overrides(parser, example="time.end=20")
    add("--differences", default=PERTURBATIONS, metavar="D,...",
        help=f"of amplitudes between a run and its twins, default {PERTURBATIONS}")  # fmt: skip
    add("--scales", default="1", metavar="F,...", help="factors on the motion, default 1")
    add("--engines", metavar="NAMES", help="of rigid, elastic; default the scene as it is")
    add_study_options(parser, "study", ".horizon")


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """Plan of a study.

    Attributes:
        folder: Where the study goes.
        cases: All of them.
        rows: Rows of the cases that have been done before, by name.
    """

    folder: Path
    cases: tuple[HorizonCase, ...]
    rows: dict[str, dict[str, Any]]


def run(options: argparse.Namespace) -> int:
    """The study; 0 where all cases completed, 3 where one failed."""
    from solver.study.cases import kept_rows, run_study
    from solver.study.horizon.case import run_case

    return run_study(
        options,
        prepare,
        lambda plan, rows: kept_rows(run_case, plan.cases, rows, plan.folder, options),
        lambda plan, rows: _write(plan, rows, quiet=options.quiet),
    )


def prepare(options: argparse.Namespace) -> Plan:
    """Look at everything that can be refused before anything is run, and claim the folder."""
    from solver import VERSION
    from solver.run.twin import refuse_without_twin
    from solver.scene import read_text, set_values
    from solver.scene.reader import read_toml
    from solver.study.folder import finished
    from solver.study.horizon.case import HorizonCase
    from solver.study.horizon.folder import FOLDER
    from solver.study.standing import numbers, words
    from solver.study.suite.engines import ELASTIC, RIGID

    check_processes(options.processes)
    differences = numbers("--differences", options.differences)
    if not all(1e-12 <= value <= 0.1 for value in differences):
        raise SceneError("--differences", options.differences, "1e-12 <= D <= 0.1")
    engines: list[str | None] = [None]
    if options.engines:
        engines = list(words("--engines", options.engines, (RIGID, ELASTIC)))
    path: Path = options.scene
    tables = read_toml(read_text(path), path.name)
    set_values(tables, options.overrides)
    scales = numbers("--scales", options.scales)
    if "motion" not in tables and set(scales) != {1.0}:
        raise SceneError("--scales", options.scales, "1 for a scene without [motion]")
    cases = tuple(
        HorizonCase(
            engine=engine,
            scale=scale,
            perturbations=tuple(sorted(differences)),
            tables=tables,
            folder=path.parent,
        )
        for engine in engines
        for scale in scales
    )
    scenes = {}
    for case in cases:
        scene = case.scene()
        refuse_without_twin(scene, "study horizon")
        scenes[case.name] = scene.to_dict()
    folder = options.output or Path(path.stem + ".horizon")
    settings = {"version": VERSION, "scenes": scenes, "differences": differences}
    FOLDER.claim(folder, settings, force=options.force, resume=options.resume)
    return Plan(folder=folder, cases=cases, rows=finished(folder))


def _write(plan: Plan, rows: Mapping[str, dict[str, Any]], *, quiet: bool) -> bool:
    """Write tables and picture of what has been done, and tell; whether all of it was done."""
    from solver.study.cases import tell
    from solver.study.horizon import table
    from solver.study.horizon.folder import PICTURE, SUMMARY, TABLE
    from solver.study.horizon.folder import TEXT as TEXT_FILE
    from solver.study.tables import as_csv, write

    ordered = [rows[case.name] for case in plan.cases if case.name in rows]
    done, text = [row for row in ordered if row["status"] == "completed"], ""
    if done:
        from solver.study.horizon.picture import horizon_picture

        text = table.as_text(done)
        write(plan.folder / TABLE, as_csv(table.twin_rows(done), table.NAMES))
        write(plan.folder / TEXT_FILE, text)
        rates = [{"growth_1_s": table.growth(row), "scale": row["scale"], "engine": row["engine"]}
                 for row in done]  # fmt: skip
        write(plan.folder / SUMMARY, {"twins": table.twin_rows(done), "runs": rates})
        horizon_picture(done, plan.folder / PICTURE)
    if not quiet:
        tell(text, ordered, plan.folder)
    return len(done) == len(plan.cases)
