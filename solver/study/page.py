"""The command `rockslip report DIR`: one HTML page about a run or a study.

That of a study, whatever its kind, has what it says, its pictures, its scene and its command.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from solver.errors import SceneError, not_installed
from solver.parallel import launched_rank
from solver.pictures.html import (
    cautions,
    document,
    figure,
    heading,
    paragraphs,
    table,
    verbatim,
)
from solver.run.folders import REPORT, refuse_unwritable
from solver.run.streams import say

KINDS = (
    "suite",
    "damping",
    "calibration",
    "inertia",
    "modes",
    "overturning",
    "horizon",
    "errors",
    "stability",
)
"""Names of the tables of studies, of which a folder has one."""

MOST_ROWS = 400
"""Rows of a table that stand on the page."""

PAGES = (".html", ".htm")
"""Endings of a page."""

AddCommand = Callable[[str, Callable[[argparse.Namespace], int], str], Any]
"""Adds a command by its name, what it does, and its help; returns its parser."""


def add_report(command: AddCommand) -> None:
    """Add the command."""
    parser = command("report", report, "one HTML page about a run or a study, with its pictures")
    parser.add_argument("folder", metavar="DIR", type=Path, help="folder of a run or of a study")
    where = f"default {REPORT} in the folder"
    parser.add_argument("-o", "--output", metavar="FILE", type=Path, help=where)
    parser.add_argument("--no-film", action="store_true", help="without a film of a run")


def report(options: argparse.Namespace) -> int:
    """`rockslip report`."""
    if launched_rank() != 0:
        return 0
    from solver.results.summary import write_whole

    folder: Path = options.folder
    file: Path = options.output or folder / REPORT
    if file.suffix.lower() not in PAGES:
        raise SceneError("-o", f"{file}", f"a file that ends in {' or '.join(PAGES)}")
    if options.output or folder.is_dir():
        refuse_unwritable(file.parent)
    kind = next((kind for kind in KINDS if (folder / f"{kind}.csv").is_file()), None)
    if kind is not None:
        page = study_page(folder, kind)
    else:
        with TemporaryDirectory() as beside:
            drawn = folder if os.access(folder, os.W_OK) else Path(beside)
            page = _page_of_run(folder, drawn, filmed=not options.no_film)
    write_whole(file, page)
    say(f"{file}\n")
    return 0


def _page_of_run(folder: Path, drawn: Path, *, filmed: bool) -> str:
    """The page of a run, with its pictures and the film, which are drawn into a folder."""
    from solver.pictures.command import read_runs

    (run,) = read_runs([folder])
    try:
        from solver.pictures.page import run_page

        if filmed:
            import pyvista  # noqa: F401  (imported when it draws, and missed before that)
            from PIL import Image  # noqa: F401
    except ImportError as error:
        raise not_installed(error) from error
    return run_page(run, drawn, filmed=filmed)


def study_page(folder: Path, kind: str) -> str:
    """The page of the study in a folder, by the name of its table."""
    from solver.study.study import SETTINGS, read_mapping

    settings = read_mapping(folder / SETTINGS)
    rows = _rows(folder / f"{kind}.csv")
    parts = cautions(_failures(rows))
    for ending in ("txt", "md"):
        file = folder / f"{kind}.{ending}"
        if file.is_file():
            parts += [heading("Summary"), verbatim(file.read_text(encoding="utf-8"))]
            break
    pictures = sorted(folder.glob("*.png"))
    if pictures:
        parts += [heading("Pictures"), *(figure(_caption(file), file) for file in pictures)]
    parts += [heading("Numbers"), *_numbers(rows, f"{kind}.csv")]
    scene = settings.get("scene")
    if isinstance(scene, dict):
        parts += [heading("Scene"), verbatim(_toml(scene))]
    study = {"calibration": "damping", "errors": "error-runtime"}.get(kind, kind)
    command = settings.get("command", f"rockslip study {study} scene.toml")
    parts += [heading("How to repeat"), verbatim(command)]
    title = scene.get("title", "") if isinstance(scene, dict) else ""
    return document(f"{kind.capitalize()}: {title or folder.resolve().name}", parts)


def _rows(file: Path) -> list[list[str]]:
    """The table, its heading first."""
    with file.open(encoding="utf-8", newline="") as stream:
        return [row for row in csv.reader(stream) if row]


def _failures(rows: list[list[str]]) -> list[str]:
    """Cases that did not complete, with their reasons."""
    cases = [dict(zip(rows[0], row, strict=False)) for row in rows[1:]]
    failed = [case for case in cases if case.get("status") not in ("completed", "", None)]
    return [
        f"{case[rows[0][0]]}: {case['status']}{f' ({why})' if (why := case.get('reason')) else ''}"
        for case in failed
    ]


def _numbers(rows: list[list[str]], name: str) -> list[str]:
    """The table with four digits, as long as it is readable."""
    shown = [rows[0], *([_short(word) for word in row] for row in rows[1 : MOST_ROWS + 1])]
    parts = [table(shown)]
    if len(rows) > MOST_ROWS + 1:
        parts += paragraphs([f"{len(rows) - 1 - MOST_ROWS} more rows stand in {name}."])
    return parts


def _short(word: str) -> str:
    """A number with four digits; a word as it is."""
    try:
        return word if word.lstrip("-").isdigit() else f"{float(word):.4g}"
    except ValueError:
        return word


def _caption(file: Path) -> str:
    """The name of a picture, as words."""
    return file.stem.replace("_", " ").capitalize()


def _toml(scene: Mapping[str, Any]) -> str:
    """The scene as it would stand in a file."""
    from solver.scene import parse_scene, scene_to_toml

    try:
        return scene_to_toml(parse_scene(dict(scene)))
    except SceneError:
        return json.dumps(scene, indent=2)
