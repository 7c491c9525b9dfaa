"""Files that are components of one event: names, lists, what is missing, what is left out."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from solver.cli import build_parser, main
from solver.errors import SceneError
from solver.study.suite.cases import SuiteStudy
from solver.study.suite.motions import Component, SuiteMotion, find_motions

pytestmark = pytest.mark.serial

RECORDS = Path(__file__).parents[3] / "shared" / "records"

PAIR = {"units": "g", "second": {"kind": "record", "file": "its own", "units": "g"}}
TRIPLE = PAIR | {"vertical": {"kind": "record", "file": "its own", "scale": 0.5, "units": "g"}}


def furnish(folder: Path, *names: str) -> None:
    for number, name in enumerate(names):
        (folder / name).write_text(f"0.0 0.0\n0.01 0.{number + 1}\n0.02 0.0\n")


def events(words: list[str], motion: Any) -> dict[str, tuple[str, ...]]:
    """Names of the events, and those of their files along x, y and the vertical."""
    found, _ = find_motions(words, motion, count=None, seed=None)
    return {motion.name: files(motion) for motion in found}


def files(motion: SuiteMotion) -> tuple[str, ...]:
    tables = [motion.table, *(motion.table[key] for key in motion.beside)]
    return tuple(Path(table["file"]).name for table in tables)


@pytest.mark.parametrize(
    ("stem", "event", "azimuth"),
    [
        ("EVT_000", "EVT", 0), ("EVT_090", "EVT", 90), ("EVT_UP", "EVT", None),
        ("RSN1003_NORTHR_STN020", "RSN1003_NORTHR_STN", 20),
        ("RSN172_IMPVALL.H_H-E01140", "RSN172_IMPVALL.H_H-E01", 140),
        ("RSN963_NORTHR_ORR360", "RSN963_NORTHR_ORR", 0),
        ("RSN169_IMPVALL.H_H-DLTDWN", "RSN169_IMPVALL.H_H-DLT", None),
        ("RSN1003_NORTHR_STN-UP", "RSN1003_NORTHR_STN", None),
        ("TCU052-V", "TCU052", None), ("STA-VER", "STA", None), ("sta-ud", "sta", None),
        ("TCU052-N", "TCU052", 0), ("TCU052-E", "TCU052", 90), ("BAM-T", "BAM", 90),
        ("RSN6911_DARFIELD_HORCN18E", "RSN6911_DARFIELD_HORC", 18),
        ("RSN6911_DARFIELD_HORCS72E", "RSN6911_DARFIELD_HORC", 108),
        ("RSN8157_CCHURCH_HVSCS26W", "RSN8157_CCHURCH_HVSC", 206),
        ("RSN6911_DARFIELD_HORCUP", "RSN6911_DARFIELD_HORC", None),
        ("RSN1116_KOBE_SHI090_p695", "RSN1116_KOBE_SHI_p695", 90),
    ],
)  # fmt: skip
def test_names_tell_event_and_component(stem: str, event: str, azimuth: float | None) -> None:
    assert Component.of(stem) == Component(event, azimuth is None, azimuth)


@pytest.mark.parametrize("stem", ["strong", "startup", "a361", "090", "GROUP_A", "site999"])
def test_other_names_tell_none(stem: str) -> None:
    assert Component.of(stem) == Component(stem)


def test_what_the_scene_has_is_what_events_have(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Three components, a pair, one with the vertical, one: of the same folder."""
    monkeypatch.chdir(tmp_path)
    furnish(tmp_path, "A_090.txt", "A_360.txt", "A_UP.txt", "B-DWN.txt", "B180.txt", "B270.txt")
    found, notes = find_motions(["."], TRIPLE, count=None, seed=None)
    assert {m.name: files(m) for m in found} == {
        "A": ("A_360.txt", "A_090.txt", "A_UP.txt"), "B": ("B180.txt", "B270.txt", "B-DWN.txt")
    }  # fmt: skip
    own = found[0].table
    assert (own["units"], own["second"]["units"], own["vertical"]["scale"]) == ("g", "g", 0.5)
    assert "scale" not in own and "scale" not in own["second"]
    assert notes[0] == "motions shake along x, y, the vertical"
    assert notes[1].startswith("events are put together by the names of files")
    assert notes[2] == "taken as it stands, positive upwards: B-DWN.txt"
    found, notes = find_motions(["."], PAIR, count=None, seed=None)
    assert [files(m) for m in found] == [("A_360.txt", "A_090.txt"), ("B180.txt", "B270.txt")]
    assert notes[2] == ("left out, for the scene has no [motion.vertical]: A_UP.txt, B-DWN.txt")
    flat = {"vertical": {"scale": 0.7}, "units": "g"}
    found, notes = find_motions(["."], flat, count=None, seed=None)
    assert [files(m) for m in found] == [
        ("A_090.txt", "A_UP.txt"), ("A_360.txt", "A_UP.txt"),
        ("B180.txt", "B-DWN.txt"), ("B270.txt", "B-DWN.txt"),
    ]  # fmt: skip
    assert found[0].table["vertical"]["units"] == "g"  # as [motion] says, where it says nothing
    assert notes[1].startswith("4 horizontal components of 2 recordings: each is an event of its")
    assert events(["."], None) == {
        "A_090": ("A_090.txt",), "A_360": ("A_360.txt",),
        "B180": ("B180.txt",), "B270": ("B270.txt",),
    }  # fmt: skip


def test_a_list_has_columns(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    furnish(tmp_path, "one.txt", "two.txt", "three.txt", "with blank.txt", "A_000.txt", "A_090.txt")
    (tmp_path / "list").write_text(
        "one.txt two.txt three.txt  # blanks\nwith blank.txt, one.txt, two.txt\n"
    )
    assert events(["@list"], TRIPLE) == {
        "one": ("one.txt", "two.txt", "three.txt"),
        "with blank": ("with blank.txt", "one.txt", "two.txt"),
    }
    found, notes = find_motions(["@list"], None, count=None, seed=None)
    assert [files(motion) for motion in found] == [("one.txt",), ("with blank.txt",)]
    assert notes[1] == "left out, for the scene has no [motion.second]: two.txt, one.txt"
    (tmp_path / "list").write_text("one.txt - three.txt\nA_000.txt\nA_090.txt\n")
    flat = {"vertical": {"kind": "record"}}
    with pytest.raises(SceneError, match=r"A_000 without a vertical component .*, and 1 more"):
        events(["@list"], flat)
    (tmp_path / "list").write_text("one.txt - three.txt\n")
    assert events(["@list"], flat) == {"one": ("one.txt", "three.txt")}
    for line in ("one.txt two.txt three.txt one.txt", "- one.txt"):
        (tmp_path / "list").write_text(line)
        with pytest.raises(SceneError, match=r"list: line 1: got .*allowed a file along x"):
            events(["@list"], TRIPLE)


@pytest.mark.parametrize(
    ("names", "motion", "said"),
    [
        (("A_000.txt", "A_UP.txt"), TRIPLE, "A without a second horizontal component"),
        (("A_000.txt", "A_090.txt"), TRIPLE, "A without a vertical component (motion.vertical)"),
        (("A_UP.txt",), TRIPLE, "A without a horizontal component"),
        (("A_UP.txt",), None, "A_UP.txt: vertical alone"),
        (("A_000.txt", "A_UP.txt", "B_UP.txt"), {"vertical": {}}, "B without a horizontal comp"),
        (("A_000.txt", "A_045.txt"), PAIR, "A with A_000.txt, A_045.txt, allowed two horizontal"),
        (("A_000.txt", "A_090.txt", "A_180.txt"), PAIR, "A with A_000.txt, A_090.txt, A_180.txt"),
        (("strong.txt",), PAIR, "strong without a second horizontal component"),
        (("A_000.txt", "A_UP.txt", "A_V.txt"), {"vertical": {}}, "A with A_UP.txt, A_V.txt, allo"),
    ],
)
def test_what_is_missing_is_named(
    tmp_path: Path, names: tuple[str, ...], motion: Any, said: str
) -> None:
    furnish(tmp_path, *names)
    with pytest.raises(SceneError) as caught:
        events([str(tmp_path)], motion)
    assert said in str(caught.value) and "\n" not in str(caught.value)


def test_synthetic_events_have_three_components_of_one_earthquake() -> None:
    """Scale, start and samples are those of the scene; the notes list what is not."""
    motion = {"kind": "synthetic", "seed": 5, "scale": 2.0,
              "second": {"kind": "synthetic", "scale": 3.0},
              "vertical": {"kind": "synthetic", "scale": 0.6, "dt": 0.01}}  # fmt: skip
    found, notes = find_motions([], motion, count=2, seed=4)
    for number, event in enumerate(found, start=1):
        parts = [event.table, event.table["second"], event.table["vertical"]]
        assert [part["seed"] for part in parts] == [4000 + number] * 3
        assert [part["component"] for part in parts] == [1, 2, 3]
        assert [part["scale"] for part in parts] == [2.0, 3.0, 0.6]
        assert [part["dt"] for part in parts] == [0.005, 0.005, 0.01]
        assert len({(part["magnitude"], part["distance_km"], part["vs30"]) for part in parts}) == 1
    assert notes[1:] == [
        "components of each synthetic earthquake: 1 along x, 2 along y, 3 along the vertical",
        "not taken over from the scene: motion.seed",
    ]
    (plain, *_), notes = find_motions([], None, count=2, seed=4)
    assert "second" not in plain.table and "vertical" not in plain.table
    assert notes == ["motions shake along x"]


SCENE = """
dimension = 3
[[block]]
model = "rigid"
width = 1.0
thickness = 1.0
height = 1.0
density = 2000.0
[motion]
units = "g"
[motion.second]
[motion.vertical]
[time]
end = 1.0
"""


@pytest.mark.parametrize("changed", ["A_000.txt", "A_090.txt", "A_UP.txt"])
def test_a_suite_that_is_resumed_compares_all_components(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], changed: str
) -> None:
    furnish(tmp_path, "A_000.txt", "A_090.txt", "A_UP.txt")
    (tmp_path / "scene.toml").write_text(SCENE)
    words = ["study", "suite", str(tmp_path / "scene.toml"), "-o", str(tmp_path / "out")]
    words += ["--motions", *(str(file) for file in sorted(tmp_path.glob("A_*.txt")))]
    for again in ([], ["--resume"]):
        SuiteStudy(build_parser().parse_args([*words, *again])).claimed()
    (tmp_path / changed).write_text("0.0 0.0\n0.01 0.9\n0.02 0.0\n")
    assert main([*words, "--resume"]) == 2
    assert "made with another motions.A." in capsys.readouterr().err


@pytest.mark.parametrize("study", [["inertia"], ["suite", "--engines", "ode"]])
def test_what_knows_one_component_refuses_others(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], study: list[str]
) -> None:
    """Housner's equation and lambda are of motion along x alone."""
    scene = SCENE.replace("dimension = 3", "").replace("[motion.second]\n", "")
    furnish(tmp_path, "A_000.txt", "A_UP.txt")
    (tmp_path / "scene.toml").write_text(scene)
    kind, *options = study
    files = ["--motions", *(str(file) for file in sorted(tmp_path.glob("A_*.txt")))]
    words = ["study", kind, str(tmp_path / "scene.toml"), "-o", str(tmp_path / "out"), *files]
    assert main([*words, *options]) == 2
    assert "motion.vertical: got a motion, allowed none" in capsys.readouterr().err


@pytest.mark.skipif(not RECORDS.is_dir(), reason="no records here")
def test_recorded_files_make_events() -> None:
    """Of a folder of 69 files: the twelve stations with three components, by a list of theirs."""
    up = [f for f in RECORDS.glob("*.AT2") if Component.of(f.stem).vertical]
    stations = {Component.of(file.stem).event for file in up}
    chosen = [str(f) for f in sorted(RECORDS.glob("*.AT2"))
              if Component.of(f.stem).event in stations]  # fmt: skip
    found = events(chosen, TRIPLE)
    assert len(found) == len(up) == len(stations)
    assert found["RSN963_NORTHR_ORR"] == (
        "RSN963_NORTHR_ORR360.AT2", "RSN963_NORTHR_ORR090.AT2", "RSN963_NORTHR_ORR-UP.AT2"
    )  # fmt: skip
    assert found["RSN169_IMPVALL.H_H-DLT"][2] == "RSN169_IMPVALL.H_H-DLTDWN.AT2"
    with pytest.raises(
        SceneError, match=r"RSN1111_KOBE_NIS_p695 without a second horizontal .*12 more"
    ):
        events([str(RECORDS)], PAIR)
