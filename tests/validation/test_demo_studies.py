"""Demos of studies on two ranks: the same tables as on one, and the verdict of one rank."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from processes import ROOT, outside_mpirun

from demos.study import read_table

pytestmark = [pytest.mark.serial, pytest.mark.slow, pytest.mark.mpi]

#: Script, options of its short form, its tables, number of checks that hold.
SHORT = {
    "inertia": ("live_load.py", "--count 3", ["map/inertia.csv", "blocks/inertia.csv"], 7),
    "modes": ("modes.py", "--engines rigid --points 4", ["modes.csv"], 2),
    "overturning": (
        "overturning.py",
        "--frequencies 2 --ode 2 --amplitudes 1:5:8 --rounds 0",
        ["overturning.csv"],
        3,
    ),
    "ensemble": (
        "ensemble.py",
        "--count 2 --levels 0.2,0.5 --set time.step=4e-3",
        ["suite.csv", "fragility.csv"],
        3,
    ),
    "suite": (
        "platform_suite.py",
        "--count 1 --set block.model=rigid time.step=4e-3 time.adaptive=false",
        ["suite.csv"],
        9,
    ),
}


def run(name: str, folder: Path, *launch: str) -> subprocess.CompletedProcess[str]:
    """The short form of a demo by its script, into a folder."""
    script, words, _, _ = SHORT[name]
    return subprocess.run(
        [*launch, sys.executable, str(ROOT / "demos" / name / script), "-q", "-o", str(folder),
         *words.split()],
        cwd=folder.parent,
        env={**outside_mpirun(), "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )  # fmt: skip


def rows_of(file: Path) -> list[dict[str, str]]:
    """The rows of a table without the time that they took."""
    return [{k: v for k, v in row.items() if k != "wall_s"} for row in read_table(file)]


@pytest.mark.parametrize("name", list(SHORT))
def test_it_does_the_same_on_two_ranks(name: str, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    _, _, tables, count = SHORT[name]
    one, two = tmp_path / "one", tmp_path / "two"
    for folder, launch in ((one, ()), (two, ("mpirun", "--oversubscribe", "-n", "2"))):
        done = run(name, folder, *launch)
        assert done.returncode == 0, done.stderr
        assert "check failed" not in done.stderr
        assert done.stdout.count("holds:") == count
    for table in tables:
        assert rows_of(one / table) == rows_of(two / table) != []
