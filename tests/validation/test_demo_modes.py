"""The demos of modes and of overturning, with few points and rigid blocks."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from demos.modes import modes
from demos.overturning import overturning
from demos.study import read_table

Captured = pytest.CaptureFixture[str]

pytestmark = pytest.mark.serial


def test_modes(tmp_path: Path, capsys: Captured) -> None:
    """Its checks hold, and fail where a point disagrees."""
    pytest.importorskip("matplotlib")
    folder = tmp_path / "out"
    words = ["--engines", "rigid", "--points", "6", "-q", "-j", "1", "-o", str(folder)]
    assert modes.main(words) == 0
    assert capsys.readouterr().out.count("holds:") == 2
    assert len(read_table(folder / "modes.csv")) == 36
    summary = json.loads((folder / "summary.json").read_text())
    summary["maps"][0]["agree"] -= 1
    (folder / "summary.json").write_text(json.dumps(summary))
    assert [good for good, _ in modes.checks(folder)] == [False, True]


def test_overturning(tmp_path: Path, capsys: Captured) -> None:
    """Its checks hold, and fail where the equation is elsewhere."""
    pytest.importorskip("matplotlib")
    folder = tmp_path / "out"
    words = ["--frequencies", "2,4", "--ode", "2", "--amplitudes", "1:5:16", "--rounds", "0"]
    assert overturning.main([*words, "-q", "-j", "1", "-o", str(folder)]) == 0
    assert capsys.readouterr().out.count("holds:") == 3
    assert {row["engine"] for row in read_table(folder / "overturning.csv")} == {"rigid", "ode"}
    summary = json.loads((folder / "summary.json").read_text())
    summary["largest_difference"]["ode"] = 1e-3
    (folder / "summary.json").write_text(json.dumps(summary))
    assert [good for good, _ in overturning.checks(folder)] == [True, True, False]
