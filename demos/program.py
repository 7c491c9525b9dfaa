"""Common parts of the demos: output folder, run of a scene, exit code."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from mpi4py import MPI

from demos.verdict import Results, verdict
from rockslip import Scene, read_run, simulate
from solver.cli import INTERRUPTED
from solver.errors import RockslipError
from solver.parallel import abort_on_exceptions, on_first_rank
from solver.results.endings import cut_short
from solver.results.runs import Run
from solver.run.folders import claim_folder
from solver.run.progress import Progress
from solver.study.tables import early_ends

Made = TypeVar("Made")

Text = Callable[[list[Run]], str]
"""A table of some runs."""

Picture = Callable[[list[Run], Path], Path]
"""Draws runs into a folder, and returns the file."""

Checks = Callable[[list[Run]], Results]
"""Checks of some runs: true if one holds, and its text."""

CHANGES = "other values of the scene, such as time.end=0.5; the checks are meant for its own"


def output_of(demo: str) -> Path:
    """Default folder of a demo's output: in the current one, which is the user's."""
    return Path("output") / demo


def parser_of(description: str, output: Path, *, changes: bool = True) -> argparse.ArgumentParser:
    """A command line with `--output DIR`, and `--set KEY=VALUE ...` for demos of a scene."""
    parser = argparse.ArgumentParser(description=description)
    text = f"folder of the results; default {output}, in the current folder"
    parser.add_argument("-o", "--output", type=Path, default=output, metavar="DIR", help=text)
    if changes:
        parser.add_argument("--set", nargs="+", default=[], metavar="KEY=VALUE", help=CHANGES)
    return parser


def run_scene(
    scene: Scene, folder: Path, source: Path, comm: MPI.Intracomm = MPI.COMM_WORLD
) -> Path:
    """Run a scene into a folder, which is made anew as with `rockslip run --force`; returns it.

    `source` is the scene's file, whose own folder is refused. A run that is interrupted ends the
    demo.
    """
    on_first_rank(comm, lambda: claim_folder(folder, source, force=True))
    progress = Progress(scene.time.end, rank=comm.rank)
    result = simulate(scene, folder=folder, progress=progress, comm=comm)
    if result.status == "interrupted":
        raise SystemExit(INTERRUPTED)
    return folder


def conclude(
    program: str,
    work: Callable[[], Made],
    show: Callable[[Made], int],
    comm: MPI.Intracomm = MPI.COMM_WORLD,
) -> int:
    """Work on all ranks, show and judge on the first; returns the exit code, on every rank.

    What goes wrong is said in one line; an error of the program itself ends all ranks.
    """
    abort_on_exceptions(comm)
    code = 0
    try:
        made = work()
        if comm.rank == 0:
            code = show(made)
    except RockslipError as error:
        if comm.rank == 0:
            print(f"{program}: {error}", file=sys.stderr)
        code = error.exit_code
    return int(comm.bcast(code))


def judged(
    program: str, folders: list[Path], picture: Picture, checks: Checks, table: Text | None = None
) -> int:
    """Print the table, if there is one, draw and check the runs in some folders; the exit code.

    The table begins with those of its runs that end before their motion does.
    The picture goes into the folder that holds those of the runs.
    """
    runs = [read_run(folder) for folder in folders]
    told = early_ends({"cut_short": cut_short(run.summary)} for run in runs)
    told += [] if table is None else [table(runs)]
    print("\n" + "\n\n".join([*told, str(picture(runs, folders[0].parent))]) + "\n")
    return verdict(program, checks(runs))


def demo(
    program: str,
    description: str,
    output: Path,
    work: Callable[..., Made],
    show: Callable[[Made], int],
    arguments: list[str] | None,
) -> int:
    """A demo of a scene, from its command line to its exit code, the same on every rank.

    Args:
        program: Its name in what it says of itself.
        description: Of `--help`.
        output: Default folder of its output.
        work: Runs the scenes into a folder, with other values of the scene (`--set`); collective.
        show: Shows and judges what that has made, on the first rank.
        arguments: Options; None: those of the command line.
    """
    options = parser_of(description, output).parse_args(arguments)
    return conclude(program, lambda: work(options.output, *options.set), show)
