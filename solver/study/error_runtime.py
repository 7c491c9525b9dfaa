"""`rockslip study error-runtime`: what an error costs, for one scene.

The study itself stands in `benchmarks/error_runtime/`; here are its options.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from solver.arguments import add_overrides, add_scene
from solver.study.repository import run_from_repository

TEXT = "error against run time: ladders of step, tolerance, mesh, degree, points, rho_inf, model"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the study."""
    add_scene(parser)
    add_overrides(parser, example="time.step=5e-4")
    parser.add_argument(
        "-o", "--output", metavar="DIR", type=Path, help="default: SCENE's name + .errors"
    )
    parser.add_argument("--force", action="store_true", help="write over an earlier study")
    parser.add_argument("-q", "--quiet", action="store_true", help="say nothing but errors")
    parser.add_argument(
        "--families", metavar="NAME", nargs="+",
        help="varied besides step: adaptive, mesh, degree, points, rho_inf, model; default all",
    )  # fmt: skip
    parser.add_argument(
        "--measures", metavar="NAME", nargs="+", default=[],
        help="what is judged, such as first_impact or peak_drift; default: all there is",
    )  # fmt: skip
    parser.add_argument(
        "--rungs", type=int, default=6, metavar="N", help="steps of a ladder, 2 to 12; default 6"
    )
    parser.add_argument(
        "--repeat", type=int, default=3, metavar="N", help="times that each run is made; default 3"
    )
    parser.add_argument(
        "--longest", type=float, default=60.0, metavar="S",
        help="leave out runs that would take longer than this many seconds; default 60",
    )  # fmt: skip
    parser.add_argument(
        "--target", type=float, default=1.0, metavar="PERCENT",
        help="error for which to say what to use; default 1",
    )  # fmt: skip
    parser.add_argument(
        "--beside", metavar="FILE", type=Path,
        help="CSV with points of other programs: program, measure, error, seconds, note",
    )  # fmt: skip


def run(options: argparse.Namespace) -> int:
    """The study; 0 where all runs completed, 3 where one did not."""
    return run_from_repository("error_runtime", options)
