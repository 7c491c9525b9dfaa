"""Common parts of the demos of studies: command line, tables, verdict."""

from __future__ import annotations

import argparse
import csv
from collections.abc import Callable, Sequence
from pathlib import Path

from demos.verdict import verdict
from solver.cli import main as rockslip

Rows = list[dict[str, str]]

Checks = Callable[[Path], list[tuple[bool, str]]]
"""Checks of the results of a study in a folder: true if one holds, and its text."""


def judged_study(
    command: Sequence[str], checks: Checks, arguments: Sequence[str] | None, *, output: Path
) -> int:
    """Run `rockslip study` beside the options of a demo, and judge it; returns the exit code.

    Args:
        command: Name of the study, scene, options.
        checks: Of the demo.
        arguments: Options of the demo, which are those of the study; None: of the command line.
        output: Folder of the study where they name none; its last part is the demo's name.
    """
    name, scene, *rest = command
    parser = argparse.ArgumentParser(description=f"All options of `rockslip study {name}`, and:")
    parser.add_argument("-o", "--output", type=Path, default=output, help="folder of the study")
    options, words = parser.parse_known_args(arguments)
    again = [] if "--force" in words else ["--resume"]
    code = rockslip(["study", name, scene, *rest, *again, "-o", str(options.output), *words])
    if code not in (0, 3):  # 3: single cases failed or disagree, which the checks will say
        return code
    return verdict(output.name, checks(options.output))


def is_first_rank() -> bool:
    """True if this process draws and judges, under mpirun."""
    from mpi4py import MPI

    return MPI.COMM_WORLD.rank == 0


def read_table(file: Path) -> Rows:
    """The rows of a table."""
    with file.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))
