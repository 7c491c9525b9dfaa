"""`rockslip study stability`: scenes driven far, each with a verdict.

The study itself stands in `benchmarks/stability/`; here are its options.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from solver.study.repository import run_from_repository

TEXT = "scenes driven far, each with a verdict: held, refused by name, or failed"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the study."""
    add = parser.add_argument
    add(
        "--family",
        dest="families",
        metavar="NAME",
        nargs="+",
        default=[],
        help="only these families: beginnings of their names",
    )
    add("--random", type=int, metavar="N", default=0, help="so many random scenes instead")
    add("--seed", type=int, metavar="S", default=1, help="of the random scenes, default 1")
    add("--limit", type=float, metavar="S", default=120.0, help="wall time a scene, default 120 s")
    add("-j", dest="processes", type=int, metavar="N", help="processes; default one a processor")
    add("-o", "--output", metavar="DIR", type=Path, default=Path("stability"), help="folder")
    add("--force", action="store_true", help="write over an earlier study")
    add("-q", "--quiet", action="store_true", help="say nothing but errors")


def run(options: argparse.Namespace) -> int:
    """The study; 0 where every scene holds or is refused, 3 where one failed."""
    return run_from_repository("stability", options)
