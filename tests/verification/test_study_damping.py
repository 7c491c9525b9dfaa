"""The study of damping for real, on a coarse block: on a base that moves, and on ranks."""

from __future__ import annotations

import contextlib
import csv
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from processes import on_ranks
from scenes import GRANITE

from solver.cli import main

pytestmark = pytest.mark.serial

ROOT = Path(__file__).parents[2]

COARSE = GRANITE.replace("5.0e10", "5.0e9").replace("tilt_deg", "cells = [2, 4]\ntilt_deg")
SCENE = COARSE + "[damping]\nstiffness = 1.2e-4\n[time]\nend = 1.5\ntolerance = 4e-3\n"
"""A soft, coarse block, in steps that leave 0.001 of its restitution open."""


WORDS = ("study", "damping", "scene.toml", "--impacts", "1", "-j", "1", "-q")


@pytest.fixture(scope="module")
def here(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The current folder, with the scene and its study of one damping on one rank."""
    folder = tmp_path_factory.mktemp("damping")
    (folder / "scene.toml").write_text(SCENE)
    with contextlib.chdir(folder):
        assert main([*WORDS, "--of", "beta=1e-4", "-o", "serial"]) == 0
        yield folder


def table(folder: Path) -> list[dict[str, str]]:
    with (folder / "damping.csv").open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


@pytest.mark.slow
def test_a_block_that_is_shaken(here: Path) -> None:
    """Restitution on a base that moves is within 0.01 of that of free rocking."""
    pulse = '[motion]\nkind = "half_sine"\namplitude_g = 0.5\nduration = 0.2\n'
    (here / "shaken.toml").write_text(SCENE.replace("tilt_deg = 3.0\n", "") + pulse)
    words = ["study", "damping", "shaken.toml", "--impacts", "1", "-q", "--of", "beta=1e-4"]
    assert main([*words, "-o", "shaken", "--set", "time.end=2.0"]) == 0
    rows = table(here / "shaken")
    free = float(table(here / "serial")[-1]["restitution"])
    restitution = [float(row["restitution"]) for row in rows]
    assert np.allclose(restitution, free, atol=0.01), (restitution, free)


@pytest.mark.mpi
@pytest.mark.slow
def test_the_same_on_ranks(here: Path) -> None:
    """Rank 0 gives out the runs, of a sweep and of a calibration; the numbers are the same."""
    for words in (["--of", "beta=1e-4"], ["--target", "restitution=0.99", "--resume"]):
        done = on_ranks(2, here, *WORDS, "-o", "ranks", *words)
        refused = "--target" in words
        assert done.returncode == (2 if refused else 0), done.stderr
    assert done.stderr.count("rockslip: --target: got 0.99, allowed 0.") == 1
    one, other = table(here / "ranks"), table(here / "serial")
    assert [row["restitution"] for row in one] == [row["restitution"] for row in other]
