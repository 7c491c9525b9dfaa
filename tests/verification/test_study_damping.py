"""The study of damping for real, on a coarse block: on a base that moves, and on ranks."""

from __future__ import annotations

import csv
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from solver.cli import main
from tests.scenes import GRANITE

pytestmark = pytest.mark.serial

ROOT = Path(__file__).parents[2]

COARSE = GRANITE.replace("5.0e10", "5.0e9").replace("tilt_deg", "cells = [2, 4]\ntilt_deg")
SCENE = COARSE + "[damping]\nstiffness = 1.2e-4\n[time]\nend = 1.5\ntolerance = 4e-3\n"
"""A soft, coarse block, in steps that leave 0.001 of its restitution open."""


WORDS = ("study", "damping", "scene.toml", "--impacts", "2", "-j", "2", "-q")


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with the scene."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.toml").write_text(SCENE)
    return tmp_path


def table(folder: Path) -> list[dict[str, str]]:
    with (folder / "damping.csv").open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


@pytest.mark.slow
def test_a_block_that_is_shaken(here: Path) -> None:
    """Restitution on a base that moves is within 0.01 of that of free rocking."""
    pulse = '[motion]\nkind = "half_sine"\namplitude_g = 0.5\nduration = 0.2\n'
    (here / "shaken.toml").write_text(SCENE.replace("tilt_deg = 3.0\n", "") + pulse)
    words = ["study", "damping", "shaken.toml", "--impacts", "2", "-q", "--of", "beta=1e-4"]
    assert main([*words, "-o", "shaken", "--set", "time.end=2.0"]) == 0
    rows = table(here / "shaken")
    assert main([*WORDS, "--of", "beta=1e-4", "-o", "free"]) == 0
    free = float(table(here / "free")[-1]["restitution"])
    restitution = [float(row["restitution"]) for row in rows]
    assert np.allclose(restitution, free, atol=0.01), (restitution, free)


@pytest.mark.mpi
@pytest.mark.slow
def test_the_same_on_ranks(here: Path) -> None:
    """Rank 0 gives out the runs, of a sweep and of a calibration; the numbers are the same."""
    command = [sys.executable, "-m", "solver", *WORDS]
    for words in (["--of", "beta=1e-4"], ["--target", "restitution=0.99", "--resume"]):
        done = subprocess.run(
            ["mpirun", "--oversubscribe", "-n", "2", *command, "-o", "ranks", *words],
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            capture_output=True, text=True, timeout=600, check=False,
        )  # fmt: skip
        refused = "--target" in words
        assert done.returncode == (2 if refused else 0), done.stderr
    assert done.stderr.count("rockslip: --target: got 0.99, allowed 0.") == 1
    assert main([*WORDS, "--of", "beta=1e-4", "-o", "serial"]) == 0
    one, other = table(here / "ranks"), table(here / "serial")
    assert [row["restitution"] for row in one] == [row["restitution"] for row in other]
