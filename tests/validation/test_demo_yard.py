"""Demos of the container yard and of its laboratory model: fewer runs, at reduced length."""

from __future__ import annotations

import importlib
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import pytest

from rockslip import load_scene, read_run
from solver.results.runs import Run

Captured = pytest.CaptureFixture[str]

pytestmark = [pytest.mark.serial, pytest.mark.slow]

ROOT = Path(__file__).parents[2]

FEWER = {"yard": ("SHAKEN", (0, 3, 6, 11, 14)), "laboratory": ("PAIRS", (0, 2))}
"""Which runs are left of each demo: of the yard one container, four, four free, and one and four
that slide."""

SHORT = {
    "yard": [
        *("time.end=4.1", "time.step=1e-2"),
        "foundation.cells={bay=2, column=1, deck=1, storey=2}",
    ],
    "laboratory": [
        *("time.end=4.1", "time.step=1e-2", "block.cells=[1,1,2]"),
        "foundation.cells={bay=1, column=1, deck=1, storey=2}",
    ],
}
"""Coarser meshes and steps."""
MODULES = {"yard": "container_yard", "laboratory": "laboratory_model"}
CHECKS = {"yard": 7, "laboratory": 18}


def demo(name: str) -> ModuleType:
    """The script of a demo as a module, with fewer runs."""
    for package in ("dolfinx", "gmsh", "pyvista", "matplotlib"):
        pytest.importorskip(package)
    made = importlib.import_module(f"demos.{name}.{MODULES[name]}")
    attribute, kept = FEWER[name]
    whole = getattr(made, attribute)
    if len(whole) > len(kept):
        setattr(made, attribute, tuple(whole[k] for k in kept))
    return made


@pytest.fixture(scope="module", params=list(FEWER))
def left(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> tuple[str, Path]:
    """The name of a demo and the folder that its short form has left."""
    folder = tmp_path_factory.mktemp("demo") / "made" / "output"
    words = ["--output", str(folder), "--set", *SHORT[request.param]]
    assert demo(request.param).main(words) == 0
    return request.param, folder


def runs_of(folder: Path) -> list[Run]:
    """The runs of a demo, in their order."""
    files = sorted(folder.glob("*/summary.json"), key=lambda file: file.stat().st_mtime)
    return [read_run(file.parent) for file in files]


def test_its_checks_hold(left: tuple[str, Path], capsys: Captured) -> None:
    name, folder = left
    assert demo(name).show([run.folder for run in runs_of(folder)]) == 0
    said = capsys.readouterr()
    assert said.err == ""
    assert said.out.count("holds:") == CHECKS[name]
    if name == "yard":
        first = said.out.strip().splitlines()[0]
        assert first == "a run ends at 4.1 s, before its motion does at 35 s"
    assert (folder / f"{name}.png").stat().st_size > 20_000


def moved(run: Run, column: str, by: float) -> Run:
    """The run with a column of its history moved."""
    columns = {name: run.history[name] for name in run.history.columns}
    columns[column] = columns[column] + by
    return replace(run, history=columns)  # type: ignore[arg-type]


def failed(name: str, runs: list[Run]) -> list[str]:
    """The checks that fail."""
    return [line for good, line in demo(name).checks(runs) if not good]


def test_its_checks_can_fail(left: tuple[str, Path]) -> None:
    """A small change of the results fails the check that concerns them."""
    name, folder = left
    runs = runs_of(folder)
    assert failed(name, runs) == []
    if name == "laboratory":
        at = {run.label: number for number, run in enumerate(runs)}
        for label, by, seen in (
            ("rigid same density", 1e-9, 1),
            ("elastic same density", 1e-9, 0),
            ("elastic same density", 1e-6, 1),
        ):
            others = list(runs)
            size = runs[at[label]].scene.blocks[0].shape.half_diagonal
            others[at[label]] = moved(runs[at[label]], "block.slip_second_m", 1.1 * by * size)
            assert len(failed(name, others)) == seen
        return
    others = [moved(runs[0], "container1.friction_force_N", 1e6), *runs[1:]]
    assert [line for line in failed(name, others) if line.startswith("friction over mu N")]
    runs[0].summary["blocks"]["container1"]["peak_angle_rad"] = 0.1
    assert [line for line in failed(name, runs) if line.startswith("1 of 3 stacks with B/H > mu")]
    runs = runs_of(folder)
    onsets = (folder / "onsets.csv").read_text()
    try:
        (folder / "onsets.csv").write_text(onsets.replace("rock,0.3", "rock,0.33", 1))
        assert [line for line in failed(name, runs) if "min(mu, B/H)" in line]
        (folder / "onsets.csv").write_text(onsets.replace("rock,", "slide,", 1))
        assert [line for line in failed(name, runs) if line.endswith("1 do not")]
    finally:
        (folder / "onsets.csv").write_text(onsets)


def test_stacks_lift_at_b_over_h() -> None:
    """Accelerations at which stacks of one to four lift, over g."""
    one = load_scene(ROOT / "demos" / "yard" / "scene.toml").blocks[0]
    ratios = [one.width / (count * one.height) for count in (1, 2, 3, 4)]
    assert ratios == pytest.approx([0.94, 0.47, 0.31, 0.235], abs=5e-3)
