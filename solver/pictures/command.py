"""The commands that show runs: `plot` and `animate`.

Heavy imports stand inside the commands that need them.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from solver.errors import not_installed
from solver.parallel import launched_rank
from solver.run.folders import open_folder, refuse_unwritable
from solver.run.streams import say, tell

if TYPE_CHECKING:
    from solver.results.runs import Run

AddCommand = Callable[[str, Callable[[argparse.Namespace], int], str], Any]
"""Adds a command by its name, what it does, and its help; returns its parser."""


def add_pictures(command: AddCommand) -> None:
    """Add the commands."""
    plot = command("plot", plot_runs, "pictures of one run, or of several runs overlaid")
    _add_runs(plot)
    plot.add_argument(
        "-o", "--output", metavar="DIR", type=Path, help="folder of the pictures; default the first"
    )
    plot.add_argument(
        "--format",
        dest="formats",
        nargs="+",
        choices=("png", "pdf", "svg"),
        default=["png"],
        help="of the pictures, one or several; default png",
    )
    film = command("animate", film_runs, "a film of one run, or of several runs side by side")
    _add_runs(film)
    add = film.add_argument
    text = "a name that ends with .mp4 or .gif; default film.mp4 in the first folder, film.gif "
    add("-o", "--output", metavar="FILE", type=Path, help=f"{text}where ffmpeg is not installed")
    add(
        "--frame",
        choices=("moving", "fixed"),
        default="moving",
        help="that of the ground, or one at rest in which the ground moves; default moving",
    )
    add(
        "--slow",
        metavar="FACTOR",
        type=_positive,
        help="seconds of the film for each of the run; default 1, or what makes it last 6 s",
    )
    start = "first time, s; default when something begins to move"
    add("--from", dest="begin", metavar="TIME", type=float, help=start)
    add("--until", dest="end", metavar="TIME", type=float, help="last time, s; default at rest")
    add("--width", metavar="PIXELS", type=_width, default=960, help="of the picture; default 960")


def _add_runs(parser: Any) -> None:
    """The folders of runs: `options.runs`."""
    parser.add_argument("runs", metavar="DIR", type=Path, nargs="+", help="folders of runs")


def _positive(text: str) -> float:
    """A number above 0."""
    value = float(text)
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"got {text}, allowed a number > 0")
    return value


def _width(text: str) -> int:
    """A width of a film, pixels."""
    value = int(text)
    if not 320 <= value <= 3840:
        raise argparse.ArgumentTypeError(f"got {text}, allowed 320 to 3840")
    return value


def read_runs(folders: Sequence[Path]) -> list[Run]:
    """Runs read back; those without a summary are reported."""
    from solver.results.runs import UNFINISHED, read_run

    runs = [read_run(folder) for folder in folders]
    for run in runs:
        if run.summary["status"] == UNFINISHED:
            end = f"t = {run.history['time_s'][-1]:.6g} s"
            tell(f"{run.folder}: no summary.json, made from the history up to {end}\n")
    return runs


def plot_runs(options: argparse.Namespace) -> int:
    """`rockslip plot`."""
    if launched_rank() != 0:
        return 0
    runs = read_runs(options.runs)
    try:
        from solver.pictures.pictures import picture_run, picture_runs, tables_of_run
    except ImportError as error:
        raise not_installed(error) from error
    folder = options.output or options.runs[0]
    open_folder(folder)
    if len(runs) == 1:
        files = picture_run(runs[0], folder, options.formats)
        files += tables_of_run(runs[0], folder)
    else:
        files = picture_runs(runs, folder, options.formats)
    say("".join(f"{file}\n" for file in files))
    return 0


def film_runs(options: argparse.Namespace) -> int:
    """`rockslip animate`."""
    if launched_rank() != 0:
        return 0
    runs = read_runs(options.runs)
    try:
        import pyvista  # noqa: F401  (imported when it draws, and missed before that)
        from PIL import Image  # noqa: F401

        from solver.pictures.encode import default_ending
        from solver.pictures.film import FilmOptions, film
    except ImportError as error:
        raise not_installed(error) from error
    file = options.output or options.runs[0] / f"film{default_ending()}"
    refuse_unwritable(file.parent)
    chosen = FilmOptions(
        fixed=options.frame == "fixed",
        slow=options.slow,
        begin=options.begin,
        end=options.end,
        width=options.width,
    )
    film(runs, file, chosen)
    say(f"{file}\n")
    return 0
