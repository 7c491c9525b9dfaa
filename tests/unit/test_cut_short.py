"""Reports of runs that end before their motions do: they begin with that."""

from __future__ import annotations

from pathlib import Path

import pytest

from rockslip import parse_scene, simulate
from solver.cli import main
from solver.pictures.page import run_page
from solver.results.endings import cut_short
from solver.results.report import report
from solver.results.runs import read_run
from solver.study.damping.numbers import markdown
from solver.study.tables import early_ends

pytestmark = pytest.mark.serial

SCENE = """
[[block]]
model = "rigid"
width = 1.0
height = 1.0
density = 2000.0
[contact]
friction = 0.3
[motion]
kind = "sine"
amplitude_g = 0.4
period = 0.5
{cycles}
[time]
end = {end}
step = 1e-2
"""


@pytest.mark.parametrize(
    ("cycles", "end", "said"),
    [
        ("cycles = 4", 1.5, "ends at 1.5 s, before its motion does at 2 s"),
        ("cycles = 4", 2.0, ""),
        ("", 0.7, ""),  # up to the end, whenever that is
    ],
)
def test_a_run_says_first_that_its_motion_goes_on(cycles: str, end: float, said: str) -> None:
    summary = simulate(parse_scene(SCENE.format(cycles=cycles, end=end))).summary
    assert cut_short(summary) == said
    first = report(summary).splitlines()[0]
    assert first == (f"the run {said}" if said else f"completed at t = {end:g} s")


def test_without_a_motion_there_is_nothing_to_say() -> None:
    still = SCENE.format(cycles="", end=0.1).replace('"sine"', '"none"')
    still = "".join(line for line in still.splitlines(keepends=True)
                    if not line.startswith(("amplitude", "period")))  # fmt: skip
    summary = simulate(parse_scene(still)).summary
    assert cut_short(summary) == "" and "motion_end_s" not in summary


@pytest.mark.slow
def test_pages_and_tables_begin_with_it(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    said = "ends at 1.5 s, before its motion does at 2 s"
    (tmp_path / "scene.toml").write_text(SCENE.format(cycles="cycles = 4", end=1.5))
    words = ["-o", str(tmp_path / "run"), "-q"]
    assert main(["run", str(tmp_path / "scene.toml"), *words]) == 0
    (tmp_path / "pictures").mkdir()
    page = run_page(read_run(tmp_path / "run"), tmp_path / "pictures", filmed=False)
    assert f"the run {said}" in page.split("<h2>")[0]
    words = ["-o", str(tmp_path / "horizon"), "-q", "-j", "1"]
    assert main(["study", "horizon", str(tmp_path / "scene.toml"), *words]) == 0
    text = (tmp_path / "horizon" / "horizon.txt").read_text()
    assert text.splitlines()[0] == f"a run {said}"


def test_runs_of_a_table_say_it_once() -> None:
    rows = [{"cut_short": "ends at 1 s"}, {}, {"cut_short": ""}, {"cut_short": "ends at 1 s"}]
    first = early_ends(rows)
    assert first == ["a run ends at 1 s"]
    text = markdown("T", [["a"], ["1"]], [], first)
    assert text.startswith("# T\n\na run ends at 1 s\n\n| a   |")
