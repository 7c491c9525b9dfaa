"""A rigid block in space against closed forms and independent integrations."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import quad, solve_ivp
from scipy.spatial.transform import Rotation

from geometry.arrangement import Pose, initial_position_in_space
from geometry.block import Block
from rockslip import parse_scene, simulate
from solver.reference.housner import housner
from solver.rigid.space.system import SpaceSystem
from solver.rigid.system import RigidBlock
from solver.scene import FrictionSpec
from solver.scheme.generalized_alpha import GeneralizedAlpha

Array = NDArray[np.float64]

G = 9.81
PAPER = Block(width=0.25, height=1.0, thickness=0.75, density=503.0 / 0.1875)
SQUAT = Block(width=1.0, height=0.3, thickness=0.8, density=2000.0)


def block(
    shape: Block,
    friction: float | FrictionSpec,
    *,
    tilt: float = 0.0,
    azimuth: float = 0.0,
    lift: float = 0.0,
    velocity: tuple[float, ...] = (0.0, 0.0, 0.0),
    spin: tuple[float, ...] = (0.0, 0.0, 0.0),
) -> RigidBlock:
    """A block on, or above, the floor."""
    law = friction if isinstance(friction, FrictionSpec) else FrictionSpec(static=friction)
    stand = initial_position_in_space(shape, (0.0, 0.0), tilt, azimuth)
    place = stand.place + np.array([0.0, 0.0, lift])
    pose = Pose(rotation=stand.rotation, about=stand.about, place=place)
    return RigidBlock(
        name="block", shape=shape, friction=law, pose=pose, velocity=velocity, angular_velocity=spin
    )


def run(
    one: RigidBlock, steps: int, dt: float, ground: Array | None = None, **kwargs: object
) -> dict[str, Array]:
    """Columns of the history by their names; checks that nothing failed and the ledger closes."""
    system = SpaceSystem([one], GeneralizedAlpha(0.8), **kwargs)  # type: ignore[arg-type]
    outcome = system.advance(steps, dt, ground)
    assert outcome.failure is None
    found = {
        name.removeprefix("block."): column
        for name, column in zip(system.columns, outcome.rows.T, strict=True)
    }
    scale = max(1e-3 * one.shape.weight(G) * one.shape.height, found["energy.kinetic_J"].max())
    assert np.abs(found["energy.ledger_error_J"]).max() < 1e-9 * scale
    return found


def test_free_tumbling_keeps_energy_and_momentum() -> None:
    """About the axis of the middle moment of inertia, which is unstable: it turns over and over."""
    thrown = block(PAPER, 0.5, lift=100.0, spin=(1e-3, 5.0, 1e-3))
    system = SpaceSystem([thrown], GeneralizedAlpha(0.8), gravity=(0.0, 0.0, 0.0))

    def momentum() -> Array:
        turn = system.rotation(0)
        return turn @ (np.array(PAPER.principal_inertias) * (turn.T @ system.angular_velocity(0)))

    before, axis = momentum(), []
    rows = []
    for _ in range(20):
        rows.append(system.advance(500, 1e-3).rows)
        axis.append(system.rotation(0)[1, 1])
    kinetic = np.concatenate(rows)[:, system.columns.index("energy.kinetic_J")]
    np.testing.assert_allclose(momentum(), before, atol=1e-11 * np.abs(before).max())
    assert np.ptp(kinetic) < 1e-11 * kinetic[0]
    assert min(axis) < -0.9 < 0.9 < max(axis)


def spinning(spin: tuple[float, ...], end: float) -> dict[str, Array]:
    """Times and motion of a square block that spins without gravity, in default steps."""
    size = {"model": "rigid", "width": 0.3, "thickness": 0.3, "height": 0.5, "density": 2000.0}
    thrown = size | {"velocity": [0.0, 0.0, 20.0], "angular_velocity": list(spin)}
    scene = {"dimension": 3, "gravity": 0.0, "block": [thrown], "time": {"end": end}}
    history = simulate(parse_scene(scene)).history
    return {name.removeprefix("block."): history[name] for name in history.columns}


@pytest.mark.parametrize("end", [2.0, 60.0])
def test_default_steps_see_what_spins(end: float) -> None:
    """They were a hundredth of the run."""
    found = spinning((0.0, 0.0, 20.0), end)
    assert found["angle_z_rad"] == pytest.approx(20.0 * found["time_s"], rel=1e-5)


def test_default_steps_see_a_top_that_turns_about_its_momentum() -> None:
    """At the rate L/J of its moment of inertia across the axis, without torque."""
    found, across, along = spinning((6.0, 0.0, 12.0), 2.0), 0.3**2 + 0.5**2, 2 * 0.3**2
    momentum = np.array([across * 6.0, 0.0, along * 12.0])
    size = float(np.linalg.norm(momentum))
    spin = np.stack([found[f"angular_velocity_{d}_rad_s"] for d in "xyz"], axis=1)
    aside = spin - np.outer(spin @ momentum, momentum) / size**2
    turned = np.unwrap(np.arctan2(aside @ np.cross(momentum / size, aside[0]), aside @ aside[0]))
    assert turned == pytest.approx(size / across * found["time_s"], rel=2e-5, abs=1e-9)


def test_rocking_on_an_edge_is_housners() -> None:
    """Impacts and peaks of the paper's block; it stays in its plane."""
    angle = math.radians(3)
    history = run(block(PAPER, 0.7, tilt=angle), 18000, 1e-4)
    lean, time = history["angle_rad"], history["time_s"]
    turns = np.flatnonzero(lean[1:] * lean[:-1] < 0)
    impacts = time[turns] + 1e-4 * lean[turns] / (lean[turns] - lean[turns + 1])
    peaks = [np.abs(lean[a:b]).max() for a, b in pairwise(turns)]
    exact = housner(PAPER, gravity=G, tilt=angle, end=1.9, step=0.01)
    np.testing.assert_allclose(impacts[:7], exact.impacts[:7], rtol=2e-4)
    np.testing.assert_allclose(peaks[:6], np.abs(exact.peaks[1:7]), rtol=5e-4)
    assert np.abs(history["centre_y_m"]).max() < 1e-12
    total = history["energy.total_J"]
    assert np.diff(total).max() < 1e-9 * (total[0] - PAPER.weight(G) * PAPER.height / 2)


def test_thrown_it_comes_to_rest_and_gains_nothing() -> None:
    shape = Block(width=0.3, height=0.5, thickness=0.4, density=2000.0)
    thrown = block(shape, 0.5, lift=0.5, velocity=(1.0, 0.5, 0.3), spin=(3.0, -4.0, 6.0))
    history = run(thrown, 6000, 5e-4)
    total = history["energy.total_J"]
    assert np.diff(total).max() < 1e-9 * (total[0] - total[-1])
    assert history["energy.kinetic_J"][-1] < 1e-15
    # It lies on one of its faces.
    heights = np.array([shape.width, shape.thickness, shape.height]) / 2
    assert np.abs(heights - history["centre_z_m"][-1]).min() < 1e-9
    assert history["penetration_m"].max() < 1e-9


@pytest.mark.parametrize("azimuth", [0.0, 17.0, 45.0, 90.0, 133.0])
def test_sliding_stop_in_any_direction(azimuth: float) -> None:
    """Straight on, over v^2/(2 mu g), against a force opposite to the slip."""
    way = np.array([math.cos(math.radians(azimuth)), math.sin(math.radians(azimuth))])
    history = run(block(SQUAT, 0.3, velocity=(*way, 0.0)), 600, 1e-3)
    slip = np.stack([history["slip_m"], history["slip_second_m"]])
    force = np.stack([history["friction_force_N"], history["friction_force_second_N"]])[:, :300]
    np.testing.assert_allclose(slip[:, -1], way / (2 * 0.3 * G), atol=1e-5)
    angle = np.degrees(np.arccos(np.clip(-(way @ force) / np.linalg.norm(force, axis=0), -1, 1)))
    assert angle.max() < 1e-4
    assert history["energy.friction_J"][-1] == pytest.approx(SQUAT.mass / 2, rel=1e-3)


@pytest.mark.parametrize("factor", [1.02, 0.98])
def test_incline_across_both_axes(factor: float) -> None:
    """Sticks, or slides as far as the closed form says."""
    slope, way = math.radians(20), np.array([0.6, 0.8])
    down = G * math.sin(slope) * way
    friction = factor * math.tan(slope)
    gravity = (*down, -G * math.cos(slope))
    history = run(block(SQUAT, friction), 3000, 1e-3, gravity=gravity)
    moved = np.hypot(history["centre_x_m"], history["centre_y_m"])
    if factor > 1:
        assert moved[-1] - moved[1000] < 1e-10
    else:
        pull = G * (math.sin(slope) - friction * math.cos(slope))
        assert moved[-1] == pytest.approx(pull * 9 / 2, rel=1e-5)


def test_at_rest_it_stays() -> None:
    history = run(block(SQUAT, 0.3), 3000, 1e-3)
    for name in ("centre_x_m", "centre_y_m", "centre_z_m", "angle_x_rad", "angle_y_rad"):
        assert np.ptp(history[name]) < 1e-10
    np.testing.assert_allclose(history["normal_force_N"][1:], SQUAT.weight(G), rtol=1e-6)


def test_ground_that_moves_in_a_circle() -> None:
    """Against a particle on a disc of friction: the slip follows the ground, and never sticks."""
    peak, period, friction, dt = 0.4 * G, 0.6, 0.2, 5e-4
    time = np.arange(2401) * dt

    def acceleration(t: Array | float) -> Array:
        return peak * np.array([np.cos(2 * np.pi * t / period), np.sin(2 * np.pi * t / period)])

    ground = np.vstack([acceleration(time), np.zeros(len(time))]).T
    history = run(block(SQUAT, friction), len(time) - 1, dt, ground)

    def rate(t: float, y: Array) -> Array:
        speed = np.hypot(*y[2:])
        way = y[2:] / speed if speed > 1e-9 else np.array([-1.0, 0.0])
        return np.r_[y[2:], -acceleration(t) - friction * G * way]

    exact = solve_ivp(
        rate, (0, time[-1]), [0, 0, -1e-12, 0], t_eval=time[1:], rtol=1e-8, max_step=2e-3
    ).y[:2]
    error = np.stack([history["centre_x_m"], history["centre_y_m"]]) - exact
    assert np.linalg.norm(error, axis=0).max() < 1e-3 * np.linalg.norm(exact, axis=0).max()


def on_its_corner(pivot: Array, start: Array, times: Array) -> Array:
    """Rotations of the paper's block about a fixed corner, by Euler's equations."""
    arm, half = -pivot, np.array([PAPER.width, PAPER.thickness, PAPER.height]) / 2
    own = PAPER.mass / 3 * ((half**2).sum() - half**2)
    inertia = np.diag(own) + PAPER.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))

    def rate(_: float, y: Array) -> Array:
        turn, spin = y[:9].reshape(3, 3), y[9:]
        moment = np.cross(arm, turn.T @ [0, 0, -PAPER.weight(G)])
        gained = np.linalg.solve(inertia, moment - np.cross(spin, inertia @ spin))
        # Columns of the derivative: R (spin x e_k), which is R skew(spin).
        return np.r_[(turn @ np.cross(spin, np.eye(3)).T).ravel(), gained]

    found = solve_ivp(
        rate, (0, times[-1]), np.r_[start.ravel(), 0, 0, 0], t_eval=times, rtol=1e-11, atol=1e-13
    )
    return found.y[:9].T.reshape(-1, 3, 3)


def test_released_on_a_corner() -> None:
    """Pivots about it as a body about a fixed point, until another corner lands."""
    azimuth, dt = math.atan2(PAPER.thickness, PAPER.width), 2e-4
    released = block(PAPER, 50.0, tilt=math.radians(5), azimuth=azimuth)
    history = run(released, 1000, dt)
    pivot = np.array([PAPER.width, PAPER.thickness, -PAPER.height]) / 2
    turns = on_its_corner(pivot, released.pose.rotation, history["time_s"])
    foot = np.array([PAPER.width / 2, PAPER.thickness / 2, 0.0])
    others = np.array([(-1.0, -1.0, -1.0), (1.0, -1.0, -1.0), (-1.0, 1.0, -1.0)]) * abs(pivot)
    heights = ((others - pivot) @ turns.transpose(0, 2, 1))[:, :, 2].min(axis=1)
    landing = int(np.flatnonzero(heights < 0)[0])
    gaps = np.min([history[f"gap_{k}_m"] for k in (1, 2, 4)], axis=0)
    assert abs(int(np.flatnonzero(gaps < 1e-9)[0]) - landing) <= 1
    centres = foot - turns[:landing] @ pivot
    found = np.stack([history[f"centre_{axis}_m"][:landing] for axis in "xyz"], axis=1)
    assert np.abs(found - centres).max() < 1e-5 * np.ptp(centres, axis=0).max()
    vectors = Rotation.from_matrix(turns[:landing]).as_rotvec()
    found = np.stack([history[f"angle_{axis}_rad"][:landing] for axis in "xyz"], axis=1)
    np.testing.assert_allclose(found, vectors, atol=1e-6)


def test_friction_that_falls_with_speed() -> None:
    law = FrictionSpec(static=0.5, dynamic=0.2, decay=10.0)
    history = run(block(SQUAT, law, velocity=(0.6, 0.8, 0.0)), 1200, 5e-4)
    exact = quad(lambda v: v / (G * (0.2 + 0.3 * math.exp(-10 * v))), 0, 1)[0]
    slip = np.hypot(history["slip_m"], history["slip_second_m"])
    assert slip[-1] == pytest.approx(exact, rel=1e-4)


@pytest.mark.parametrize("lost", [False, True])
def test_cohesion(lost: bool) -> None:
    law = FrictionSpec(static=0.2, cohesion=1000.0, cohesion_lost=lost)
    history = run(block(SQUAT, law, velocity=(0.6, 0.8, 0.0)), 1200, 5e-4)
    slip = np.hypot(history["slip_m"], history["slip_second_m"])
    adhesion = 0.0 if lost else 1000.0 * SQUAT.width * SQUAT.thickness / SQUAT.mass
    # The first step still holds by cohesion.
    assert slip[-1] == pytest.approx(0.5 / (0.2 * G + adhesion), rel=2e-3 if lost else 1e-5)


def test_static_friction_breaks_once_and_for_all_corners() -> None:
    """A ground that pulls harder and harder: stuck up to mu_s, then sliding on mu_d."""
    dt, steps, pull = 5e-4, 4000, 0.3 * G
    time = np.arange(steps + 1) * dt
    ground = np.outer(pull * time, [0.6, 0.8, 0.0])
    history = run(block(SQUAT, FrictionSpec(static=0.5, dynamic=0.2)), steps, dt, ground)
    slip, start = np.hypot(history["slip_m"], history["slip_second_m"]), 0.5 * G / pull
    assert slip[int(start / dt) - 2] < 1e-10
    rest = time[-1] - start
    assert slip[-1] == pytest.approx(pull * rest**3 / 6 + 0.3 * G * rest**2 / 2, rel=2e-3)


def test_flies_and_lands() -> None:
    time = np.arange(2001) * 5e-4
    ground = np.zeros((2001, 3))
    ground[:, 2] = np.where(time < 0.2, 2 * G * np.sin(np.pi * time / 0.1), 0.0)
    history = run(block(SQUAT, 0.3), 2000, 5e-4, ground)
    assert history["gap_1_m"].max() > 0.02
    assert (history["contact_points_closed"] == 0).any()
    assert abs(history["gap_1_m"][-1]) < 1e-12
    assert history["normal_force_N"][-1] == pytest.approx(SQUAT.weight(G), rel=1e-6)
