"""Limits of scenes: the material with its plane, and motions whose peak only a file tells."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from rockslip import Scene, parse_scene
from solver.cli import main
from solver.errors import SceneError
from solver.excitation.motion import read_ground
from solver.scene import scene_to_toml

BLOCK = {"width": 0.5, "height": 1.0, "density": 2000.0, "young": 1e9, "poisson": 0.2}
SOFT = BLOCK | {"young": 8e5, "cells": [2, 4]}
ELASTIC = BLOCK | {"poisson": 0.4999}
PEAK_G = 5.0


def scene(block: dict[str, Any], **tables: Any) -> Scene:
    """A scene of one block."""
    return parse_scene({"block": [block], "time": {"end": 1.0, "step": 1e-3}} | tables)


def test_plane_stress_is_judged_by_its_own_law() -> None:
    """Hardly any change of volume: in plane stress the thickness gives way, so nothing locks."""
    soft = ELASTIC | {"young": 1e7}
    with pytest.raises(SceneError, match=r"^block\.young: got 1e\+07, .* at poisson 0\.4999"):
        scene(soft)
    assert scene(soft, plane="stress").plane == "stress"


@pytest.fixture
def files(tmp_path: Path) -> Path:
    """A folder with a motion of 5 g, as a table and as a record."""
    (tmp_path / "table.csv").write_text(f"0 0\n0.1 {PEAK_G}\n0.2 {-PEAK_G}\n0.3 0\n")
    (tmp_path / "record.txt").write_text(f"units: g\n0\n{PEAK_G}\n{-PEAK_G}\n0\n")
    return tmp_path


MOTIONS: dict[str, dict[str, Any]] = {
    "sine": {"kind": "sine", "amplitude_g": PEAK_G, "period": 0.4},
    "table": {"kind": "table", "file": "table.csv"},
    "record": {"kind": "record", "file": "record.txt", "dt": 0.1},
    "vertical": {"kind": "none", "vertical": {"kind": "table", "file": "table.csv"}},
}


def refusal(motion: dict[str, Any], folder: Path) -> str:
    """The line that refuses a soft block under a motion, when it has been read at the latest."""
    content = {"block": [SOFT], "time": {"end": 1.0, "step": 1e-3}, "motion": motion}
    with pytest.raises(SceneError) as caught:
        read_ground(parse_scene(content, folder=folder))
    return str(caught.value)


@pytest.mark.parametrize("kind", MOTIONS)
def test_all_kinds_of_motion_count(files: Path, kind: str) -> None:
    """The same line under the same peak, whatever tells it."""
    line = refusal(MOTIONS[kind], files)
    assert line.startswith("block.young: got 800000, strained by ")
    assert line == refusal(MOTIONS["sine"], files)


def test_synthetic_motions_count() -> None:
    """Their peak is known when they have been computed."""
    asked = scene(SOFT, motion={"kind": "synthetic", "scale": 0.0})
    assert read_ground(asked).along is not None
    with pytest.raises(SceneError, match=r"^block\.young: got 800000, strained by "):
        read_ground(scene(SOFT, motion={"kind": "synthetic", "scale": 50.0}))


@pytest.mark.serial
@pytest.mark.parametrize("command", ["check", "run"])
def test_commands_refuse_before_anything_is_written(
    files: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    command: str,
) -> None:
    """One line, exit code 2."""
    content = {"block": [SOFT], "time": {"end": 1.0, "step": 1e-3}, "motion": MOTIONS["record"]}
    (files / "soft.toml").write_text(scene_to_toml(parse_scene(content, folder=files)))
    before = sorted(files.iterdir())
    monkeypatch.chdir(files)
    assert main([command, "soft.toml"]) == 2
    output = capsys.readouterr()
    assert output.out == ""
    assert (
        output.err.startswith("rockslip: block.young: got 800000") and output.err.count("\n") == 1
    )
    assert sorted(files.iterdir()) == before
