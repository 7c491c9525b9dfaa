"""`rockslip study error-runtime`: what an error costs, for one scene."""

from __future__ import annotations

import argparse
import sys
from importlib.util import find_spec
from pathlib import Path

from solver.arguments import add_overrides, add_scene
from solver.errors import EnvironmentTrouble, NotConverged, SceneError

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
    """The study; one rank does it, since runs that are timed stand alone."""
    from mpi4py import MPI

    if MPI.COMM_WORLD.rank != 0:
        return 0
    from solver.run.folders import claim_folder
    from solver.scene import load_scene, scene_to_toml
    from solver.study.error_runtime.findings import read_beside
    from solver.study.error_runtime.ladders import NAMES, check_names
    from solver.study.error_runtime.measures import check_patterns
    from solver.study.error_runtime.study import study, write
    from solver.study.error_runtime.table import text

    if find_spec("matplotlib") is None:  # told before the runs, not after them
        raise EnvironmentTrouble("no matplotlib, which the picture needs; see README.md")
    _check_numbers(options)
    check_names(options.families or NAMES)
    check_patterns(options.measures)
    scene = load_scene(options.scene, options.overrides)
    others = read_beside(options.beside) if options.beside else []
    folder = options.output or Path(options.scene.stem + ".errors")
    claim_folder(folder, options.scene, options.force)
    (folder / "scene.toml").write_text(scene_to_toml(scene), encoding="utf-8")
    findings = study(
        scene,
        names=options.families or NAMES,
        wanted=options.measures,
        rungs=options.rungs,
        repeat=options.repeat,
        longest=options.longest,
        target=options.target / 100,
        others=others,
        tell=_ignore if options.quiet else _tell,
    )
    files = write(findings, folder)
    if not options.quiet:
        sys.stdout.write(f"\n{text(findings)}written to {folder}: ")
        sys.stdout.write(f"{', '.join(file.name for file in files)}\n")
    completed = all(trial.outcome.completed for trial in findings.trials)
    return 0 if completed else NotConverged.exit_code


def _tell(line: str) -> None:
    """Say that a run is done."""
    sys.stderr.write(f"{line}\n")


def _ignore(line: str) -> None:
    """Say nothing."""


def _check_numbers(options: argparse.Namespace) -> None:
    """Refuse numbers that make no study."""
    for name, value, least, most in (
        ("--rungs", options.rungs, 2, 12),
        ("--repeat", options.repeat, 1, 100),
    ):
        if not least <= value <= most:
            raise SceneError(name, str(value), f"{least} to {most}")
    for name, value in (("--longest", options.longest), ("--target", options.target)):
        if not 0 < value < float("inf"):
            raise SceneError(name, f"{value:g}", "a number > 0")
