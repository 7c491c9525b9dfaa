"""Rigid blocks in the plane: start, rows, snapshots, and the engine of a run."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rockslip import Scene, parse_scene, simulate
from solver.history.history import scene_columns
from solver.rigid.plane import advance as plane_advance
from solver.rigid.plane import rows as plane_rows
from solver.rigid.plane.model import PlaneGround
from solver.rigid.plane.system import PlaneSystem
from solver.rigid.rows import ENERGY
from solver.run.context import RunContext
from solver.run.rigid import RigidRun

G = 9.81


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


def column(system: PlaneSystem, rows: np.ndarray, name: str) -> np.ndarray:
    """A column of rows by its name."""
    values: np.ndarray = np.atleast_2d(rows)[:, system.columns.index(name)]
    return values


def test_blocks_start_where_the_scene_has_them() -> None:
    """A tilted carrier takes along what stands on it; a velocity is that of the centre."""
    given = scene("block.tilt_deg=10", "block.velocity=[0.3, 0.1]", "small.angular_velocity=2.0")
    system = PlaneSystem.from_scene(given)
    angle = math.radians(10)
    turn = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
    for number, place in enumerate([(0.02 - 0.125, 1.05), (-0.125, 0.5)]):
        assert system.centre(number) == pytest.approx(turn @ place + (0.125, 0.0), abs=1e-15)
        assert system.angle(number) == pytest.approx(angle, rel=1e-15)
        assert system.rotation(number) == pytest.approx(turn)
    assert system.velocity(1) == pytest.approx((0.3, 0.1))
    assert system.angular_velocity(0) == 2.0


def test_the_first_row_has_the_forces_of_the_start() -> None:
    """Each carrier holds what stands on it, nothing has happened yet, and nothing does."""
    given = scene()
    system = PlaneSystem.from_scene(given)
    row = system.row(1e-3)
    assert column(system, row, "small.normal_force_N") == pytest.approx(2.0 * G)
    assert column(system, row, "block.normal_force_N") == pytest.approx(505.0 * G)
    assert column(system, row, "energy.total_J") == pytest.approx(G * (503.0 * 0.5 + 2.0 * 1.05))
    assert column(system, row, "contact_points_closed") == 4
    for name in ("energy.ledger_error_J", "block.slip_m", "platform.drift_m", "time_s"):
        assert column(system, row, name) == 0.0
    assert (system.row(1e-3) == row).all()


def test_a_released_block_starts_on_its_corner() -> None:
    """The reaction of a block at rest that begins to turn about its corner: m (g - b theta'')."""
    released = parse_scene(
        {
            "block": [
                {"width": 0.25, "height": 1.0, "mass": 503.0, "tilt_deg": 3.0, "model": "rigid"}
            ],
            "contact": {"friction": 0.7},
            "time": {"end": 1.0, "step": 1e-4},
        }
    )
    system = PlaneSystem.from_scene(released)
    shape = released.blocks[0].shape
    lean = shape.slenderness - math.radians(3.0)
    turning = shape.weight(G) * shape.half_diagonal * math.sin(lean)
    rate = turning / shape.rotary_inertia_about_corner
    lifted = shape.weight(G) - shape.mass * rate * shape.half_diagonal * math.sin(lean)
    assert column(system, system.row(1e-4), "block.normal_force_N") == pytest.approx(
        lifted, rel=1e-5
    )


def test_steps_in_pieces_are_the_same_steps() -> None:
    """To the last digit: everything that is carried over is in the system."""
    ground = np.zeros((101, 2))
    ground[:, 0] = 3.0 * np.sin(np.arange(101) / 10)
    whole, parts = PlaneSystem.from_scene(scene()), PlaneSystem.from_scene(scene())
    rows = whole.advance(100, 1e-3, ground).rows
    pieces = [parts.advance(20, 1e-3, ground[k : k + 21]).rows for k in range(0, 100, 20)]
    assert np.array_equal(rows[:, 1:], np.vstack(pieces)[:, 1:])
    assert parts.time == pytest.approx(0.1) and parts.unknowns == 7


def test_columns_are_those_of_the_history() -> None:
    """In their order, with what the ground does in all directions."""
    given = scene()
    names = PlaneSystem.from_scene(given).columns
    assert [name for name in names if name in scene_columns(given)] == list(scene_columns(given))
    blocks, run = 2 * len(plane_rows.BLOCK), len(plane_rows.RUN)
    assert len(names) == run + blocks + len(plane_rows.PLATFORM) + len(ENERGY) + 1
    assert names[-1] == "foundation.base_shear_N"


def test_a_step_that_cannot_be_solved_is_halved_and_then_given_up(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Time and reason are reported, and the rows before it are there."""
    calls = {"count": 0}

    def fails(*arguments: Any) -> int:
        calls["count"] += 1
        return 1 if calls["count"] <= 5 else -1

    interpreted = getattr(plane_rows.advance, "py_func", plane_rows.advance)
    monkeypatch.setitem(interpreted.__globals__, "full_step", fails)
    monkeypatch.setattr("solver.rigid.plane.system.advance", interpreted)
    system = PlaneSystem.from_scene(scene())
    outcome = system.advance(10, 1e-3)
    assert len(outcome.rows) == 5 and outcome.rejected == 5
    assert outcome.failure is not None and "0.005 s" in outcome.failure


def test_halving_stops_at_the_smallest_step(monkeypatch: pytest.MonkeyPatch) -> None:
    """Halves are tried down to 1/8; after each success the rest of the step in one piece."""
    tried: list[float] = []

    def piece(*arguments: Any) -> tuple[float, bool]:
        tried.append(arguments[4])
        return -1.0 if arguments[4] > accepted else arguments[4], False

    step = getattr(plane_advance.full_step, "py_func", plane_advance.full_step)
    monkeypatch.setitem(step.__globals__, "piece_of_step", piece)
    monkeypatch.setitem(step.__globals__, "finish_step", lambda *arguments: None)
    system = PlaneSystem.from_scene(scene())
    parts = (system._system, system._state, system._memory, system._work)
    ground = PlaneGround(0.0, 0.0, 0.0, 0.0)
    accepted = 0.3
    assert step(*parts, 1.0, 0.125, ground) == 5
    assert tried == [1.0, 0.5, 0.25, 0.75, 0.375, 0.1875, 0.5625, 0.28125, 0.28125]
    accepted = 0.0
    assert step(*parts, 1.0, 0.125, ground) == -1


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


@pytest.mark.parametrize("fields", ["vtk", "vtkhdf"])
def test_a_run_that_is_stopped_has_its_last_row(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fields: str
) -> None:
    """Also where that is no k-th one; the last snapshot is of that time, and it goes on from it."""
    output = "output.history_every=7", "output.every=0.04", "output.checkpoint.steps=1000"
    given = scene(*output, f'output.fields="{fields}"')
    whole = simulate(given).history
    monkeypatch.setattr(RigidRun, "_next_stop", lambda run, context, total: run._steps + 5)

    def stopped(context: RunContext, now: float) -> str:
        return "asked to" if now > 0.054 else ""

    monkeypatch.setattr(RunContext, "stopped", stopped)
    result = simulate(given, folder=tmp_path)
    assert result.status == "interrupted"
    assert result.history["time_s"][-2:] == pytest.approx([0.049, 0.055])
    assert result.summary["end_s"] == pytest.approx(0.055)
    pyvista = pytest.importorskip("pyvista")
    file = tmp_path / {"vtk": "fields.pvd", "vtkhdf": "fields.vtkhdf"}[fields]
    if fields == "vtk":
        assert pyvista.get_reader(str(file)).time_values == pytest.approx([0.0, 0.04, 0.055])
    monkeypatch.undo()
    again = simulate(given, folder=tmp_path, resume=True).history
    for name in whole.columns:
        np.testing.assert_array_equal(again[name], whole[name])


def test_snapshots_show_where_the_corners_are_and_how_they_move(tmp_path: Path) -> None:
    """Read back with pyvista: displaced corners and their velocities."""
    pyvista = pytest.importorskip("pyvista")
    given = scene("block.tilt_deg=10", "block.velocity=[0.3, 0.1]", "block.angular_velocity=2.0")
    from solver.fields.rigid_snapshots import RigidSnapshots

    fields = RigidSnapshots(PlaneSystem.from_scene(given), tmp_path, given)
    fields.write(0.0)
    block = pyvista.read(tmp_path / "fields" / "fields_block000000.vtu")
    corners = block.points + block["displacement"]
    # The right bottom corner is the pivot of the tilt.
    assert corners[1] == pytest.approx((0.125, 0.0, 0.0), abs=1e-15)
    arm = corners[1, :2] - corners[:, :2].mean(axis=0)
    turning = 2.0 * np.array([arm[1], -arm[0]])
    assert block["velocity"][1, :2] == pytest.approx(turning + np.array([0.3, 0.1]))
