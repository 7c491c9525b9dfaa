"""Snapshots of meshed bodies are there when a run ends early."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from rockslip import parse_scene, simulate
from solver.errors import RockslipError
from solver.fields.vtu import ENTRY
from solver.history.history import History
from solver.run import files
from solver.scene import Scene

pytestmark = pytest.mark.serial
pytest.importorskip("dolfinx")

TIMES = [0.0, 0.01, 0.02, 0.03, 0.04, 0.05]


def scene(**output: object) -> Scene:
    """A coarse block that rocks on another, rigid one."""
    block = {"width": 0.25, "height": 1.0, "mass": 503.0, "young": 5e10, "poisson": 0.2}
    below = {"name": "below", "width": 1.0, "height": 0.2, "mass": 500.0, "model": "rigid"}
    above = block | {"name": "above", "on": "below", "cells": [2, 4], "tilt_deg": 1.0}
    time = {"end": TIMES[-1], "step": 1e-3}
    return parse_scene({"block": [below, above], "time": time, "output": {"every": 0.01} | output})


def listed(folder: Path) -> list[float]:
    """Times at which the fields show the upper block."""
    entries = ENTRY.finditer((folder / "fields.pvd").read_bytes())
    return [float(entry[1]) for entry in entries if b"above" in entry[0]]


class Stopping:
    """A display that stops the run at a time."""

    def __init__(self, error: type[BaseException]):
        self.error = error

    def begin(self, time: float) -> None: ...

    def close(self) -> None: ...

    def update(self, time: float, step: float, iterations: int) -> None:
        if time > 0.035:
            raise self.error("no more")


@pytest.mark.parametrize("error", [RockslipError, KeyboardInterrupt])
def test_a_run_that_ends_early_leaves_its_snapshots(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: type[BaseException]
) -> None:
    """Whatever it is that ends it; rows are there up to the last step."""
    monkeypatch.setattr(files, "PAUSE", math.inf)
    with pytest.raises(error, match="no more"):
        simulate(scene(), folder=tmp_path, progress=Stopping(error))
    assert listed(tmp_path) == pytest.approx(TIMES[:4])
    rows = History.read(tmp_path / "history.csv")["time_s"]
    assert rows[-1] == pytest.approx(0.036)
