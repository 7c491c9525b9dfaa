"""Modes in which blocks begin to move: rigid and elastic ones against Shenton (1996)."""

from __future__ import annotations

import argparse
import csv
import json
from pathlib import Path

import pytest

from solver.cli import main
from solver.reference.initiation import initial_accelerations, initial_mode, near_boundary
from solver.scene.scaling import Scale, scaled_tables
from solver.study.modes.cases import Onset, ramped_onset, rigid_of, scene_of, sudden_onset
from solver.study.scenes import Tables, standing_block, variant

pytestmark = pytest.mark.serial

SCENE = Path(__file__).parents[2] / "demos" / "modes" / "scene.toml"

#: A, mu, mode, theta'' and slip'' of the paper's block, H/B 4, in closed form.
POINTS = (
    (0.3, 0.2, "slide", 0.0, 0.981),
    (0.4, 0.26, "slide-rock", 0.5579, 1.0763),
    (0.4, 0.28, "slide-rock", 1.6979, 0.2688),
    (0.4, 0.295, "rock", 2.0774, 0.0),
    (0.5, 0.32, "rock", 3.4624, 0.0),
    (1.0, 0.40, "slide-rock", 9.2937, 0.7745),
    (1.0, 0.43, "rock", 10.3871, 0.0),
)


@pytest.fixture(scope="module")
def tables() -> Tables:
    return standing_block(argparse.Namespace(scene=SCENE, overrides=[]))


def with_friction(tables: Tables, friction: float) -> Tables:
    return tables | {"contact": {"friction": friction}}


@pytest.mark.parametrize(("a", "mu", "mode", "turn", "slip"), POINTS)
def test_rigid_blocks_begin_as_in_closed_form(
    tables: Tables, a: float, mu: float, mode: str, turn: float, slip: float
) -> None:
    """The first 20 ms tell theta'' and slip'' to 1e-3; the forms are those of the literature."""
    scene = variant(with_friction(tables, mu), model="rigid")
    shape = scene.blocks[0].shape
    assert initial_mode(a, mu, 4.0) == mode
    assert initial_accelerations(a, mu, shape, 9.81) == pytest.approx((turn, slip), abs=6e-5)
    found = sudden_onset(scene, a)
    assert found.mode(shape, a, 9.81) == mode
    assert (found.turn, found.slip) == pytest.approx((turn, slip), rel=1e-3, abs=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize(("a", "mu", "mode", "turn", "slip"), POINTS[::2])
def test_elastic_blocks_begin_nearly_so(
    tables: Tables, a: float, mu: float, mode: str, turn: float, slip: float
) -> None:
    """After a ramp: slide 1 %, rock 2 %, slide-rock 6 % and 0.3 m/s2.

    A rigid block under the same ramp, which has turned by as much when it is looked at, is nearer:
    0.5 %, and 0.02 m/s2.
    """
    own = variant(with_friction(tables, mu), model="elastic", time={"end": 0.08})
    found, shape = ramped_onset(own, a), own.blocks[0].shape
    assert found.mode(shape, a, 9.81) == mode
    assert found.turn == pytest.approx(turn, rel=0.02 if mode == "rock" else 0.06, abs=0.002)
    assert found.slip == pytest.approx(slip, rel=0.01, abs=0.3 if mode == "slide-rock" else 1e-4)
    beside = ramped_onset(rigid_of(own), a)
    assert found.turn == pytest.approx(beside.turn, rel=0.01, abs=0.002)
    assert found.slip == pytest.approx(beside.slip, abs=0.02)


@pytest.mark.slow
def test_what_an_elastic_block_is_off_by_is_elasticity(tables: Tables) -> None:
    """Beside a rigid one under the same ramp: less with a stiffer block, not with a finer mesh."""
    (block,) = tables["block"]

    def off(cells: list[int], young: float) -> float:
        made = with_friction(tables, 0.28) | {"block": [block | {"cells": cells, "young": young}]}
        own = scene_of(made, "elastic", 4.0)
        return ramped_onset(own, 0.4).turn / ramped_onset(rigid_of(own), 0.4).turn - 1

    coarse, middle, fine = (off(cells, 5e10) for cells in ([3, 8], [6, 16], [12, 32]))
    assert 0.001 < coarse < middle < fine < 0.005
    assert fine - middle < middle - coarse
    assert 4 * abs(off([6, 16], 5e11)) < middle < 0.5 * off([6, 16], 5e9)


@pytest.mark.parametrize("high", [1, 2, 3, 4, 5])
def test_containers_locked_one_on_another(tables: Tables, high: int) -> None:
    """Containers of 2.438 x 2.591 m, locked, uplift at .941 .470 .314 .235 .188 g."""
    keys = {"width": 2.438, "height": 2.591 * high, "mass": None, "density": 150.0}
    scene = variant(with_friction(tables, 2.0), model="rigid", **keys)
    uplift = 2.438 / (2.591 * high)
    assert uplift == pytest.approx((0.941, 0.470, 0.314, 0.235, 0.188)[high - 1], abs=5e-4)
    below, above = (sudden_onset(scene, part * uplift) for part in (0.995, 1.015))
    shape = scene.blocks[0].shape
    assert below.mode(shape, uplift, 9.81) == "rest"
    assert above.mode(shape, uplift, 9.81) == "rock"


def test_the_accelerations_are_continuous(tables: Tables) -> None:
    """At mu_R slide-rock becomes rock without a jump; inside the band a point is not judged."""
    shape = variant(tables, model="rigid").blocks[0].shape
    mu = 0.41556  # mu_R(1) of H/B 4
    below = initial_accelerations(1.0, mu - 2e-5, shape, 9.81)
    above = initial_accelerations(1.0, mu + 2e-5, shape, 9.81)
    assert below == pytest.approx(above, abs=5e-3)
    assert near_boundary(1.0, mu, 4.0, 0.03) and near_boundary(1.0, 1.02 * mu, 4.0, 0.03)
    assert not near_boundary(1.0, 1.05 * mu, 4.0, 0.03)


def test_modes_by_accelerations(tables: Tables) -> None:
    shape = variant(tables, model="rigid").blocks[0].shape
    scale = 14.2759 * 0.24254  # p^2 sin alpha
    for turn, slip, mode in (
        (0.005, 0.005, "rest"),
        (0.02, 0.005, "rock"),
        (0.005, 0.02, "slide"),
        (0.02, 0.02, "slide-rock"),
    ):
        assert Onset(turn * scale, slip * 0.5 * 9.81).mode(shape, 0.5, 9.81) == mode


def test_sizes_keep_the_half_diagonal(tables: Tables) -> None:
    """Blocks of all slendernesses have one p, the density and about the cells of the scene's."""
    own = variant(tables).blocks[0].shape
    for ratio in (1.0, 4.0, 8.0):
        block = scene_of(tables, "elastic", ratio).blocks[0]
        assert block.height / block.width == pytest.approx(ratio)
        assert block.shape.half_diagonal == pytest.approx(own.half_diagonal)
        assert block.shape.density == pytest.approx(own.density)
    assert scene_of(tables, "elastic", 4.0).blocks[0].cells == (6, 16)
    assert scene_of(tables, "elastic", 1.0).blocks[0].cells == (17, 12)


@pytest.mark.parametrize("engine", ["rigid", pytest.param("elastic", marks=pytest.mark.slow)])
def test_a_block_of_four_times_the_size_begins_alike(tables: Tables, engine: str) -> None:
    """By similarity: a quarter of theta'' and the same slip'', in times that go with 1/p."""
    scene = variant(with_friction(tables, 0.28))
    large = scaled_tables(scene, Scale(4.0), {})
    scenes = [scene_of(each, engine, 4.0) for each in (scene.to_dict(), large)]
    if engine == "rigid":
        here, there = (sudden_onset(each, 0.4) for each in scenes)
        assert (4 * there.turn, there.slip) == pytest.approx((here.turn, here.slip), rel=1e-9)
        scenes = [rigid_of(each) for each in scenes]
    here, there = (ramped_onset(each, 0.4) for each in scenes)
    exact = 1e-9 if engine == "rigid" else 1e-6
    assert (4 * there.turn, there.slip) == pytest.approx((here.turn, here.slip), rel=exact)
    assert there.mode(scenes[1].blocks[0].shape, 0.4, 9.81) == "slide-rock"


@pytest.mark.slow
def test_the_maps_of_rigid_blocks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """All points outside the band agree, on four slendernesses; nothing is run twice."""
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    words = ["study", "modes", str(SCENE), "--engines", "rigid", "--ratios", "1,2,4,8", "-q"]
    words += ["-o", "out", "-j", "1", "--points", "6"]
    assert main(words) == 0
    folder = tmp_path / "out"
    maps = json.loads((folder / "summary.json").read_text())["maps"]
    assert [found["ratio"] for found in maps] == [1, 2, 4, 8]
    for found in maps:
        assert found["points"] == 36 and 25 <= found["judged"] == found["agree"]
        for key in ("slide_slip", "rock_turn", "slide_rock_turn"):
            assert found[f"expected_{key}"] is None or found[f"expected_{key}"] < 1e-3
    with (folder / "modes.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == 144 and {row["mode"] for row in rows} >= {"rest", "slide", "rock"}
    assert (folder / "modes.png").stat().st_size > 20_000
    times = {file: file.stat().st_mtime_ns for file in (folder / "cases").iterdir()}
    assert main([*words, "--resume"]) == 0
    assert {file: file.stat().st_mtime_ns for file in (folder / "cases").iterdir()} == times


def test_without_a_material_the_map_is_that_of_rigid_blocks(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """That needs none; elastic blocks are still refused where they are asked for."""
    file = tmp_path / "scene.toml"
    lines = SCENE.read_text().replace("[[block]]", '[[block]]\nmodel = "rigid"').splitlines()
    file.write_text("\n".join(x for x in lines if not x.startswith(("young", "poisson", "cells"))))
    words = ["study", "modes", str(file), "-o", str(tmp_path / "out"), "-q", "-j", "1"]
    words += ["--points", "2"]
    assert main(words) == 0
    maps = json.loads((tmp_path / "out" / "summary.json").read_text())["maps"]
    assert [found["engine"] for found in maps] == ["rigid"]
    assert main([*words, "--force", "--engines", "rigid,elastic"]) == 2
    assert "block has no young and poisson" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--engines", "soft"], '--engines: got "soft", allowed rigid, elastic'),
        (["--ratios", "1,x"], '--ratios: got "1,x", allowed numbers > 0'),
        (["--points", "1"], "--points: got 1, allowed 2 <= points <= 200"),
        (["--set", "block.tilt_deg=1"], "block: got a block that is tilted or moves"),
        (["--set", "gravity_tilt_deg=3"], "gravity: got an incline"),
    ],
)
def test_what_is_refused(
    words: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["study", "modes", str(SCENE), "-o", str(tmp_path / "out"), *words]) == 2
    assert said in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
