"""Rigid blocks in space that spin, alone and among meshed ones: closed forms, an ODE, the engines.

A scene with a meshed block has rigid ones of an engine of its own.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rigid
from ledger import completed
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from rockslip import History, Result, parse_scene, simulate

Array = NDArray[np.float64]

TALL = {"name": "tall", "model": "rigid", "width": 0.4, "thickness": 0.3, "height": 1.0}
TALL |= {"density": 2400.0}
WEIGHT = 0.4 * 0.3 * 1.0 * 2400.0 * 9.81
LOW = TALL | {"name": "low", "width": 0.8, "thickness": 0.7, "height": 0.4}
STONE = {"young": 5e10, "poisson": 0.2}
PEBBLE = TALL | STONE | {"name": "pebble", "model": "elastic", "height": 0.2, "offset": 3.0}
PEBBLE |= {"cells": [1, 1, 1]}
"""A meshed block far away makes a scene a mixed one."""
LEANING = {"tilt_deg": 3.0, "tilt_direction_deg": 30.0}
OVERHANGING = {"on": "low", "offset": 0.45, "offset_second": 0.1, "width": 0.8, "height": 0.4}
PLATE = {
    "kind": "elastic",
    "width": 1.6,
    "thickness": 1.4,
    "height": 0.2,
    "density": 2400.0,
    "support": "bottom",
    "cells": [4, 4, 1],
    **STONE,
}


def run(*blocks: dict[str, Any], end: float, folder: Path | None = None, **tables: Any) -> Result:
    """A run that goes to its end, gains no energy and accounts for all of it."""
    quiet = {"damping": {"stiffness": 0.0}, "output": {"fields": "none"}}
    given = rigid.scene(3, *blocks, end=end, friction=0.5, **(quiet | tables))
    return completed(given, gain=1e-5, ledger=1e-8, folder=folder)


def spinning(spin: tuple[float, ...], end: float) -> History:
    """Motion of a square block that spins without gravity, in default steps."""
    size = {"model": "rigid", "width": 0.3, "thickness": 0.3, "height": 0.5, "density": 2000.0}
    thrown = size | {"velocity": [0.0, 0.0, 20.0], "angular_velocity": list(spin)}
    scene = {"dimension": 3, "gravity": 0.0, "block": [thrown], "time": {"end": end}}
    return simulate(parse_scene(scene)).history


def spins(history: History, name: str) -> Array:
    """Angular velocities, rad/s, (rows, 3)."""
    return np.stack([history[f"{name}.angular_velocity_{axis}_rad_s"] for axis in "xyz"], axis=1)


@pytest.mark.parametrize("end", [2.0, 20.0])
def test_default_steps_see_what_spins(end: float) -> None:
    """They were a hundredth of the run."""
    found = spinning((0.0, 0.0, 20.0), end)
    assert found["block.angle_z_rad"] == pytest.approx(20.0 * found["time_s"], rel=1e-5)


def test_default_steps_see_a_top_that_turns_about_its_momentum() -> None:
    """At the rate L/J of its moment of inertia across the axis, without torque."""
    found, across, along = spinning((6.0, 0.0, 12.0), 2.0), 0.3**2 + 0.5**2, 2 * 0.3**2
    momentum = np.array([across * 6.0, 0.0, along * 12.0])
    size = float(np.linalg.norm(momentum))
    spin = spins(found, "block")
    aside = spin - np.outer(spin @ momentum, momentum) / size**2
    turned = np.unwrap(np.arctan2(aside @ np.cross(momentum / size, aside[0]), aside @ aside[0]))
    assert turned == pytest.approx(size / across * found["time_s"], rel=2e-5, abs=1e-9)


SPIN = np.array([0.3, 5.0, 1.0])
"""About the axis of the middle moment of inertia, and a little beside it: unstable."""


def exact_turn(inertia: Array, end: float) -> tuple[Array, Array]:
    """Rotation and angular velocity in space by Euler's equations.

    J dW/dt = J W x W, dQ/dt = Q (0, W)/2 for the quaternion Q (x, y, z, w).
    """

    def rate(_: float, y: Array) -> Array:
        spin, (x, q) = y[:3], (y[3:6], y[6])
        turning = np.append(q * spin + np.cross(x, spin), -(x @ spin)) / 2
        return np.append(np.cross(inertia * spin, spin) / inertia, turning)

    found = solve_ivp(rate, (0, end), [*SPIN, 0, 0, 0, 1], "DOP853", rtol=1e-12, atol=1e-12)
    turn = Rotation.from_quat(found.y[3:, -1])
    return turn.as_matrix(), turn.apply(found.y[:3, -1])


@pytest.mark.parametrize("pebble", ["rigid", "elastic"])
def test_free_spinning(pebble: str) -> None:
    """Energy and angular momentum stay what they are; the motion is of second order."""
    brick = {"name": "brick", "model": "rigid", "width": 0.3, "thickness": 0.5, "height": 1.0}
    brick |= {"density": 2000.0, "velocity": [0.0, 0.0, 5.0], "angular_velocity": SPIN.tolist()}
    square = np.array([0.3, 0.5, 1.0]) ** 2
    inertia = 300.0 / 12 * (square.sum() - square)  # 300 kg
    errors = []
    for dt in (2e-3, 1e-3):
        time = {"end": 0.4, "step": dt}
        found = run(brick, PEBBLE | {"model": pebble}, end=0.4, gravity=0.0, time=time).history
        angles = np.stack([found[f"brick.angle_{axis}_rad"] for axis in "xyz"], axis=1)
        turns, spin = Rotation.from_rotvec(angles), spins(found, "brick")
        kept = turns.apply(inertia * turns.inv().apply(spin))
        size = np.linalg.norm(inertia * SPIN)
        assert np.abs(kept - inertia * SPIN).max() < 1e-9 * size
        assert np.ptp(found["energy.kinetic_J"]) < 1e-10 * found["energy.kinetic_J"][0]
        turn, last = exact_turn(inertia, 0.4)
        errors.append((np.abs(turns[-1].as_matrix() - turn).max(), np.abs(spin[-1] - last).max()))
    (turn_error, spin_error), (finer_turn, finer_spin) = errors
    assert 3.9 < turn_error / finer_turn < 4.1
    assert 3.9 < spin_error / finer_spin < 4.1
    assert finer_turn < 5e-5


def differences(one: Result, other: Result, name: str) -> tuple[Array, Array]:
    """Times of both runs (s), and the largest difference of angles (rad) and places (m) then."""
    columns = [f"{name}.angle_{axis}_rad" for axis in "xyz"]
    columns += [f"{name}.centre_{axis}_m" for axis in "xyz"]
    times = [np.round(result.history["time_s"], 9) for result in (one, other)]
    time, *rows = np.intersect1d(*times, return_indices=True)
    assert len(time) == min(map(len, times))
    places = (
        np.array([result.history[column][row] for column in columns])
        for result, row in zip((one, other), rows, strict=True)
    )
    return time, np.abs(np.subtract(*places)).max(axis=0)


def first_strike(result: Result) -> float:
    """Time at which a second corner of the tall block strikes, s, by the force over its weight."""
    struck = result.history["tall.normal_force_N"] > 10 * WEIGHT
    return float(result.history["time_s"][np.argmax(struck)])


@pytest.mark.parametrize("carried", [False, True], ids=["on-the-ground", "on-a-block"])
def test_rocking_as_in_the_rigid_engine(carried: bool) -> None:
    """To round-off until a corner strikes; impacts depend on softness and fall-backs."""
    blocks = [LOW, TALL | LEANING | {"on": "low"}] if carried else [TALL | LEANING]
    mixed = run(*blocks, PEBBLE, end=0.2)
    rigid = run(*blocks, PEBBLE | {"model": "rigid"}, end=0.2)
    time, apart = differences(mixed, rigid, "tall")
    strikes = first_strike(rigid)
    assert 0.1 < strikes < 0.15
    assert apart[time < strikes].max() < 1e-9
    assert apart.max() < 1e-3 * np.radians(3.0)


@pytest.mark.slow
def test_tipping_over_crossing_edges_as_in_the_rigid_engine() -> None:
    """No corner is near the edge of the block below: two crossings of edges carry the block."""
    top = TALL | OVERHANGING
    mixed = run(LOW, top, PEBBLE, end=0.35)
    rigid = run(LOW, top, PEBBLE | {"model": "rigid"}, end=0.35)
    assert np.abs(rigid.history["tall.angle_rad"]).max() > 0.05
    assert differences(mixed, rigid, "tall")[1].max() < 1e-8
    assert differences(mixed, rigid, "low")[1].max() < 1e-10


@pytest.mark.slow
@pytest.mark.parametrize(("lower", "upper"), [("elastic", "rigid"), ("rigid", "elastic")])
def test_stacks_account_for_their_energy(lower: str, upper: str) -> None:
    """A block that rocks and turns on another one on an elastic plate; nothing sinks in."""
    mesh = STONE | {"cells": [2, 2, 2]}
    low = LOW | mesh | {"model": lower}
    turning = LEANING | {"angular_velocity": [0.1, 0.2, 0.8]}
    top = TALL | mesh | turning | {"model": upper, "on": "low"}
    result = run(low, top, end=0.4, foundation=PLATE)
    cost = result.summary["cost"]
    assert cost["rejected_steps"] <= 0.02 * cost["steps"]
    assert result.summary["blocks"]["tall"]["impacts"]
    for name in ("low", "tall"):
        assert result.history[f"{name}.penetration_m"].max() < 1e-5


def test_fields_show_the_box_where_it_stands(tmp_path: Path) -> None:
    """Corners and their velocities in the last snapshot are those of the last row."""
    pyvista = pytest.importorskip("pyvista")
    block = TALL | LEANING | {"velocity": [0.2, 0.0, 0.5], "angular_velocity": [0.5, 1.0, 3.0]}
    result = run(block, PEBBLE, end=0.1, folder=tmp_path, output={"every": 0.05})
    box = pyvista.read(tmp_path / "fields" / "fields_tall000002.vtu")
    angles, centre, spin = (
        np.array([result.history[f"tall.{name}_{axis}_{unit}"][-1] for axis in "xyz"])
        for name, unit in (("angle", "rad"), ("centre", "m"), ("angular_velocity", "rad_s"))
    )
    points = np.asarray(box.points)
    arms = (points - (0.0, 0.0, 0.5)) @ Rotation.from_rotvec(angles).as_matrix().T
    moved = points + box.point_data["displacement"]
    assert moved == pytest.approx(centre + arms, abs=1e-12)
    velocity = np.asarray(box.point_data["velocity"])
    assert velocity - velocity.mean(axis=0) == pytest.approx(np.cross(spin, arms), abs=1e-10)


@pytest.mark.parametrize("step", [0.0045, 0.02])
def test_a_slender_rod_that_tumbles_keeps_its_energy_in_long_steps(step: float) -> None:
    """Moments of inertia of 1 to 29: the rule for its turn was iterated too slowly to settle."""
    rod = {"model": "rigid", "width": 0.0058, "thickness": 0.0193, "height": 0.105, "density": 1.76}
    rod |= {"velocity": [0.0, 0.0, 20.0], "angular_velocity": [25.8, -77.0, -0.76]}
    span = {"end": 0.4, "step": step}
    scene = {"dimension": 3, "gravity": 0.0, "block": [rod], "time": span}
    found = simulate(parse_scene(scene))
    assert found.status == "completed"
    assert found.summary["cost"]["rejected_steps"] == 0
    energy = found.history["energy.kinetic_J"]
    assert energy == pytest.approx(energy[0], rel=1e-14)
