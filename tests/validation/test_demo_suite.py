"""The demo of the suite, with two motions and a rigid block."""

from __future__ import annotations

import importlib
from pathlib import Path
from types import ModuleType

import pytest

from rockslip import load_scene

Captured = pytest.CaptureFixture[str]

pytestmark = [pytest.mark.serial, pytest.mark.slow]


@pytest.fixture(scope="module")
def demo() -> ModuleType:
    pytest.importorskip("matplotlib")
    return importlib.import_module("demos.suite.platform_suite")


@pytest.fixture(scope="module")
def folder(demo: ModuleType, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The suite at reduced size."""
    made = tmp_path_factory.mktemp("suite") / "output"
    words = [
        "--count",
        "2",
        "--set",
        "block.model=rigid",
        "time.step=4e-3",
        "time.adaptive=false",
        "-q",
        "-j",
        "1",
    ]
    assert demo.shake(words, made) == 0
    return made


def test_the_scene_is_the_paper_s(demo: ModuleType) -> None:
    scene = load_scene(demo.SCENE)
    (block,), platform = scene.blocks, scene.platform()
    assert (block.model, block.cells) == ("elastic", (6, 4))
    assert block.height < block.width / max(demo.FRICTIONS)  # too squat to rock
    assert scene.carried_mass / platform.mass == pytest.approx(2.0)
    assert (platform.period, platform.damping_ratio) == pytest.approx((0.5, 0.05))
    assert (scene.time.adaptive, scene.motion) == (True, None)
    assert demo.FRICTIONS == (0.1, 0.2, 0.3, 0.4)


def test_the_plate_is_the_platform_meshed(demo: ModuleType) -> None:
    scene, meshed = load_scene(demo.SCENE), load_scene(demo.PLATE)
    plate = meshed.foundation
    assert (plate.kind, plate.support, plate.width, plate.height) == ("elastic", "rollers", 3, 0.3)
    assert meshed.blocks == scene.blocks
    assert meshed.carried_mass / meshed.platform().mass == pytest.approx(2.0)
    for of in ("mass_ratio", "period", "damping_ratio"):
        assert getattr(plate, of) == getattr(scene.foundation, of)


def test_its_checks_hold(demo: ModuleType, folder: Path, capsys: Captured) -> None:
    assert demo.show(folder) == 0
    output = capsys.readouterr()
    assert output.err == ""
    assert output.out.count("holds:") == 1 + 2 * 4
    assert "8 of 8 runs completed" in output.out
    assert (folder / "peak_drifts.png").stat().st_size > 20_000
    rows = demo.read_table(folder / "suite.csv")
    assert [row["motion"] for row in rows] == ["synthetic_01", "synthetic_02"] * 4
    for row in rows:
        ratio = float(row[demo.DRIFT]) / float(row[demo.EXACT])
        assert float(row[demo.RATIO]) == pytest.approx(ratio) == pytest.approx(1.0, abs=2e-3)


def test_a_meshed_plate_drifts_like_the_oscillator(
    demo: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A motion under which the block slides, with default steps."""
    monkeypatch.setattr(demo, "FRICTIONS", (0.1,))
    words = ["--count", "1", "--seed", "6", "-q", "-j", "1"]
    words += ["--set", "block.cells=[3,2]"]
    assert demo.shake(words, tmp_path / "plate", demo.PLATE) == 0
    rows = demo.read_table(tmp_path / "plate" / "suite.csv")
    assert max(float(row["block.peak_slip_m"]) for row in rows) > 1e-3
    assert [float(row[demo.RATIO]) for row in rows] == pytest.approx([1.0], abs=1e-3)


def test_its_checks_can_fail(demo: ModuleType, folder: Path, capsys: Captured) -> None:
    rows = demo.read_table(folder / "suite.csv")
    rows[0][demo.RATIO], rows[1][demo.RATIO] = "1.021", "0.979"
    assert demo.verdict("platform_suite", demo.checks(rows)) == 1
    said = "friction 0.1, 2 motions: every ratio 0.9790 to 1.0210, within 1 +- 0.02"
    assert capsys.readouterr().err == f"platform_suite: check failed: {said}\n"
