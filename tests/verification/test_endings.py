"""Runs that end as a block overturns or falls, and blocks that come to overlap: all engines."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rockslip import Result, Scene, parse_scene, read_run, simulate
from solver.cli import main
from solver.errors import Statement
from solver.history.history import History
from solver.pictures.deformed import instants
from solver.results.cautions import cautions_of_end
from solver.results.overlaps import overlaps
from solver.results.report import report

ENGINES = ("plane", "space", "meshed")

ALPHA = math.atan2(0.3, 1.0)
"""Slenderness of the block that overturns, rad."""

PLATE = {"kind": "elastic", "width": 8.0, "height": 0.2, "density": 2400.0, "support": "fixed"}
"""All of it held: a scene with it is run by the meshed engine."""


def scene(engine: str, *blocks: dict[str, Any], end: float = 1.0, **tables: Any) -> Scene:
    """Rigid blocks on what the engine has."""
    common = {"model": "rigid", "width": 0.3, "height": 1.0, "thickness": 0.4, "density": 2000.0}
    given: dict[str, Any] = {
        "dimension": 3 if engine == "space" else 2,
        "block": [common | block for block in blocks],
        "time": {"end": end, "step": 2e-3},
        "output": {"fields": "none"},
    }
    if engine == "meshed":
        given["foundation"] = PLATE | {"young": 1e10, "poisson": 0.2, "cells": [8, 1]}
    for key, value in tables.items():
        given[key] = {**given.get(key, {}), **value}
    return parse_scene(given)


def overturning(engine: str, stop: str) -> Result:
    """A block let go beyond its point of balance, and one that stands."""
    tilt = {"name": "leaning", "tilt_deg": math.degrees(1.1 * ALPHA), "offset": 2.0}
    blocks = ({"name": "standing"}, tilt)
    return simulate(scene(engine, *blocks, time={"end": 1.5, "step": 2e-3, "stop": stop}))


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
def test_a_run_ends_with_the_block_that_overturned(engine: str) -> None:
    """With the first row beyond 2 alpha; the rows up to there are those of the run that goes on."""
    ended, whole = overturning(engine, "overturned"), overturning(engine, "end")
    summary = ended.summary
    block, known = summary["blocks"]["leaning"], whole.summary["blocks"]["leaning"]
    assert ended.status == whole.status == "completed"
    assert whole.summary["reason"] == "" and whole.summary["end_s"] == pytest.approx(1.5)
    assert summary["reason"] == f"leaning overturned at t = {summary['end_s']:.6g} s"
    assert block["mode"] == "overturned"
    assert block["overturned_at_s"] == known["overturned_at_s"] == summary["end_s"]
    angle = np.abs(ended.history["leaning.angle_rad"])
    assert angle[-2] <= 2 * ALPHA < angle[-1]
    for column in ended.history.columns:
        again = whole.history[column][: len(angle)]
        np.testing.assert_array_equal(ended.history[column], again)
    # Of the run that goes on: what came before is separate from what came after.
    assert known["peak_angle_while_standing_rad"] == pytest.approx(angle[-1], rel=1e-12)
    assert known["peak_angle_rad"] > 2 * known["peak_angle_while_standing_rad"]
    assert known["peak_slip_while_standing_m"] <= known["peak_slip_m"]
    other = summary["blocks"]["standing"]
    assert other["overturned_at_s"] is None and other["fell_at_s"] is None


def test_the_fields_of_a_run_that_ends_show_its_end(tmp_path: Path) -> None:
    """The rigid engine had gone on; in the last snapshot the bodies are where the last row is."""
    import pyvista

    tilt = {"name": "leaning", "tilt_deg": math.degrees(1.1 * ALPHA)}
    time = {"end": 1.5, "step": 2e-3, "stop": "overturned"}
    given = scene("plane", tilt, time=time, output={"fields": "vtk", "every": 0.5})
    history = simulate(given, folder=tmp_path).history
    reader = pyvista.get_reader(str(tmp_path / "fields.pvd"))
    assert reader.time_values[-1] == pytest.approx(history["time_s"][-1])
    reader.set_active_time_value(reader.time_values[-1])
    mesh = reader.read()[0]
    centre = (mesh.points + mesh.point_data["displacement"]).mean(axis=0)
    assert centre[0] == pytest.approx(history["leaning.centre_x_m"][-1], abs=1e-6)
    assert centre[1] == pytest.approx(history["leaning.centre_y_m"][-1], abs=1e-6)


def thrown(engine: str, end: float = 1.0, folder: Path | None = None) -> Result:
    """A block that slides off the one that carries it."""
    velocity = [2.5, 0.0, 0.0] if engine == "space" else [2.5, 0.0]
    low = {"name": "low", "width": 1.0, "height": 0.5}
    top = {"name": "top", "on": "low", "width": 0.4, "height": 0.3, "velocity": velocity}
    return simulate(scene(engine, low, top, end=end, contact={"friction": 0.2}), folder=folder)


def test_a_picture_of_a_fall_names_it(tmp_path: Path) -> None:
    block = thrown("space", folder=tmp_path).summary["blocks"]["top"]
    assert block["overturned_at_s"] is None
    found = {instant.name: instant.time_s for instant in instants(read_run(tmp_path))}
    assert "overturned" not in found
    assert found["off its carrier"] == block["fell_at_s"]


@pytest.mark.parametrize("engine", ENGINES)
def test_a_block_that_falls_off_another_lands(engine: str) -> None:
    """It lands on the floor, or on the plate, and the run goes on."""
    result = thrown(engine)
    block = result.summary["blocks"]["top"]
    assert result.status == "completed"
    assert block["mode"] == "fell"
    up = "z" if engine == "space" else "y"
    time, height = result.history["time_s"], result.history[f"top.centre_{up}_m"]
    place, angle = result.history["top.centre_x_m"], result.history["top.angle_rad"]
    reach = 0.2 * np.abs(np.cos(angle)) + 0.15 * np.abs(np.sin(angle))
    rise = 0.15 * np.abs(np.cos(angle)) + 0.2 * np.abs(np.sin(angle))
    off = (place - reach >= 0.5) & (height - rise < 0.5) | (height + rise <= 0.5)
    assert block["fell_at_s"] == pytest.approx(float(time[np.argmax(off)]), abs=1e-12)
    assert result.summary["reason"] == "" and time[-1] == pytest.approx(1.0)
    assert (height - rise)[-1] > -1e-3


def test_it_agrees_with_the_plane_when_a_block_falls() -> None:
    """The same block, the same moment: the engines differ by less than a few steps."""
    times = [thrown(engine).summary["blocks"]["top"]["fell_at_s"] for engine in ENGINES]
    assert max(times) - min(times) <= 6e-3 + 1e-12


def runs_into(engine: str, folder: Path, lines: list[str]) -> Result:
    """One slides towards the other at 1 m/s without friction, 0.1 m away: there at 0.1 s."""
    return simulate(two(engine), folder=folder, log=lines.append)


def two(engine: str) -> Scene:
    """The scene of `runs_into`."""
    velocity = [1.0, 0.0, 0.0] if engine == "space" else [1.0, 0.0]
    gap = 0.1 if engine == "meshed" else 0.1007
    pair = {"name": "left", "velocity": velocity}, {"name": "right", "offset": 0.3 + gap}
    return scene(engine, *pair, end=0.25, contact={"friction": 0.0})


@pytest.mark.parametrize("engine", ["plane", "space"])
def test_rigid_blocks_that_run_into_each_other_meet(engine: str, tmp_path: Path) -> None:
    """A plastic impact of equal masses: m v/2, half of the energy, at the exact instant."""
    lines: list[str] = []
    result = runs_into(engine, tmp_path, lines)
    assert result.history.events is not None
    (met,) = (e for e in result.history.events if e.kind == "collision")
    assert (met.block, met.meets, met.impulse_tangential_Ns) == ("left", "right", 0.0)
    assert met.time_s == pytest.approx(0.1007, abs=1e-9)
    assert (met.velocity_before_m_s, met.velocity_after_m_s) == pytest.approx((-1.0, 0.0))
    mass = result.summary["energy"]["loss"]["contact_J"] * 4
    assert met.impulse_Ns == pytest.approx(mass / 2, rel=1e-6)
    assert met.energy_lost_J == pytest.approx(mass / 4, rel=1e-6)
    kept = json.loads((tmp_path / "summary.json").read_text())
    assert kept["overlaps"] == [] and kept["collapse"] == [] and kept["unsettled"] is None
    assert kept["first_collision"] == {"time_s": met.time_s, "between": ["left", "right"]}
    assert kept["largest_pounding"] == kept["first_collision"] | {"impulse_Ns": met.impulse_Ns}
    assert (kept["deepest_penetration_m"] or 0.0) < 1e-9  # null: they never overlap
    line = "first collision of two blocks: left meets right at 0.1007 s"
    assert line in report(result.summary) and line in lines


def test_rigid_blocks_on_a_plate_with_a_mesh_meet(tmp_path: Path) -> None:
    """A plastic impact as of the other engines, to a step."""
    lines: list[str] = []
    result = runs_into("meshed", tmp_path, lines)
    assert result.history.events is not None and result.summary["overlaps"] == []
    (met,) = (e for e in result.history.events if e.kind == "collision")
    assert (met.block, met.meets) == ("left", "right")
    assert met.time_s == pytest.approx(0.1, abs=1e-9)
    assert (met.velocity_before_m_s, met.velocity_after_m_s) == pytest.approx((-1.0, 0.0), abs=1e-6)
    mass = 0.3 * 1.0 * 0.4 * 2000.0
    assert met.impulse_Ns == pytest.approx(mass / 2, rel=1e-6)
    assert met.energy_lost_J == pytest.approx(mass / 4, rel=1e-6)
    place, time = result.history["right.centre_x_m"], result.history["time_s"]
    assert (place[-1] - place[-2]) / (time[-1] - time[-2]) == pytest.approx(0.5, rel=1e-6)


def test_blocks_that_come_to_overlap_are_told(tmp_path: Path) -> None:
    """No engine lets them; where contact is lost all the same the columns show it."""
    result = runs_into("plane", tmp_path, [])
    history = History(result.history.columns)
    rows = np.stack([result.history[name] for name in history.columns], axis=1)
    rows[:, history.columns.index("right.centre_x_m")] = 0.35
    history.extend(rows)
    (found,) = overlaps(two("plane"), history)
    assert found["blocks"] == ["left", "right"] and found["time_s"] > 0.04
    last = report(result.summary | {"overlaps": [found]}).splitlines()[-1]
    assert last.startswith("left and right overlap from t = 0.")


def test_blocks_apart_and_blocks_that_touch_are_not() -> None:
    """Side by side, exactly as wide as they are apart; a stack on one of them."""
    blocks = {"name": "a"}, {"name": "b", "offset": 0.3}, {"name": "c", "on": "b", "height": 0.5}
    assert simulate(scene("plane", *blocks, end=0.05)).summary["overlaps"] == []


def test_blocks_that_start_in_one_another_are_refused() -> None:
    blocks = {"name": "a"}, {"name": "b", "offset": 0.2}
    with pytest.raises(Statement, match=r"blocks a and b overlap by 0\.1 m at the start"):
        scene("plane", *blocks)


def test_exit_codes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """0 for a run that ended with its block, 2 for blocks in one another."""
    block = "[[block]]\nname = '{}'\nmodel = 'rigid'\nwidth = 0.3\nheight = 1.0\nmass = 9.0\n"
    time = "[time]\nend = 1.5\nstep = 2e-3\nstop = 'overturned'\n"
    lone = tmp_path / "lone.toml"
    lone.write_text(block.format("a") + "tilt_deg = 18.0\n" + time)
    assert main(["run", str(lone), "-o", str(tmp_path / "out")]) == 0
    assert "a overturned at t = " in capsys.readouterr().out.splitlines()[0]
    two = tmp_path / "two.toml"
    two.write_text(block.format("a") + block.format("b") + time)
    assert main(["check", str(two)]) == 2
    assert "blocks a and b overlap by 0.3 m at the start" in capsys.readouterr().err


def test_a_run_that_one_block_ends_says_so_of_the_others() -> None:
    low = {"name": "a", "width": 0.2, "height": 1.0, "mass": 10.0, "model": "rigid"}
    blocks = [low, low | {"name": "b", "offset": 1.0}]
    two, one = (parse_scene({"block": each, "time": {"end": 10.0}}) for each in (blocks, [low]))
    (caution,) = cautions_of_end(two, "completed", "a fell at t = 2.5 s")
    assert caution.startswith("the run ends before 10 s (a fell at t = 2.5 s)")
    assert not [*cautions_of_end(two, "completed", "")]
    assert not [*cautions_of_end(two, "interrupted", "stopped by the limit of 3 s")]
    (caution,) = cautions_of_end(one, "completed", "a fell at t = 2.5 s")
    assert caution == "a fell at t = 2.5 s: nothing catches it, and the run ends there"
    assert not [*cautions_of_end(one, "completed", "a overturned at t = 2.5 s")]
