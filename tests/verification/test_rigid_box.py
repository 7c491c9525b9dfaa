"""Rigid boxes in space among meshed bodies: against closed forms, an ODE and the rigid engine."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from geometry.block import Block
from rockslip import Result, parse_scene, simulate
from solver.bodies.rigid_body import TURNED, SpaceBox, rigid_box
from solver.contact.body_points import RigidPoints
from solver.contact.carriers import Plane
from solver.contact.interface import Interface
from solver.contact.pairs import FixedContactPair
from solver.scene import FrictionSpec
from solver.scheme.generalized_alpha import GeneralizedAlpha
from solver.stepping.state import State
from solver.stepping.stepper import Stepper
from solver.stepping.system import System

Array = NDArray[np.float64]

BRICK = Block(width=0.3, thickness=0.5, height=1.0, density=2000.0)
SPIN = np.array([0.3, 5.0, 1.0])
"""About the axis of the middle moment of inertia, and a little beside it: unstable."""


def thrown(start: Rotation) -> tuple[Stepper, SpaceBox, State]:
    """A brick that spins high above the floor, without gravity."""
    box = rigid_box("brick", BRICK, np.array([0.0, 0.0, 0.5]))
    assert isinstance(box, SpaceBox)
    interface = Interface(RigidPoints(box, box.corners), Plane.level(3), FrictionSpec(static=0.5))
    contact = FixedContactPair(interface, body=0, on=None)
    scheme = GeneralizedAlpha(0.8)
    tight = ["-rockslip_snes_atol", "3e-8"]  # N m, of momenta of 1e6 N m in a step
    stepper = Stepper(System([box]), [contact], scheme, gravity=np.zeros(3), petsc_options=tight)
    turn = start.as_matrix()
    u = box.initial(np.array([0.0, 0.0, 5.0]), turn)
    return stepper, box, stepper.start(u, box.initial_velocity(np.zeros(3), turn @ SPIN, turn))


def exact_turn(inertia: Array, end: float) -> tuple[Array, Array]:
    """Rotation and angular velocity in the body by Euler's equations.

    J dW/dt = J W x W, dQ/dt = Q (0, W)/2 for the quaternion Q (x, y, z, w).
    """

    def rate(_: float, y: Array) -> Array:
        spin, (x, q) = y[:3], (y[3:6], y[6])
        turning = np.append(q * spin + np.cross(x, spin), -(x @ spin)) / 2
        return np.append(np.cross(inertia * spin, spin) / inertia, turning)

    found = solve_ivp(rate, (0, end), [*SPIN, 0, 0, 0, 1], "DOP853", rtol=1e-12, atol=1e-12)
    return Rotation.from_quat(found.y[3:, -1]).as_matrix(), found.y[:3, -1]


def test_free_spinning() -> None:
    """Energy and angular momentum stay what they are; the motion is of second order."""
    errors = []
    for dt in (1e-3, 5e-4):
        stepper, box, state = thrown(Rotation.identity())
        inertia, energy = box.diagonal[TURNED], state.kinetic
        momentum = inertia * SPIN
        for _ in range(round(0.5 / dt)):
            state, _ = stepper.advance(state, dt)
            assert state.kinetic == pytest.approx(energy, rel=1e-12)
        rotation = box.rotation(state.u)
        kept = rotation @ (inertia * state.v[TURNED])
        assert kept == pytest.approx(momentum, abs=1e-10 * np.linalg.norm(momentum))
        exact, spin = exact_turn(inertia, 0.5)
        errors.append((np.abs(rotation - exact).max(), np.abs(state.v[TURNED] - spin).max()))
    (turn, speed), (finer_turn, finer_speed) = errors
    assert 3.9 < turn / finer_turn < 4.1
    assert 3.9 < speed / finer_speed < 4.1
    assert finer_turn < 1e-5


def test_a_step_depends_on_its_state_alone() -> None:
    """Tried again, from an older state, or with other steps between: the same to the last digit."""
    stepper, box, first = thrown(Rotation.from_rotvec([0.5, -2.0, 1.0]))
    kept = first.u.copy()
    second, _ = stepper.advance(first, 2e-3)
    third, _ = stepper.advance(second, 1e-3)
    stepper.advance(third, 5e-4)
    again, _ = stepper.advance(first, 2e-3)
    assert np.array_equal(first.u, kept)
    assert np.array_equal(again.u, second.u)
    assert np.array_equal(again.v, second.v)
    turned = box.rotation(first.u).T @ box.rotation(second.u)
    assert Rotation.from_matrix(turned).magnitude() == pytest.approx(
        2 * np.arctan(1e-3 * np.linalg.norm(SPIN)), rel=1e-3
    )


def test_large_increments_move_points_exactly() -> None:
    """Rows times increment is the change of position, and a moment has the mean arm."""
    _, box, state = thrown(Rotation.from_rotvec([0.5, -2.0, 1.0]))
    new = state.u + np.array([0.3, -0.2, 0.1, 0.7, -1.1, 0.4, 0.0, 0.0, 0.0])
    rows = box.increment_rows(box.corners, state.u, new)
    before, after = (box.material_positions(box.corners, u) for u in (state.u, new))
    assert rows @ (new - state.u) == pytest.approx(after - before, abs=1e-14)
    settled = box.settled(new)
    assert new[TURNED].any()
    assert not settled[TURNED].any()
    assert box.rotation(settled) == pytest.approx(box.rotation(new), abs=1e-15)
    # R_n (I - S/2)^-T turns the generalized moment into that in space, (1) of `rigid_box`.
    force = np.array([3.0, -1.0, 2.0])
    moment = np.cross(0.5 * (before + after)[0] - 0.5 * (state.u + new)[:3] - box.centre, force)
    mean = 0.5 * (box.rotation(state.u) + box.rotation(new))
    assert mean @ (force @ rows[0, :, TURNED]) == pytest.approx(moment, abs=1e-13)


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
    content = {
        "dimension": 3,
        "block": list(blocks),
        "contact": {"friction": 0.5},
        "damping": {"stiffness": 0.0},
        "time": {"end": end, "step": 1e-3},
        "output": {"fields": "none"},
    }
    result = simulate(parse_scene(content | tables), folder=folder)
    assert result.status == "completed", result.summary["reason"]
    assert result.summary["energy"]["largest_gain_fraction"] < 1e-5
    assert result.summary["energy"]["ledger_error_fraction"] < 1e-8
    return result


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


def test_tipping_over_crossing_edges_as_in_the_rigid_engine() -> None:
    """No corner is near the edge of the block below: two crossings of edges carry the block."""
    top = TALL | OVERHANGING
    mixed = run(LOW, top, PEBBLE, end=0.35)
    rigid = run(LOW, top, PEBBLE | {"model": "rigid"}, end=0.35)
    assert np.abs(rigid.history["tall.angle_rad"]).max() > 0.05
    assert differences(mixed, rigid, "tall")[1].max() < 1e-8
    assert differences(mixed, rigid, "low")[1].max() < 1e-10


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
