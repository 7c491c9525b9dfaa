"""Arguments that several commands take."""

from __future__ import annotations

import argparse
from pathlib import Path

from solver.errors import SceneError

SCENE = "a TOML file, or - for the standard input"


def add_scene(parser: argparse.ArgumentParser, *, text: str = SCENE, needed: bool = True) -> None:
    """The scene that a command is about: `options.scene`; None where it is not needed."""
    count = None if needed else "?"
    parser.add_argument("scene", metavar="SCENE", type=Path, nargs=count, help=text)


def add_overrides(parser: argparse.ArgumentParser, *, example: str = "block.height=1.2") -> None:
    """Values of the scene set from the command line: `options.overrides`."""
    parser.add_argument(
        "--set",
        dest="overrides",
        metavar="KEY=VALUE",
        nargs="+",
        action="extend",
        default=[],
        help=f"set values of the scene, such as {example}",
    )


def add_study_options(parser: argparse.ArgumentParser, noun: str, ending: str) -> None:
    """Options of studies that are kept in a folder and can be gone on with.

    Args:
        parser: Of the command.
        noun: What such a folder holds, in help.
        ending: Of the name of the folder by default, after that of the scene.
    """
    add = parser.add_argument
    add("-j", dest="processes", type=int, metavar="N", help="processes; default one a processor")
    add("-o", "--output", metavar="DIR", type=Path, help=f"default SCENE's name + {ending}")
    add("-q", "--quiet", action="store_true", help="say nothing but errors")
    again = parser.add_mutually_exclusive_group()
    again.add_argument("--force", action="store_true", help=f"write over an earlier {noun}")
    again.add_argument("--resume", action="store_true", help=f"go on with an earlier {noun}")


def check_processes(processes: int | None) -> None:
    """Refuse a number of processes below one."""
    if processes is not None and processes < 1:
        raise SceneError("-j", f"{processes}", "a whole number > 0")
