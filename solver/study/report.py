"""The command `rockslip report DIR`: one HTML page about a run or a study."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from solver.errors import SceneError, not_installed
from solver.parallel import launched_rank
from solver.run.folders import REPORT, refuse_unwritable
from solver.run.streams import say

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
    from solver.study.page import is_study, study_page

    folder: Path = options.folder
    file: Path = options.output or folder / REPORT
    if file.suffix.lower() not in PAGES:
        raise SceneError("-o", f"{file}", f"a file that ends in {' or '.join(PAGES)}")
    if options.output or folder.is_dir():
        refuse_unwritable(file.parent)
    if is_study(folder):
        page = study_page(folder)
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
        from solver.pictures.page.run_page import run_page

        if filmed:
            import pyvista  # noqa: F401  (imported when it draws, and missed before that)
            from PIL import Image  # noqa: F401
    except ImportError as error:
        raise not_installed(error) from error
    return run_page(run, drawn, filmed=filmed)
