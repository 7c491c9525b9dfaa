"""The tables and pictures of the repository are listed with the commands that make them."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

from benchmarks import tables

ROOT = tables.ROOT

#: What is no result: points of other programs, and what the site is built with.
INPUTS = {"CMakeLists.txt", "benchmarks/scenes/beside.csv", "docs/requirements.txt"}


@pytest.fixture(scope="module")
def kept() -> list[str]:
    return [file for entry in tables.read().values() for file in entry["files"]]


def test_every_table_and_picture_is_listed(kept: list[str]) -> None:
    places = ("benchmarks/**/*.csv", "benchmarks/**/*.txt", "docs/**/*.txt", "docs/pictures/*")
    there = {file.relative_to(ROOT).as_posix() for place in places for file in ROOT.glob(place)}
    assert len(kept) == len(set(kept))
    assert there - INPUTS == set(kept)


def test_pictures_of_pages_are_listed(kept: list[str]) -> None:
    shown = set()
    for text in (ROOT / "README.md", *(ROOT / "docs").glob("*.md")):
        for target in re.findall(r"!\[[^]]*\]\(([^)#]+)\)", text.read_text("utf-8")):
            shown.add((text.parent / target).resolve().relative_to(ROOT).as_posix())
    assert shown <= set(kept)


def test_what_commands_name_is_there() -> None:
    for entry in tables.read().values():
        words = {word for command in entry["commands"] for word in command.split()}
        files = {word for word in words if word.endswith((".py", ".toml"))}
        assert [name for name in files if not (ROOT / name).exists()] == []


def test_the_page_is_that_of_the_list() -> None:
    """If not: `python3 -m benchmarks.tables --page`."""
    assert tables.PAGE.read_text("utf-8") == tables.page(tables.read())


def test_a_table_is_made_and_noted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tables, "ROOT", tmp_path)
    monkeypatch.setattr(tables, "FOLDER", tmp_path / "own")
    (tmp_path / "write.py").write_text(
        "import pathlib, sys\n"
        "pathlib.Path(sys.argv[1]).mkdir()\n"
        "pathlib.Path(sys.argv[1], 'left.csv').write_text('a\\n1\\n')\n"
    )
    entry = {"commands": ["python3 write.py {own}"], "files": {"kept.csv": "left.csv"}}
    tables.make("one", entry)
    assert (tmp_path / "kept.csv").read_text() == "a\n1\n"
    assert str(entry["made"]).startswith(tables.VERSION) and entry["machine"]
    assert not (tmp_path / "own" / "one").exists()


def test_the_list_is_read_as_it_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    listed, text = tables.read(), tables.LIST.read_text("utf-8")
    monkeypatch.setattr(tables, "LIST", tmp_path / "tables.toml")
    tables.LIST.write_text(text, encoding="utf-8")
    tables.write(listed)
    assert tables.read() == listed
    assert tables.LIST.read_text("utf-8").startswith("# Each table and picture")


def test_a_name_that_is_not_listed_is_refused() -> None:
    with pytest.raises(SystemExit):
        tables.main(["nothing"])


def test_every_tracked_table_is_below_these_places(kept: list[str]) -> None:
    """With git at hand: no table or picture is kept where the other tests do not look."""
    try:
        listed = subprocess.run(
            ["git", "ls-files", "*.csv", "*.png", "*.gif", "*.svg", "*.txt"],
            cwd=ROOT, check=True, capture_output=True, text=True,
        ).stdout.split()  # fmt: skip
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("no git, or no repository")
    assert {file for file in listed if not file.startswith("tests/")} - INPUTS <= set(kept)
