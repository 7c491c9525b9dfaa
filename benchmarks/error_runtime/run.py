"""The study of error against run time, as `rockslip study error-runtime` makes it."""

from __future__ import annotations

import argparse
import sys
from importlib.util import find_spec
from pathlib import Path

from solver.errors import EnvironmentTrouble, NotConverged, SceneError


def run(options: argparse.Namespace) -> int:
    """The study; one rank does it, since runs that are timed stand alone."""
    from mpi4py import MPI

    if MPI.COMM_WORLD.rank != 0:
        return 0
    from benchmarks.error_runtime.findings import read_beside
    from benchmarks.error_runtime.ladders import NAMES, check_names
    from benchmarks.error_runtime.measures import check_patterns
    from benchmarks.error_runtime.study import study, write
    from benchmarks.error_runtime.table import text
    from solver.run.folders import claim_folder
    from solver.scene import load_scene, scene_to_toml

    if find_spec("matplotlib") is None:  # told before the runs, not after them
        raise EnvironmentTrouble("no matplotlib, which the picture needs; see docs/install.md")
    _check_numbers(options)
    check_names(options.families or NAMES)
    check_patterns(options.measures)
    scene = load_scene(options.scene, options.overrides)
    answered_by = load_scene(options.answer) if options.answer else None
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
        answered_by=answered_by,
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
