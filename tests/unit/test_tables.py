"""The tables and pictures of the repository are those of its code, or said not to be."""

from __future__ import annotations

import re
import subprocess
import warnings
from pathlib import Path

import pytest

from benchmarks.tables import accepted, making, record
from benchmarks.tables.__main__ import main
from benchmarks.tables.accepted import Change, changed, needed, state_harmless
from benchmarks.tables.listed import EVIDENCE, Evidence
from benchmarks.tables.page import PAGE, page
from benchmarks.tables.record import Made
from benchmarks.tables.sources import ROOT, digests, of_python, of_toml
from benchmarks.tables.state import State, releases_behind, state, states

#: What is no result: points of other programs, and what the site is built with.
INPUTS = {"benchmarks/scenes/beside.csv", "docs/requirements.txt"}


@pytest.fixture(scope="module")
def found() -> dict[str, State]:
    """How every table stands to the code."""
    return states(EVIDENCE, record.read(), accepted.harmless())


def test_no_table_is_older_than_the_code_unless_this_is_known(found: dict[str, State]) -> None:
    """`make tables` makes it anew; benchmarks/tables has the lists of what may differ."""
    known = accepted.known_stale()
    stale = {name: one.reasons for name, one in found.items() if one.stale}
    told = "; ".join(f"{name} ({known[name]})" for name in known if name in stale)
    if told:
        warnings.warn(f"older than the code, as is known: {told}", stacklevel=1)
    assert {name: why for name, why in stale.items() if name not in known} == {}


def test_what_is_known_to_be_older_is_older(found: dict[str, State]) -> None:
    assert [n for n in accepted.known_stale() if n not in found or not found[n].stale] == []


def test_every_table_and_picture_is_listed() -> None:
    kept = [file for evidence in EVIDENCE.values() for file in evidence.files]
    places = ("benchmarks/**/*.csv", "benchmarks/**/*.txt", "docs/**/*.txt", "docs/pictures/*")
    there = {file.relative_to(ROOT).as_posix() for place in places for file in ROOT.glob(place)}
    assert len(kept) == len(set(kept))
    assert there - INPUTS == set(kept)


def test_pictures_of_pages_are_listed() -> None:
    kept = {file for evidence in EVIDENCE.values() for file in evidence.files}
    shown = set()
    for text in (ROOT / "README.md", *(ROOT / "docs").glob("*.md")):
        for target in re.findall(r"!\[[^]]*\]\(([^)#]+)\)", text.read_text("utf-8")):
            shown.add((text.parent / target).resolve().relative_to(ROOT).as_posix())
    assert shown <= kept


def test_what_decides_a_table_is_there() -> None:
    for evidence in EVIDENCE.values():
        words = {word for command in evidence.commands for word in command.split()}
        files = {word for word in words if word.endswith((".py", ".toml"))}
        assert [name for name in {*evidence.code, *files} if not (ROOT / name).exists()] == []


def test_the_page_says_what_is_recorded() -> None:
    """If not: `python3 -m benchmarks.tables --page`."""
    assert PAGE.read_text("utf-8") == page(record.read(), accepted.known_stale())


def test_stated_changes_have_a_reason_and_are_needed() -> None:
    changes = accepted.harmless()
    recorded = [(name, made.code) for name, made in record.read().items()]
    assert needed(changes, recorded) == changes
    assert all(len(why.split()) > 2 for why in accepted.known_stale().values())
    assert all(len(change.why.split()) > 2 for change in changes)


def test_words_do_not_change_a_digest() -> None:
    """Neither comments nor docstrings nor the layout."""
    first = 'def f(x):\n    """One."""\n    return f"{x} + 1"\n'
    same = 'def f(x):  # a comment\n    """Two."""\n    return (f"{x}" " + 1")\n'
    assert of_python(first) == of_python(same)
    assert of_python(first) != of_python(same.replace("1", "2"))
    assert of_python("x = 1\n'a text after it'\n") == of_python("x = 1\n")
    assert of_python("x = 1\n") != of_python("x = True\n")
    assert of_toml("a = 1  # one\n") == of_toml("a=1\n") != of_toml("a = 1.0\n")


def test_a_digest_is_that_of_every_python() -> None:
    """Syntax trees differ between versions; 3.11 to 3.13 gave this one."""
    text = 'def f[T](x, *, y=None):\n    return f"a{x!r:>{y}}{{b" f"c"\n'.replace("[T]", "")
    assert of_python(text) == "1f6284fa225a"


def test_a_module_that_moves_changes_its_folder(tmp_path: Path) -> None:
    first, second = tmp_path / "first", tmp_path / "second"
    for root, name in ((first, "a.py"), (second, "b.py")):
        (root / "code").mkdir(parents=True)
        (root / "code" / name).write_text("x = 1\n")
    assert digests(["code"], first) != digests(["code"], second)
    assert digests(["nowhere"], first) == {"nowhere": "-"}


def change(source: str, before: str, after: str, *tables: str) -> Change:
    return Change(source=source, before=before, after=after, tables=tables, why="rows compared")


def test_harmless_changes_follow_on_each_other() -> None:
    changes = [change("a", "1", "2", "one", "two"), change("a", "2", "3", "one")]
    assert changed("one", {"a": "1"}, {"a": "3"}, changes) == []
    assert changed("two", {"a": "1"}, {"a": "3"}, changes) == ["a"]
    assert changed("one", {"a": "3"}, {"a": "1"}, changes) == ["a"]
    assert changed("one", {"a": "1"}, {"a": "1", "b": "1"}, changes) == ["b"]


def test_a_change_is_stated_from_what_was_accepted_last() -> None:
    changes = [change("a", "1", "2", "one")]
    tables = [(name, {"a": digit}, {"a": "3"}) for name, digit in (("one", "1"), ("two", "2"))]
    stated = state_harmless("rows compared", tables, changes)
    assert stated == [*changes, change("a", "2", "3", "one", "two")]
    assert state_harmless("rows compared", tables, stated) == stated


def test_changes_that_no_record_needs_are_forgotten() -> None:
    changes = [change("a", "1", "2", "one", "two"), change("a", "2", "3", "one", "two")]
    assert needed(changes, [("one", {"a": "2"})]) == [change("a", "2", "3", "one")]


def test_changes_are_read_as_they_are_written(tmp_path: Path) -> None:
    changes = [change("a", "1", "2", "one", "two")]
    accepted.write(changes, tmp_path / "harmless.toml")
    assert accepted.harmless(tmp_path / "harmless.toml") == changes


def test_what_is_known_to_be_older_is_read_as_it_is_written(tmp_path: Path) -> None:
    known = {"one": "to be made anew"}
    accepted.write_known_stale(known, tmp_path / "known_stale.toml")
    assert accepted.known_stale(tmp_path / "known_stale.toml") == known


def test_list_names_every_table_and_what_is_older(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert {line.split()[0] for line in lines if line[0] != " "} >= set(EVIDENCE)
    for name, why in accepted.known_stale().items():
        at = next(n for n, line in enumerate(lines) if line.split()[0] == name)
        assert "older" in lines[at] and "(known)" in lines[at]
        assert f"    known: {why}" in lines[at:]


def test_a_name_that_is_not_listed_is_refused() -> None:
    with pytest.raises(SystemExit):
        main(["nothing"])


def made(**other: object) -> Made:
    known: dict[str, object] = {
        **{"version": "0.2.0", "date": "2026-11-23", "machine": "", "commit": "", "minutes": 0.0},
        **{"wall_minutes": 0.0, "load": 0.0, "code": {}, "files": {}},
    }
    return Made(**{**known, **other})  # type: ignore[arg-type]


def test_a_file_that_was_changed_by_hand_is_noticed(tmp_path: Path) -> None:
    (tmp_path / "table.csv").write_text("a\n1\n")
    evidence = Evidence(commands=("true",), code=(), files={"table.csv": "table.csv"})
    digest = making.of_bytes(tmp_path / "table.csv")
    entry = made(files={"table.csv": digest})
    assert not state("one", evidence, entry, [], tmp_path).stale
    (tmp_path / "table.csv").write_text("a\n2\n")
    assert state("one", evidence, entry, [], tmp_path).reasons == ("not as recorded: table.csv",)
    assert state("one", evidence, None, [], tmp_path).reasons == ("no record",)


def test_times_grow_old_with_the_versions() -> None:
    assert [releases_behind(version, "0.4.1") for version in ("0.4.0", "0.3.9", "0.1.0")] == [
        0,
        1,
        3,
    ]
    assert releases_behind("0.9.0", "1.0.0") > 100
    evidence = Evidence(commands=("true",), code=(), timed=True)
    assert state("one", evidence, made(version="0.0.1"), []).stale
    assert state("one", evidence, made(load=2.0), []).busy


def test_a_study_goes_on_only_with_the_code_that_began_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(making, "FOLDER", tmp_path)
    own = tmp_path / "study"
    assert not making._claim(own, {"a": "1"})
    own.mkdir()
    (own / making.SETTINGS).touch()
    assert making._claim(own, {"a": "1"})
    assert making._words("rockslip study modes scene.toml", own, True)[-1] == "--resume"
    assert not making._claim(own, {"a": "2"})
    assert not own.exists()


def test_a_record_is_read_as_it_is_written(tmp_path: Path) -> None:
    entries = {"one": made(code={"solver/law": "1"}, minutes=1.5)}
    record.write(entries, tmp_path / "record.toml")
    assert record.read(tmp_path / "record.toml") == entries


def test_every_tracked_table_is_below_these_places() -> None:
    """With git at hand: no table or picture is kept where the other tests do not look."""
    try:
        listed = subprocess.run(
            ["git", "ls-files", "*.csv", "*.png", "*.gif", "*.svg", "*.txt"],
            cwd=ROOT, check=True, capture_output=True, text=True,
        ).stdout.split()  # fmt: skip
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("no git, or no repository")
    kept = {file for evidence in EVIDENCE.values() for file in evidence.files}
    assert set(listed) - INPUTS <= kept
