"""Demos of a foundation, a stack and a frame at reduced length, and two on two ranks."""

from __future__ import annotations

import importlib
import os
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from processes import outside_mpirun, python

from rockslip import read_run

Captured = pytest.CaptureFixture[str]

pytestmark = [pytest.mark.serial, pytest.mark.slow]

DEMOS = Path(__file__).parents[2] / "demos"

#: Module, end of the runs, picture, number of checks.
SHORT = {
    "foundation": ("demos.foundation.block_on_foundation", 0.4, "foundation.png", 14),
    "stack": ("demos.stack.stack_under_record", 2.0, "stack.png", 13),
    "frame": ("demos.frame.block_on_frame", 0.6, "frame.png", 11),
}


def module_of(name: str) -> ModuleType:
    """The script of a demo as a module."""
    for package in ("dolfinx", "gmsh", "pyvista", "matplotlib"):
        pytest.importorskip(package)
    return importlib.import_module(SHORT[name][0])


def runs_of(folder: Path) -> list[Path]:
    """The folders of the runs of a demo, in their order."""
    files = sorted(folder.glob("*/summary.json"), key=lambda file: file.stat().st_mtime)
    return [file.parent for file in files]


@pytest.fixture(scope="module", params=list(SHORT))
def left(request: Any, tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Path]:
    """The name of a demo and the folder that its short form has left."""
    demo, end = module_of(request.param), SHORT[request.param][1]
    folder = tmp_path_factory.mktemp("demo") / "made" / "output"
    assert demo.main(["--output", str(folder), "--set", f"time.end={end}"]) == 0
    return request.param, folder


def test_its_checks_hold(left: tuple[str, Path], capsys: Captured) -> None:
    name, folder = left
    _, _, picture, count = SHORT[name]
    assert module_of(name).show(runs_of(folder)) == 0
    said = capsys.readouterr()
    assert said.err == ""
    assert said.out.count("holds:") == count
    assert (folder / picture).stat().st_size > 20_000


def test_its_checks_can_fail(left: tuple[str, Path]) -> None:
    """A small change of the results of the last run fails at least one check."""
    name, folder = left
    demo = module_of(name)
    runs = [read_run(each) for each in runs_of(folder)]
    assert all(good for good, _ in demo.checks(runs))
    if name == "foundation":
        runs[0].summary["blocks"]["block"]["impacts"][0]["time_s"] += 1e-5
    else:
        history = runs[0].history
        columns = {column: history[column] for column in history.columns}
        columns["platform.drift_m"] *= 1.2
        runs[0] = replace(runs[0], history=columns)
    assert [good for good, _ in demo.checks(runs)].count(False) == 1
    runs[1].summary["energy"]["ledger_error_fraction"] = 2e-8
    assert [good for good, _ in demo.checks(runs)].count(False) == 2


SCRIPTS = {
    "free_rocking/free_rocking.py": "time.end=0.6",
    "frame/block_on_frame.py": "time.end=0.5",
}


@pytest.mark.mpi
@pytest.mark.parametrize("script", list(SCRIPTS))
def test_it_runs_on_two_ranks(script: str, tmp_path: Path) -> None:
    """By its script, as from the command line, into a folder in the current one."""
    done = python(DEMOS / script, "--set", SCRIPTS[script], ranks=2, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "check failed" not in done.stderr
    assert done.stdout.count("holds:") > 4
    assert list((tmp_path / "output" / script.split("/", maxsplit=1)[0]).glob("*.png"))


EARLY = {
    "free_rocking.free_rocking": "no impact until 0.02 s",
    "foundation.block_on_foundation": "no impact until 0.02 s",
    "platform.block_on_platform": "final slip: 0 until the end, too early to compare",
    "frame.block_on_frame": "too little to compare",
}


@pytest.mark.parametrize("demo", list(EARLY))
def test_what_ends_too_early_is_said_in_a_line(demo: str, tmp_path: Path, capsys: Captured) -> None:
    """Before any impact or slip there is nothing to compare: checks fail, in one line."""
    module_of("frame")
    program = importlib.import_module(f"demos.{demo}")
    assert program.main(["--output", str(tmp_path / "out"), "--set", "time.end=0.02"]) == 1
    said = [line for line in capsys.readouterr().err.splitlines() if "check failed" in line]
    assert len(said) == 1 and EARLY[demo] in said[0]


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can become another user")
def test_it_runs_as_another_user() -> None:
    """A user without write access to the repository finds the results in the current folder."""
    with tempfile.TemporaryDirectory() as made:  # pytest's own folders are closed to others
        home = Path(made)
        home.chmod(0o755)
        os.chown(home, 65534, 65534)
        environment = {**outside_mpirun(), "PYTHONPATH": str(DEMOS.parent), "HOME": made}
        environment |= {"XDG_CACHE_HOME": made, "MPLCONFIGDIR": made}
        done = subprocess.run(
            [sys.executable, str(DEMOS / "hertz" / "hertz.py")],
            cwd=home,
            env=environment,
            user=65534,
            group=65534,
            capture_output=True,
            text=True,
            timeout=900,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        assert (home / "output" / "hertz" / "hertz.png").is_file()
