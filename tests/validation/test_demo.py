"""The demo of free rocking, at reduced length, through the functions of its script."""

from __future__ import annotations

import importlib
import json
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from solver.errors import RockslipError

Captured = pytest.CaptureFixture[str]

pytestmark = [pytest.mark.serial, pytest.mark.slow]


@pytest.fixture(scope="module")
def demo() -> ModuleType:
    for package in ("dolfinx", "gmsh", "pyvista", "matplotlib"):
        pytest.importorskip(package)
    return importlib.import_module("demos.free_rocking.free_rocking")


@pytest.fixture(scope="module")
def folder(demo: ModuleType, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The demo's scene up to 0.95 s, run: three impacts."""
    scene = demo.load_scene(demo.SCENE)
    short = replace(scene, time=replace(scene.time, end=0.95))
    target: Path = tmp_path_factory.mktemp("demo") / "output"
    demo.rock(short, target)
    return target


def test_the_scene_is_the_paper_s(demo: ModuleType) -> None:
    scene = demo.load_scene(demo.SCENE)
    block = scene.blocks[0]
    assert (block.width, block.height, block.thickness, block.mass) == (0.25, 1.0, 0.75, 503.0)
    assert (block.young, block.poisson, block.cells, block.tilt_deg) == (5e10, 0.2, (6, 16), 3.0)
    assert (scene.plane, scene.contact.friction, scene.contact.points) == ("strain", 0.7, "nodes")
    assert (scene.time.end, scene.time.adaptive, scene.time.rho_inf) == (3.0, True, 0.8)
    assert scene.damping is None
    assert block.damping == scene.default_damping(block)


@pytest.mark.parametrize(
    ("restitution", "expected"),
    [
        ((), [0.1916, 0.5305, 0.8323, 1.1024, 1.3451, 1.5637, 1.7612]),
        ((0.936,), [0.1916, 0.5423, 0.8644, 1.1612, 1.4353]),
    ],
)
def test_what_it_compares_with_is_housner_s_block(
    demo: ModuleType, restitution: tuple[float, ...], expected: list[float]
) -> None:
    """Impacts of the nonlinear equation by an independent program."""
    reference = demo.rigid(demo.load_scene(demo.SCENE), *restitution)
    assert reference.impacts[: len(expected)] == pytest.approx(expected, abs=6e-5)


def test_its_checks_hold(demo: ModuleType, folder: Path, capsys: Captured) -> None:
    assert demo.show(folder, []) == 0
    output = capsys.readouterr()
    assert output.err == ""
    # status, three impacts, spread, damping, gain, ledger, slip
    assert output.out.count("holds:") == 9
    assert "0.1916" in output.out
    names = {file.name for file in folder.iterdir()}
    assert names > {
        "history.csv", "summary.json", "scene.toml", "run.log", "fields.pvd", "open_in_paraview.py",
        "angle.png", "phase.png", "forces.png", "energy.png", "deformed.png", "free_rocking.png",
    }  # fmt: skip
    # one for docs/pictures: it has to stay small
    assert (folder / "free_rocking.png").stat().st_size < 200_000


@pytest.mark.parametrize(
    ("spoiled", "value", "word"),
    [
        ("blocks.block.impacts.0.time_s", 0.1921, "impact 1 at 0.1921 s"),
        ("blocks.block.impacts", [], "no impact until"),
        ("blocks.block.impacts.1.restitution", 0.95, "differ by 0.01"),
        ("blocks.block.residual_slip_m", -0.0021, "slip -2.10 mm"),
        ("energy.largest_gain_fraction", 2e-6, "gain 2.0e-06"),
        ("energy.ledger_error_fraction", 2e-8, "ledger error 2.0e-08"),
        ("energy.loss_share.damping", 0.5, "50% of the loss"),
        ("status", "interrupted", "interrupted"),
    ],
)
def test_each_check_can_fail(
    demo: ModuleType, folder: Path, capsys: Captured, spoiled: str, value: Any, word: str
) -> None:
    """One clear line, and an exit code that is not zero."""
    run = demo.read_run(folder)
    *path, last = spoiled.split(".")
    table: Any = run.summary
    for name in path:
        table = table[int(name) if name.isdigit() else name]
    table[last] = value
    matched = demo.rigid(run.scene, demo.MEASURED)
    assert demo.verdict("free_rocking", demo.checks(run, matched)) == 1
    line = capsys.readouterr().err
    assert line.startswith("free_rocking: check failed: ")
    assert line.count("\n") == 1
    assert word in line


def test_other_steps_and_damping_stand_beside_it(
    demo: ModuleType, folder: Path, capsys: Captured, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The first impact does not depend on either; the tables and the overlay are made."""
    chosen = {name: demo.VARIANTS[name] for name in ("fixed steps of 1 ms", "default")}
    short = {name: (*changes, "time.end=0.21") for name, changes in chosen.items()}
    monkeypatch.setattr(demo, "VARIANTS", short)
    folders = demo.variants(folder)
    assert demo.show(folder, folders) == 0
    text = capsys.readouterr().out
    assert (folder / "overlay.png").is_file()
    for name in folders:
        impacts = json.loads((name / "summary.json").read_text())["blocks"]["block"]["impacts"]
        assert impacts[0]["time_s"] == pytest.approx(0.19163, rel=2e-3)
        assert not list(name.glob("fields*"))
        assert f"\n{name.name:26} " in text


def test_a_second_run_takes_the_place_of_the_first(demo: ModuleType, tmp_path: Path) -> None:
    scene = demo.load_scene(demo.SCENE)
    shorter = replace(scene, time=replace(scene.time, end=0.004))
    (tmp_path / "mine.txt").write_text("mine")
    (tmp_path / "fields000009.pvtu").write_text("of an earlier run")
    for _ in range(2):
        demo.rock(shorter, tmp_path)
    assert not (tmp_path / "fields000009.pvtu").exists()
    assert (tmp_path / "mine.txt").read_text() == "mine"
    time = demo.read_run(tmp_path).history["time_s"]
    assert (time[1:] > time[:-1]).all() and time[-1] == pytest.approx(0.004, abs=1e-6)


def test_it_never_runs_into_the_folder_of_its_scene(demo: ModuleType) -> None:
    with pytest.raises(RockslipError, match="holds the scene itself"):
        demo.rock(demo.load_scene(demo.SCENE), demo.HERE)


def test_a_demo_that_cannot_write_says_so(
    demo: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Captured
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setattr(demo, "OUTPUT", tmp_path / "file" / "output")
    monkeypatch.setattr(sys, "argv", ["free_rocking.py"])
    assert demo.main() == 2
    line = capsys.readouterr().err
    assert line.startswith("free_rocking: ") and line.count("\n") == 1
