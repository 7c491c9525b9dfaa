"""The note that says why a first run takes longer (MeshedRun)."""

from pathlib import Path

import pytest

from rockslip import parse_scene
from solver.law.compiled import NUMBA
from solver.run.meshed import MeshedRun

COMPILING = "compiling the local problem of contact"


def notes(dimension: int) -> list[str]:
    """What is logged while a block gets ready and stands for one step."""
    block = {
        "width": 0.5,
        "height": 1.0,
        "thickness": 0.5,
        "density": 2680.0,
        "young": 1e9,
        "poisson": 0.2,
    }
    scene = {
        "dimension": dimension,
        "block": [{**block, "cells": [2] * dimension}],
        "contact": {"friction": 0.5},
        "time": {"end": 1e-3, "step": 1e-3},
    }
    lines: list[str] = []
    run = MeshedRun(parse_scene(scene), lines.append)
    run.assembly.stepper.advance(run.state, 1e-3)
    return lines


@pytest.mark.skipif(NUMBA is None, reason="numba is not installed")
@pytest.mark.parametrize("dimension", [2, 3])
def test_compiling_is_said_once(
    dimension: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With an empty cache, and not with what an earlier run has left there."""
    notes(dimension)
    assert not any(line.startswith(COMPILING) for line in notes(dimension))
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    assert any(line.startswith(COMPILING) for line in notes(dimension))
