"""`rockslip study modes`: rest, slide, rock or both, on a grid of friction and acceleration."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from solver.errors import SceneError
from solver.study.cases import check_processes

if TYPE_CHECKING:
    from solver.study.modes.case import ModesCase


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """Plan of a study.

    Attributes:
        folder: Where the study goes.
        cases: All of them.
        rows: Rows of the cases that have been done before, by name.
        gravity: g, m/s^2.
    """

    folder: Path
    cases: tuple[ModesCase, ...]
    rows: dict[str, dict[str, Any]]
    gravity: float


def run(options: argparse.Namespace) -> int:
    """The study; 0 where all points that are judged agree, 3 where a case fails or one does not."""
    from solver.study.cases import kept_rows, run_study
    from solver.study.modes.case import run_case

    return run_study(
        options,
        prepare,
        lambda plan, rows: kept_rows(run_case, plan.cases, rows, plan.folder, options),
        lambda plan, rows: _write(plan, rows, quiet=options.quiet),
    )


def prepare(options: argparse.Namespace) -> Plan:
    """Look at everything that can be refused before anything is run, and claim the folder."""
    from solver import VERSION
    from solver.study.folder import finished
    from solver.study.modes.case import ENGINES, cases_of
    from solver.study.modes.folder import FOLDER
    from solver.study.standing import numbers, standing_block, variant, words

    check_processes(options.processes)
    if not 2 <= options.points <= 200:
        raise SceneError("--points", f"{options.points}", "2 <= points <= 200")
    engines = words("--engines", options.engines, ENGINES) if options.engines else []
    ratios = numbers("--ratios", options.ratios) if options.ratios else []
    tables = standing_block(options.scene, options.overrides)
    cases = tuple(cases_of(tables, ratios, options.points, engines))
    scene = variant(tables)
    folder: Path = options.output or Path(options.scene.stem + ".modes")
    settings = {
        "version": VERSION,
        "scene": scene.to_dict(),
        "points": options.points,
    }
    FOLDER.claim(folder, settings, force=options.force, resume=options.resume)
    return Plan(
        folder=folder,
        cases=cases,
        rows=finished(folder),
        gravity=scene.gravity,
    )


def _write(plan: Plan, rows: Mapping[str, dict[str, Any]], *, quiet: bool) -> bool:
    """Write tables and picture of what has been done, and tell; whether all of it is right."""
    from solver.study.cases import tell
    from solver.study.modes import table
    from solver.study.modes.folder import PICTURE, SUMMARY, TABLE
    from solver.study.modes.folder import TEXT as TEXT_FILE
    from solver.study.modes.picture import modes_picture
    from solver.study.tables import as_csv, write

    ordered = [rows[case.name] for case in plan.cases if case.name in rows]
    points = table.points_of(ordered, plan.gravity)
    text = ""
    if points:
        maps = table.maps_of(points)
        text = table.as_text(maps)
        write(plan.folder / TABLE, as_csv(points, table.NAMES))
        write(plan.folder / TEXT_FILE, text)
        write(plan.folder / SUMMARY, {"band": table.BAND, "maps": maps})
        modes_picture(points, plan.folder / PICTURE)
    if not quiet:
        tell(text, ordered, plan.folder)
    agree = all(point["agrees"] for point in points if point["judged"])
    return agree and sum(row["status"] == "completed" for row in ordered) == len(plan.cases)
