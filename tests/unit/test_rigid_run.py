"""Runs of rigid scenes: their start, rows, stops and snapshots."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rigid import G

from rockslip import Scene, parse_scene, simulate
from solver.history.history import scene_columns
from solver.run.context import RunContext
from solver.run.rigid import RigidRun


def scene(*overrides: str, **tables: Any) -> Scene:
    """The paper's block on a platform, a small one on it."""
    blocks: list[dict[str, Any]] = [
        {"name": "small", "on": "block", "width": 0.1, "height": 0.1, "mass": 2.0, "offset": 0.02},
        {"name": "block", "width": 0.25, "height": 1.0, "mass": 503.0},
    ]
    given = {
        "block": [block | {"model": "rigid"} for block in blocks],
        "foundation": {"kind": "oscillator", "mass_ratio": 2.0, "period": 0.5},
        "motion": {"kind": "sine", "amplitude_g": 0.1, "period": 0.5},
        "contact": {"friction": 0.7},
        "time": {"end": 0.1, "step": 1e-3},
    }
    return parse_scene(given | tables, overrides=overrides)


def test_blocks_start_where_the_scene_has_them() -> None:
    """A tilted carrier takes along what stands on it."""
    history = simulate(scene("block.tilt_deg=10", "small.angular_velocity=2.0")).history
    angle = math.radians(10)
    turn = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
    for name, place in {"small": (0.02 - 0.125, 1.05), "block": (-0.125, 0.5)}.items():
        found = [history[f"{name}.centre_{axis}_m"][0] for axis in "xy"]
        assert found == pytest.approx(turn @ place + (0.125, 0.0), abs=1e-15)
        assert history[f"{name}.angle_rad"][0] == pytest.approx(angle, rel=1e-14)
    assert history["small.angular_velocity_rad_s"][0] == 2.0


def test_blocks_start_where_the_scene_has_them_in_space() -> None:
    """On the edge at y = 0.15, leaning towards +y, on a block that a platform carries."""
    top = {"name": "top", "on": "lower", "width": 0.2, "height": 0.5, "thickness": 0.3}
    top |= {"mass": 10.0, "tilt_deg": 4.0, "tilt_direction_deg": 90.0, "offset": 0.1}
    lower = {"name": "lower", "width": 1.0, "height": 0.25, "thickness": 1.0, "mass": 50.0}
    blocks = [block | {"model": "rigid"} for block in (top, lower)]
    history = simulate(scene(dimension=3, block=blocks, motion={"kind": "none"})).history
    lean = math.radians(4.0)
    along = 0.15 - 0.15 * math.cos(lean) + 0.25 * math.sin(lean)
    above = 0.25 + 0.15 * math.sin(lean) + 0.25 * math.cos(lean)
    found = [history[f"top.centre_{axis}_m"][0] for axis in "xyz"]
    assert found == pytest.approx([0.1, along, above], abs=1e-14)
    assert history["top.gap_3_m"][0] == pytest.approx(0.0, abs=1e-14)
    assert history["top.gap_1_m"][0] == pytest.approx(0.3 * math.sin(lean))
    assert history["lower.normal_force_N"][0] == pytest.approx(60 * G, rel=0.1)


def test_the_first_row_has_the_forces_of_the_start() -> None:
    """Each carrier holds what stands on it, and nothing has happened yet."""
    given = scene()
    history = simulate(given).history
    assert list(history.columns) == list(scene_columns(given))
    assert history["small.normal_force_N"][0] == pytest.approx(2.0 * G)
    assert history["block.normal_force_N"][0] == pytest.approx(505.0 * G)
    assert history["energy.total_J"][0] == pytest.approx(G * (503.0 * 0.5 + 2.0 * 1.05))
    assert history["contact_points_closed"][0] == 4
    for name in ("energy.ledger_error_J", "block.slip_m", "platform.drift_m", "time_s"):
        assert history[name][0] == 0.0


def test_a_run_writes_what_a_run_writes(tmp_path: Path) -> None:
    """Every k-th row and the last, a shorter last step, snapshots of all bodies."""
    given = scene(
        "time.end=0.1005", "output.history_every=7", "output.every=0.04", "block.tilt_deg=1.0"
    )
    result = simulate(given, folder=tmp_path)
    assert result.status == "completed"
    times = result.history["time_s"]
    assert times[:3] == pytest.approx([0.0, 0.007, 0.014])
    assert times[-2:] == pytest.approx([0.098, 0.1005])
    assert result.history["step_s"][-1] == pytest.approx(5e-4)
    # That step feels the ground as all others do: as in half of the steps, which end there.
    halves = simulate(scene("time.end=0.1005", "time.step=5e-4", "block.tilt_deg=1.0")).history
    for name in ("base.acceleration_m_s2", "platform.velocity_m_s", "block.angular_velocity_rad_s"):
        apart = result.history[name][-1] - halves[name][-1]
        assert abs(apart) < 2e-3 * np.abs(halves[name]).max()
    assert result.summary["cost"]["steps"] == 101
    index = (tmp_path / "fields.pvd").read_text()
    for name in ("small", "block", "platform"):
        # at 0, 0.04, 0.08 and the end
        assert index.count(f'name="{name}" file="fields/fields_{name}') == 4
    assert (tmp_path / "open_in_paraview.py").is_file()


def test_a_run_that_is_stopped_has_its_last_row(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also where that is no k-th one; the last snapshot is of that time, and it goes on from it."""
    output = "output.history_every=7", "output.every=0.04", "output.checkpoint.steps=1000"
    given = scene(*output)
    whole = simulate(given).history
    monkeypatch.setattr(RigidRun, "_next_stop", lambda run, context, due: run.steps + 5)

    def stopped(context: RunContext, now: float) -> str:
        return "asked to" if now > 0.054 else ""

    monkeypatch.setattr(RunContext, "stopped", stopped)
    result = simulate(given, folder=tmp_path)
    assert result.status == "interrupted"
    assert result.history["time_s"][-2:] == pytest.approx([0.049, 0.055])
    assert result.summary["end_s"] == pytest.approx(0.055)
    pyvista = pytest.importorskip("pyvista")
    reader = pyvista.get_reader(str(tmp_path / "fields.pvd"))
    assert reader.time_values == pytest.approx([0.0, 0.04, 0.055])
    monkeypatch.undo()
    again = simulate(given, folder=tmp_path, resume=True).history
    for name in whole.columns:
        np.testing.assert_array_equal(again[name], whole[name])


def test_snapshots_show_where_the_corners_are_and_how_they_move(tmp_path: Path) -> None:
    """Read back with pyvista: displaced corners and their velocities."""
    pyvista = pytest.importorskip("pyvista")
    moving = "block.tilt_deg=10", "block.velocity=[0.3, 0.1]", "block.angular_velocity=2.0"
    simulate(scene(*moving, "time.end=0.01", "output.every=0.01"), folder=tmp_path)
    block = pyvista.read(tmp_path / "fields" / "fields_block000000.vtu")
    corners = block.points + block["displacement"]
    # The right bottom corner is the pivot of the tilt.
    assert corners[1] == pytest.approx((0.125, 0.0, 0.0), abs=1e-15)
    arm = corners[1, :2] - corners[:, :2].mean(axis=0)
    turning = 2.0 * np.array([arm[1], -arm[0]])
    assert block["velocity"][1, :2] == pytest.approx(turning + np.array([0.3, 0.1]))
