"""The base of studies: rounds of cases, rows that are kept; it goes on only with the same."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from solver import VERSION
from solver.errors import SceneError
from solver.study.study import SETTINGS, Row, Study, finished, with_digests

pytestmark = pytest.mark.serial


@dataclass(frozen=True)
class Square:
    """A case that squares a number; negative ones fail."""

    number: int

    @property
    def name(self) -> str:
        return f"square of {self.number}"

    def run(self) -> Row:
        if self.number < 0:
            raise SceneError("number", f"{self.number}", "0 or more")
        return {"status": "completed", "reason": "", "square": self.number**2}


class Squares(Study[Square]):
    """Squares of numbers, then those of the largest square."""

    kind, noun, same, files = "suite", "suite", "the same scene", ("suite.csv",)

    def rounds(self) -> Iterator[Sequence[Square]]:
        yield [Square(number) for number in self.options.numbers]
        yield [Square(max(row["square"] for row in self.completed))]

    def write(self) -> str:
        return "".join(f"{row['square']}\n" for row in self.completed)


def options(tmp_path: Path, **others: Any) -> argparse.Namespace:
    said: dict[str, Any] = {"processes": 1, "output": tmp_path / "out", "quiet": False}
    said |= {"scene": tmp_path / "scene.toml", "force": False, "resume": False, "numbers": [2, 3]}
    said["repeated"] = "rockslip study suite scene.toml"
    return argparse.Namespace(**said | others)


def claim(tmp_path: Path, settings: dict[str, Any], **others: Any) -> None:
    study = Squares(options(tmp_path, **others))
    study.settings = settings
    study.claimed()


def test_a_study_runs_round_after_round(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Cases that failed are reported and tried again; those with a row are not."""
    given = [2, -1, 3]
    assert Squares.run(options(tmp_path, numbers=given)) == 3
    told = "failed: square of -1: number: got -1, allowed 0 or more\n"
    assert capsys.readouterr().out == f"4\n9\n81\n{told}written to {tmp_path / 'out'}\n"
    assert sorted(finished(tmp_path / "out")) == [f"square of {n}" for n in (2, 3, 9)]
    file = tmp_path / "out" / "cases" / "square of 2.json"
    file.write_text(file.read_text().replace("4", "5"))
    (tmp_path / "out" / "cases" / "square of 3.json").write_text("half a ro")
    assert Squares.run(options(tmp_path, numbers=[2, 3], resume=True)) == 0
    assert capsys.readouterr().out.startswith("5\n9\n81\n")


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
    claim(tmp_path, settings)
    claim(tmp_path, settings, resume=True)
    (tmp_path / "one" / "up").write_text("others\n")
    with pytest.raises(SceneError, match=r"another motions\.a\.vertical\.file and 1 more"):
        claim(tmp_path, settings, resume=True)


def test_where_files_stand_does_not(tmp_path: Path, motion: dict[str, Any]) -> None:
    """Nor is one that has gone taken for the same."""
    claim(tmp_path, {"motion": motion})
    (tmp_path / "one").rename(tmp_path / "two")
    moved = motion | {"file": str(tmp_path / "two" / "along")}
    moved["vertical"] = motion["vertical"] | {"file": str(tmp_path / "two" / "up")}
    claim(tmp_path, {"motion": moved}, resume=True)
    with pytest.raises(SceneError, match=r"another motion\.file and 1 more"):
        claim(tmp_path, {"motion": motion}, resume=True)


def test_digests_stand_for_names(tmp_path: Path, motion: dict[str, Any]) -> None:
    held = with_digests(motion)
    assert held["vertical"]["factor"] == 2.0
    assert len({held["file"], held["vertical"]["file"], motion["file"]}) == 3
    gone = {"file": str(tmp_path / "gone"), "number": 3}
    assert with_digests(gone) == gone


@pytest.mark.parametrize("text", [None, '{"editor": 1}'])
def test_force_removes_folders_of_studies_alone(tmp_path: Path, text: str | None) -> None:
    own = tmp_path / "out" / "cases" / "mine.json"
    own.parent.mkdir(parents=True)
    own.write_text("{}")
    settings = tmp_path / "out" / SETTINGS
    if text:
        settings.write_text(text)
    with pytest.raises(SceneError, match=r"out, which holds cases/, but no study"):
        claim(tmp_path, {}, force=True)
    assert own.exists()
    settings.write_text('{"version": "0.2.0"}')
    claim(tmp_path, {}, force=True)
    assert not own.exists()


def test_a_study_of_another_version_is_refused(tmp_path: Path) -> None:
    claim(tmp_path, {})
    file = tmp_path / "out" / SETTINGS
    file.write_text(file.read_text().replace(VERSION, "0.0.1"))
    with pytest.raises(SceneError, match="made with another version, allowed the same scene"):
        claim(tmp_path, {}, resume=True)


@pytest.mark.parametrize("text", ["no table", "[1, 2]", "3", '{"version": "0.2.0"}'])
def test_damaged_settings_are_no_study(tmp_path: Path, text: str) -> None:
    claim(tmp_path, {})
    (tmp_path / "out" / SETTINGS).write_text(text)
    with pytest.raises(SceneError, match="which holds no suite"):
        claim(tmp_path, {}, resume=True)


def test_the_folder_of_the_scene_itself_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="which holds the scene itself, allowed another folder"):
        claim(tmp_path, {}, output=tmp_path, force=True)
