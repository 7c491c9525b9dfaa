"""Snapshots of meshed bodies wait for one another, and none of them is lost."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest

from rockslip import parse_scene, simulate
from solver.errors import RockslipError
from solver.fields import meshed_snapshots
from solver.fields.vtu import ENTRY, PvdFiles
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


def pieces(folder: Path) -> dict[str, bytes]:
    """All files of the fields."""
    return {file.name: file.read_bytes() for file in sorted((folder / "fields").iterdir())}


@pytest.fixture
def written(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """How many snapshots were written together, each time."""
    counts, usual = list[int](), meshed_snapshots.Snapshots.flush

    def flush(snapshots: meshed_snapshots.Snapshots) -> None:
        if snapshots._waiting:
            counts.append(len(snapshots._waiting))
        usual(snapshots)

    monkeypatch.setattr(meshed_snapshots.Snapshots, "flush", flush)
    return counts


def test_they_are_the_same_as_written_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, written: list[int]
) -> None:
    """All that wait are written before a checkpoint, which they belong to, and at the end."""
    monkeypatch.setattr(files, "PAUSE", math.inf)
    simulate(scene(checkpoint={"steps": 25}), folder=tmp_path / "waiting")
    assert written == [1, 2, 3]
    for name, where, value in ("in time", files, 0.0), ("large", meshed_snapshots, 0):
        written.clear()
        monkeypatch.setattr(where, "PAUSE" if where is files else "MOST_WAITING", value)
        simulate(scene(), folder=tmp_path / name)
        assert written == [1] * 6
        assert listed(tmp_path / "waiting") == listed(tmp_path / name) == pytest.approx(TIMES)
        assert pieces(tmp_path / "waiting") == pieces(tmp_path / name)
        alone = ENTRY.finditer((tmp_path / name / "fields" / "fields_above.pvd").read_bytes())
        assert [float(entry[1]) for entry in alone] == listed(tmp_path / name)
        monkeypatch.setattr(files, "PAUSE", math.inf)


class Stopping:
    """A display that stops the run at a time."""

    def __init__(self, error: type[BaseException]):
        self.error = error

    def begin(self, time: float) -> None: ...

    def pause(self, why: str) -> None: ...

    def go_on(self) -> None: ...

    def close(self) -> None: ...

    def update(self, time: float, step: float, iterations: int) -> None:
        if time > 0.035:
            raise self.error("no more")


@pytest.mark.parametrize("error", [RockslipError, MemoryError, KeyboardInterrupt])
def test_a_run_that_ends_early_leaves_those_that_wait(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: type[BaseException]
) -> None:
    """Whatever it is that ends it; rows are there up to the last step."""
    monkeypatch.setattr(files, "PAUSE", math.inf)
    with pytest.raises(error, match="no more"):
        simulate(scene(), folder=tmp_path, progress=Stopping(error))
    assert listed(tmp_path) == pytest.approx(TIMES[:4])
    rows = History.read(tmp_path / "history.csv")["time_s"]
    assert rows[-1] == pytest.approx(0.036)


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt])
def test_none_is_written_twice(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: type[BaseException]
) -> None:
    """What stops the third one while it is listed leaves the others, in their order."""
    usual = PvdFiles.add

    def add(index: PvdFiles, time: float, *piece: object, **of: object) -> None:
        if time == pytest.approx(TIMES[2]) and "above" in piece:
            raise error("no more")
        usual(index, time, *piece, **of)  # type: ignore[arg-type]

    monkeypatch.setattr(files, "PAUSE", math.inf)
    monkeypatch.setattr(PvdFiles, "add", add)
    with pytest.raises(error, match="no more"):
        simulate(scene(), folder=tmp_path)
    assert listed(tmp_path) == pytest.approx(TIMES[:2] + TIMES[3:])
    named = re.findall(r"above(\d{6})[.]vtu", (tmp_path / "fields.pvd").read_text())
    assert [int(number) for number in named] == [0, 1, 3, 4, 5]
