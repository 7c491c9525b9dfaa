"""The study of a suite: what it runs, writes, refuses, and does again after an interruption."""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from processes import python

from rockslip import load_scene
from solver.cli import build_parser, main
from solver.errors import SceneError
from solver.study.pool import CaseProgress
from solver.study.suite.cases import SuiteStudy, variations
from solver.study.suite.motions import find_motions
from solver.study.suite.numbers import as_text, ratios

pytestmark = pytest.mark.serial

ROOT = Path(__file__).parents[2]

SCENE = """
[[block]]
width = 1.0
height = 0.5
thickness = 1.0
mass = 1000.0
model = "rigid"
[foundation]
kind = "oscillator"
mass_ratio = 2.0
period = 0.5
damping_ratio = 0.05
[contact]
friction = 0.2
[motion]
kind = "table"
file = "none of these"
scale = 2.0
[time]
end = 100.0
step = 2.0e-3
"""

Captured = pytest.CaptureFixture[str]


def write_motion(file: Path, amplitude: float, end: float = 1.0) -> None:
    time = np.arange(0.0, end + 0.005, 0.01)
    value = amplitude * np.sin(2 * np.pi * time / 0.6)
    file.write_text(
        "time,a\n" + "".join(f"{t:.2f},{a!r}\n" for t, a in zip(time, value.tolist(), strict=True))
    )


def furnish(folder: Path) -> Path:
    """A scene and three motions, of which one is bad."""
    (folder / "scene.toml").write_text(SCENE)
    motions = folder / "motions"
    motions.mkdir()
    write_motion(motions / "strong.csv", 0.2)
    write_motion(motions / "weak.csv", 0.05, end=0.5)
    (motions / "bad.csv").write_text("time,a\n0.0,0.1\n0.01,nan\n")
    (motions / "index.csv").write_text("what,these,are\n")
    return folder


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, furnished."""
    monkeypatch.chdir(tmp_path)
    return furnish(tmp_path)


def suite(*words: str) -> int:
    return main(["study", "suite", "scene.toml", "--motions", "motions", "-j", "2", *words])


def table(folder: Path) -> dict[tuple[str, str], dict[str, str]]:
    """The rows of a table by motion and friction."""
    with (folder / "suite.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    return {(row["motion"], row.get("contact.friction", "")): row for row in rows}


@pytest.mark.slow
def test_all_motions_with_all_values(here: Path, capsys: Captured) -> None:
    """The bad motion alone fails, by name; the others are what single runs give; then resumed."""
    words = ("--vary", "contact.friction=0.1,0.3", "--reference", "--tail", "0.25", "-o", "out")
    assert suite(*words) == 3
    rows = table(here / "out")
    assert [key for key in rows] == [
        (motion, friction) for friction in ("0.1", "0.3") for motion in ("bad", "strong", "weak")
    ]
    for friction in ("0.1", "0.3"):
        bad = rows["bad", friction]
        assert bad["status"] == "failed"
        assert "bad.csv: line 3" in bad["reason"] and bad["steps"] == ""
        strong, weak = rows["strong", friction], rows["weak", friction]
        assert (strong["status"], weak["status"]) == ("completed", "completed")
        assert float(strong["end_s"]) == pytest.approx(1.25)
        assert float(weak["end_s"]) == pytest.approx(0.75)
        assert (strong["steps"], weak["steps"]) == ("625", "375")
        assert float(strong["pga_g"]) == pytest.approx(0.4, rel=1e-3)  # scale = 2
        ratio = float(strong["platform.peak_drift_ratio"])
        drift, exact = (float(strong[f"{of}platform.peak_drift_m"]) for of in ("", "reference."))
        assert ratio == pytest.approx(drift / exact) == pytest.approx(1.0, abs=2e-3)
    strong = rows["strong", "0.1"]
    assert strong["block.mode"] == "slide"
    assert strong["block.peak_displacement_m"] == strong["block.peak_slip_m"]  # nothing flew
    assert (here / "out" / "suite.png").stat().st_size > 10_000
    _is_a_single_run(here, rows["strong", "0.1"])
    _says_it_all(here, capsys.readouterr().out)
    _resumes(here, rows, words)


def _is_a_single_run(here: Path, row: dict[str, str]) -> None:
    from rockslip import simulate

    motion = ["motion.file=motions/strong.csv", "contact.friction=0.1", "time.end=1.25"]
    summary = simulate(load_scene(here / "scene.toml", motion)).summary
    assert float(row["platform.peak_drift_m"]) == summary["platform"]["peak_drift_m"]
    for key in ("peak_slip_m", "residual_slip_m", "peak_angle_rad"):
        assert float(row[f"block.{key}"]) == summary["blocks"]["block"][key]
    for key in ("largest_gain_fraction", "ledger_error_fraction"):
        assert float(row[key]) == summary["energy"][key]


def _says_it_all(here: Path, said: str) -> None:
    text = (here / "out" / "suite.txt").read_text()
    assert said.startswith(text)
    assert "4 of 6 completed; written to out" in said
    assert "bad, contact.friction 0.1: failed: " in text
    assert "contact.friction 0.3, platform.peak_drift_ratio: mean " in text
    summary = json.loads((here / "out" / "summary.json").read_text())
    assert (summary["cases"], summary["completed"], summary["failed"]) == (6, 4, 2)
    drift = [mean for mean in summary["ratios"] if mean["ratio"] == "platform.peak_drift_ratio"]
    assert [mean["varied"] for mean in drift] == [
        {"contact.friction": "0.1"}, {"contact.friction": "0.3"}
    ]  # fmt: skip
    assert all(mean["count"] == 2 for mean in drift)


def _resumes(here: Path, rows: dict[tuple[str, str], dict[str, str]], words: Any) -> None:
    """Only what is missing is done; failed cases are tried again; others are refused."""
    cases = here / "out" / "cases"
    missing = cases / "weak__contact.friction=0.3.json"
    missing.unlink()
    before = {file.name: file.stat().st_mtime_ns for file in cases.iterdir()}
    assert suite(*words, "--resume", "-q") == 3
    after = {file.name: file.stat().st_mtime_ns for file in cases.iterdir()}
    changed = {name for name in after if after[name] != before.get(name)}
    assert changed == {missing.name, *(name for name in after if name.startswith("bad"))}
    again = table(here / "out")
    for key, row in rows.items():
        assert {k: v for k, v in row.items() if k != "wall_s"} == {
            k: v for k, v in again[key].items() if k != "wall_s"
        }


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ((), "-o: got out, which is not empty, allowed an empty folder, --force, or --resume"),
        (("--resume", "--set", "contact.friction=0.3"), "another scene.contact.friction,"),
        (("--resume", "--motions", "motions/weak.csv"), "made with another motions.weak_2,"),
        (("--vary", "contact.friction=0.1,-1"), "contact.friction: got -1"),
        (("--vary", "contact.friction"), '--vary: got "contact.friction", allowed KEY='),
        (("--vary", "contact.friction=1", "contact.friction=2"), "each name and value once"),
        (("--motions", "@nowhere"), "--motions: got @nowhere (no such file"),
        (("--motions", "empty"), "--motions: got empty without any, allowed files .at2"),
        (("--count", "3"), "--count: got 3, allowed nothing without --motions synthetic"),
        (("--tail", "-1"), "--tail: got -1, allowed 0 <= tail"),
        (("--reference", "--set", "dimension=3"), "dimension: got 3, allowed 2 where a rigid"),
    ],
)
def test_it_refuses(
    done: Path, monkeypatch: pytest.MonkeyPatch, capsys: Captured, words: tuple[str, ...], said: str
) -> None:
    """One line, exit code 2, and nothing is touched."""
    monkeypatch.chdir(done)
    before = {file: file.stat().st_mtime_ns for file in (done / "out").rglob("*")}
    assert suite("-o", "out", *words) == 2
    line = capsys.readouterr().err
    assert said in line and line.startswith("rockslip: ") and line.count("\n") == 1
    assert {file: file.stat().st_mtime_ns for file in (done / "out").rglob("*")} == before


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A furnished folder with a suite in it, of which nothing has been run."""
    folder = furnish(tmp_path_factory.mktemp("done"))
    (folder / "empty").mkdir()
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        words = ["study", "suite", "scene.toml", "--motions", "motions", "-o", "out"]
        SuiteStudy(build_parser().parse_args(words)).claimed()
    return folder


def command(folder: Path, *words: str) -> list[str]:
    """The study as a process of its own."""
    study = ["study", "suite", str(folder / "scene.toml"), "--motions", str(folder / "motions")]
    return [sys.executable, "-m", "solver", *study, *words]


def environment() -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(ROOT)}


def test_an_interruption_keeps_what_is_finished(tmp_path: Path) -> None:
    """Ctrl-C in the middle: exit code 130 at once, a table of what is done, none half done."""
    furnish(tmp_path)
    write_motion(tmp_path / "motions" / "zz_long.csv", 0.2, end=2000.0)
    words = ("-j", "1", "-o", str(tmp_path / "out"), "-q", "--keep")
    run = subprocess.Popen(command(tmp_path, *words), env=environment(), start_new_session=True)
    cases = tmp_path / "out" / "cases"
    deadline = time.monotonic() + 120
    while not (cases / "weak.json").exists() and time.monotonic() < deadline:
        time.sleep(0.02)
    os.killpg(run.pid, signal.SIGINT)
    assert run.wait(timeout=120) == 130
    assert {file.name for file in cases.iterdir()} == {"bad.json", "strong.json", "weak.json"}
    rows = table(tmp_path / "out")
    assert [row["status"] for row in rows.values()] == ["failed", "completed", "completed"]
    kept = {file.name for file in (tmp_path / "out" / "runs" / "strong").iterdir()}
    assert kept >= {"history.csv", "summary.json", "scene.toml", "fields.pvd"}


@pytest.mark.mpi
def test_the_same_command_on_ranks(tmp_path: Path) -> None:
    """Two ranks: the table of the serial run."""
    furnish(tmp_path)
    assert main(command(tmp_path, "-o", str(tmp_path / "serial"), "-q")[3:]) == 3
    words = command(tmp_path, "-o", str(tmp_path / "ranks"))[1:]
    done = python(*words, ranks=2)
    assert done.returncode == 3, done.stderr
    assert done.stdout.count("2 of 3 completed") == 1
    one, other = table(tmp_path / "serial"), table(tmp_path / "ranks")
    for rows in (one, other):
        for row in rows.values():
            row.pop("wall_s")
    assert one == other
    refused = python(*words, ranks=2)
    assert refused.returncode == 2
    assert refused.stderr.count("rockslip: -o: got ") == 1


def test_variations_are_all_combinations() -> None:
    assert list(variations([])) == [()]
    found = list(variations(["a.b=1,2", "c=x"]))
    assert found == [(("a.b", "1"), ("c", "x")), (("a.b", "2"), ("c", "x"))]


def test_motions_are_found_in_all_ways(here: Path) -> None:
    """Folders, files, lists; each has a name of its own; the scene says the rest."""
    (here / "list.txt").write_text("# two\nmotions/weak.csv\n\nmotions/strong.csv  # last\n")
    words = ["motions", "motions/weak.csv", "@list.txt"]
    found, notes = find_motions(words, {"kind": "sine", "period": 1.0}, count=None, seed=None)
    assert [motion.name for motion in found] == [
        "bad", "strong", "weak", "weak_2", "weak_3", "strong_2"
    ]  # fmt: skip
    assert notes == ["motions shake along x", "not taken over from the scene: motion.period"]
    assert {motion.table["kind"] for motion in found} == {"record"}
    assert found[2].table["file"] == found[4].table["file"] == str(here / "motions" / "weak.csv")
    own = {"kind": "table", "units": "m/s2", "file": "x"}
    (only,), _ = find_motions(["motions/bad.csv"], own, count=None, seed=None)
    assert only.table == own | {"file": str(here / "motions" / "bad.csv")}
    (only,), _ = find_motions(["motions/bad.csv"], {"units": "g"}, count=None, seed=None)
    assert (only.table["kind"], only.table["units"]) == ("record", "g")
    (here / "list.txt").write_text("motions/weak.csv\nmotions/week.csv\n")
    with pytest.raises(SceneError, match=r"list\.txt: line 2: got motions/week"):
        find_motions(["@list.txt"], None, count=None, seed=None)


def test_means_of_ratios_by_hand() -> None:
    rows = [
        {"motion": "a", "mu": "0.1", "status": "completed", "platform.peak_drift_ratio": 0.9},
        {"motion": "b", "mu": "0.1", "status": "completed", "platform.peak_drift_ratio": 1.2},
        {"motion": "c", "mu": "0.1", "status": "failed", "reason": "broken"},
        {"motion": "a", "mu": "0.2", "status": "completed", "platform.peak_drift_ratio": 1.0},
    ]
    first, second = ratios(rows, ["mu"])
    assert (first["varied"], first["count"]) == ({"mu": "0.1"}, 2)
    assert (first["mean"], first["least"], first["largest"]) == pytest.approx((1.05, 0.9, 1.2))
    assert first["deviation"] == pytest.approx(0.15)
    assert (second["mean"], second["deviation"], second["count"]) == (1.0, 0.0, 1)
    text = as_text(rows, ["mu"]).splitlines()
    assert text[0].split() == ["motion", "mu", "status", "ratio"]
    assert text[3].split() == ["c", "0.1", "failed", "-"]
    assert "mu 0.1, platform.peak_drift_ratio: mean 1.0500, deviation 0.1500" in text[6]
    assert text[-1] == "c, mu 0.1: failed: broken"
    doubtful = [{**rows[0], "cautions": f"odd {number}"} for number in range(12)]
    lines = as_text(doubtful, ["mu"]).splitlines()
    assert lines[-2:] == ["a, mu 0.1: caution: odd 9", "2 more cases have cautions: see suite.csv"]


def test_the_tally_says_how_long_it_takes(capsys: Captured, monkeypatch: Any) -> None:
    now = iter([0.0, 1.0, 3.0, 4.0, 4.0, 4.0])
    shared = SimpleNamespace(monotonic=lambda: next(now))
    monkeypatch.setattr("solver.run.progress.clock", shared)
    monkeypatch.setattr("solver.study.pool.clock", shared)
    progress = CaseProgress(5, done=2)
    for name in ("c", "d", "e"):
        progress.add(name)
    progress.close()
    assert capsys.readouterr().err.splitlines() == [
        "4 of 5 (d), 3 s spent, 2 s left", "5 of 5 (e), 4 s spent, 0 s left"
    ]  # fmt: skip
    CaseProgress(1, rank=1).add("a")
    CaseProgress(1, quiet=True).add("a")
    assert capsys.readouterr().err == ""
