"""A rigid block in space against closed forms and independent integrations."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from geometry.arrangement import Pose, initial_position_in_space
from geometry.block import Block
from rockslip import parse_scene, simulate
from solver.rigid.space.system import SpaceSystem
from solver.rigid.system import RigidBlock
from solver.scene import FrictionSpec
from solver.scheme.generalized_alpha import GeneralizedAlpha

Array = NDArray[np.float64]

G = 9.81
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
