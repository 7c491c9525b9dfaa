"""The demo of an ensemble, with a few motions."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from demos.ensemble import ensemble
from demos.study import read_table

pytestmark = pytest.mark.serial


def test_ensemble(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Its checks hold, and fail where engines are too far apart."""
    pytest.importorskip("matplotlib")
    folder = tmp_path / "out"
    words = ["--count", "4", "--levels", "0.2,0.5,1.5", "--set", "time.step=2e-3", "-q", "-j", "1"]
    assert ensemble.main([*words, "-o", str(folder)]) == 0
    assert capsys.readouterr().out.count("holds:") == 4
    assert {row["engine"] for row in read_table(folder / "fragility.csv")} == {"rigid", "ode"}
    for name in ("fragility.png", "peaks.png"):
        assert (folder / name).stat().st_size > 10_000
    summary = json.loads((folder / "summary.json").read_text())
    summary["distances"][1]["angle"] = 1.2
    (folder / "summary.json").write_text(json.dumps(summary))
    assert [good for good, _ in ensemble.checks(folder)] == [True, True, False, True]
