"""A study goes on only with what it was made from: of files, what they hold."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from solver.errors import SceneError
from solver.study.folder import SETTINGS, StudyFolder, contents, with_contents

FOLDER = StudyFolder(kind="suite", same="the same scene", files=("suite.csv",))


def resumed(folder: Path, settings: dict[str, Any]) -> None:
    FOLDER.claim(folder, settings, force=False, resume=True)


@pytest.fixture
def motion(tmp_path: Path) -> dict[str, Any]:
    """A motion with a file in each of two directions."""
    (tmp_path / "one").mkdir()
    for name in ("along", "up"):
        (tmp_path / "one" / name).write_text(f"samples {name}\n")
    one = tmp_path / "one"
    return {"file": str(one / "along"), "vertical": {"file": str(one / "up"), "factor": 2.0}}


def test_what_files_hold_counts_in_all_directions(tmp_path: Path, motion: dict[str, Any]) -> None:
    settings = {"version": 1, "scenes": [{"motion": motion}], "motions": {"a": motion}}
    FOLDER.claim(tmp_path / "out", settings, force=False, resume=False)
    resumed(tmp_path / "out", settings)
    (tmp_path / "one" / "up").write_text("others\n")
    with pytest.raises(SceneError, match=r"another motions\.a\.vertical\.file and 1 more"):
        resumed(tmp_path / "out", settings)


def test_where_files_stand_does_not(tmp_path: Path, motion: dict[str, Any]) -> None:
    """Nor is one that has gone taken for the same."""
    FOLDER.claim(tmp_path / "out", {"motion": motion}, force=False, resume=False)
    (tmp_path / "one").rename(tmp_path / "two")
    moved = motion | {"file": str(tmp_path / "two" / "along")}
    moved["vertical"] = motion["vertical"] | {"file": str(tmp_path / "two" / "up")}
    resumed(tmp_path / "out", {"motion": moved})
    with pytest.raises(SceneError, match=r"another motion\.file and 1 more"):
        resumed(tmp_path / "out", {"motion": motion})


def test_contents_stand_for_names(tmp_path: Path, motion: dict[str, Any]) -> None:
    held = with_contents(motion, contents(motion))
    assert held["vertical"]["factor"] == 2.0
    assert len({held["file"], held["vertical"]["file"], motion["file"]}) == 3
    gone = {"file": str(tmp_path / "gone"), "number": 3}
    assert with_contents(gone, contents(gone)) == gone


def test_force_removes_folders_of_studies_alone(tmp_path: Path) -> None:
    own = tmp_path / "out" / "cases" / "mine.json"
    own.parent.mkdir(parents=True)
    own.write_text("{}")
    with pytest.raises(SceneError, match=r"out, which holds cases/, but no study"):
        FOLDER.claim(tmp_path / "out", {}, force=True, resume=False)
    (tmp_path / "out" / SETTINGS).write_text('{"editor": 1}')
    with pytest.raises(SceneError, match=r"out, which holds cases/, but no study"):
        FOLDER.claim(tmp_path / "out", {}, force=True, resume=False)
    assert own.exists()
    (tmp_path / "out" / SETTINGS).write_text('{"version": "0.2.0"}')
    FOLDER.claim(tmp_path / "out", {}, force=True, resume=False)
    assert not own.exists()


@pytest.mark.parametrize("text", ["no table", "[1, 2]", "3", '{"files": 3}'])
def test_damaged_settings_are_no_study(tmp_path: Path, text: str) -> None:
    FOLDER.claim(tmp_path / "out", {}, force=False, resume=False)
    (tmp_path / "out" / SETTINGS).write_text(text)
    with pytest.raises(SceneError, match="which holds no suite"):
        resumed(tmp_path / "out", {})
