"""The demo of the live load, with few motions."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

DEMO = Path(__file__).parents[2] / "demos" / "inertia" / "live_load.py"

Captured = pytest.CaptureFixture[str]

pytestmark = [pytest.mark.serial, pytest.mark.slow]


@pytest.fixture(scope="module")
def demo() -> ModuleType:
    pytest.importorskip("matplotlib")
    specification = importlib.util.spec_from_file_location("live_load", DEMO)
    assert specification is not None and specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def test_its_checks_hold(demo: ModuleType, tmp_path: Path, capsys: Captured) -> None:
    assert demo.main(["-o", str(tmp_path / "output"), "--count", "4", "-q", "-j", "2"]) == 0
    output = capsys.readouterr()
    assert output.err == ""
    assert output.out.count("holds:") == 4 + 3
    assert (tmp_path / "output" / "map" / "inertia.html").stat().st_size > 100_000


def test_each_check_can_fail(demo: ModuleType, capsys: Captured) -> None:
    row = {
        "period_s": "1",
        "friction": "0.1",
        "by": "sliding block",
        "lambda": "0.5",
        "lambda_low": "0.4",
    }
    rigid = row | {"by": "rigid blocks", "lambda": "0.504"}
    results = demo.checks([row | {"lambda": "0.6", "lambda_low": "0.55"}, row], [row, rigid])
    assert demo.verdict("live_load", results) == 1
    error = capsys.readouterr().err
    assert "T 1 s: 0.600, 0.500, growing" in error
    assert "friction 0.1: 0.5040 by rigid blocks, 0.5000 by the sliding block" in error
