"""Arguments that several commands take."""

from __future__ import annotations

import argparse
from pathlib import Path

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
