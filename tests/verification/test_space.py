"""Elastic blocks in space, of hexahedra and of tetrahedra, on everything that can carry them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from geometry.arrangement import initial_position
from rockslip import BlockSpec, Result, Scene, parse_scene, simulate
from solver.excitation.kinds import base_motion
from solver.reference.sliding import sliding

Array = NDArray[np.float64]

STONE = {"young": 5e10, "poisson": 0.2}
SQUAT = {"width": 1.0, "height": 0.5, "thickness": 0.8, "mass": 1000.0, "cells": [3, 3, 2], **STONE}
OSCILLATOR = {"kind": "oscillator", "mass_ratio": 2.0, "period": 0.5, "damping_ratio": 0.05}
PLATE = {
    "kind": "elastic",
    "width": 2.5,
    "thickness": 2.0,
    "height": 0.3,
    "mass_ratio": 2.0,
    "cells": [4, 4, 1],
    **STONE,
}
ROLLERS = PLATE | {"support": "rollers", "period": 0.5, "damping_ratio": 0.05}
BOTH_WAYS = {
    "kind": "sine",
    "amplitude_g": 0.4,
    "period": 0.6,
    "second": {"kind": "sine", "amplitude_g": 0.3, "period": 0.45},
}


def scene(*blocks: dict[str, Any], end: float, friction: float, **tables: Any) -> Scene:
    """A scene in space, with steps of 1 ms."""
    content = {
        "dimension": 3,
        "block": list(blocks),
        "contact": {"friction": friction},
        "damping": {"stiffness": 0.0},
        "time": {"end": end, "step": 1e-3},
    }
    return parse_scene(content | tables)


def completed(run: Scene, *, largest_gain: float = 1e-9, ledger: float = 1e-9) -> Result:
    """The result of a run that went to its end, gained no energy and accounts for all of it."""
    result = simulate(run)
    assert result.status == "completed", result.summary["reason"]
    assert result.summary["energy"]["largest_gain_fraction"] < largest_gain
    assert result.summary["energy"]["ledger_error_fraction"] < ledger
    return result


def on_a_corner(spec: BlockSpec, gravity: float, end: float) -> tuple[Any, Array, Array, Array]:
    """A rigid block that turns about its lowest corner, until another corner comes down.

    Returns:
        The solution of the ODE in the rotation matrix and the angular velocity in the body; the
        arm from the corner to the centre, in the body; where the corner is; the time of impact.
    """
    size, mass = np.array([spec.width, spec.thickness, spec.height]), spec.shape.mass
    pose = initial_position(spec.shape, (0.0, 0.0), spec.tilt, spec.tilt_direction)
    arm = np.array([0.0, 0.0, size[2] / 2]) - pose.about
    about_centre = np.diag(mass / 12 * (size @ size - size**2))
    inertia = about_centre + mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    feet = np.array([[x, y, 0.0] for x in (-0.5, 0.5) for y in (-0.5, 0.5)]) * size - pose.about
    feet = feet[np.linalg.norm(feet, axis=1) > 1e-9]

    def rate(_: float, state: Array) -> Array:
        rotation, omega = state[:9].reshape(3, 3), state[9:]
        moment = np.cross(arm, rotation.T @ (0.0, 0.0, -mass * gravity))
        spin = np.linalg.solve(inertia, moment - np.cross(omega, inertia @ omega))
        return np.concatenate([np.cross(rotation, omega).ravel(), spin])

    def gap(_: float, state: Array) -> float:
        return float((feet @ state[6:9]).min())

    gap.terminal = True  # type: ignore[attr-defined]
    start = np.concatenate([pose.rotation.ravel(), np.zeros(3)])
    found = solve_ivp(rate, (0, end), start, rtol=1e-10, atol=1e-12, events=gap, dense_output=True)
    return found.sol, arm, pose.place, found.t_events[0][0]


@pytest.mark.parametrize("cell", ["hexahedron", "tetrahedron"])
def test_released_on_a_corner(cell: str) -> None:
    """As the rigid block until the next corner comes down, within 0.3 %; then on, swinging less."""
    block = STONE | {
        "width": 0.4,
        "height": 1.0,
        "mass": 503.0,
        "thickness": 0.6,
        "tilt_deg": 4.0,
        "tilt_direction_deg": float(np.rad2deg(np.arctan2(0.6, 0.4))),
        "cells": [2, 3, 5],
        "cell": cell,
    }
    run = scene(block, end=0.5, friction=1.0)
    solution, arm, place, impact = on_a_corner(run.blocks[0], run.gravity, 1.0)
    history = completed(run, ledger=1e-8).history
    time = history["time_s"]
    before = time < impact
    turned = solution(time[before])[:9].T.reshape(-1, 3, 3)
    for columns, exact in (
        ("block.angle_{}_rad", Rotation.from_matrix(turned).as_rotvec()),
        ("block.centre_{}_m", place + turned @ arm),
    ):
        found = np.column_stack([history[columns.format(axis)][before] for axis in "xyz"])
        assert np.abs(found - exact).max() < 3e-3 * np.ptp(exact, axis=0).max()
    gaps = np.column_stack([history[f"block.gap_{k}_m"] for k in (1, 2, 3, 4)])
    down = [np.flatnonzero(np.abs(gap) < 1e-6) for gap in gaps.T]
    landing = sorted(time[rows[0]] for rows in down if len(rows))[1]
    assert landing == pytest.approx(impact, abs=2e-3)
    lean = history["block.angle_x_rad"] ** 2 + history["block.angle_y_rad"] ** 2
    assert 0 < lean[~before].max() < lean[0]


@pytest.fixture(scope="module")
def on_an_oscillator() -> Result:
    """The squat block on a platform that moves both ways; it slides on it."""
    return completed(scene(SQUAT, end=0.35, friction=0.1, motion=BOTH_WAYS, foundation=OSCILLATOR))


@pytest.mark.slow
def test_the_plate_on_rollers_drifts_as_the_oscillator(on_an_oscillator: Result) -> None:
    """Drift in both directions within 0.5 % of its peak."""
    run = scene(SQUAT, end=0.35, friction=0.1, motion=BOTH_WAYS, foundation=ROLLERS)
    history = completed(run).history
    for column in ("platform.drift_m", "platform.drift_second_m"):
        expected = on_an_oscillator.history[column]
        assert np.abs(expected).max() > 0.02
        assert history[column] == pytest.approx(expected, abs=5e-3 * np.abs(expected).max())
    assert np.abs(on_an_oscillator.history["block.slip_m"]).max() > 0.05


@pytest.mark.slow
def test_a_plate_on_its_bottom_carries_as_the_ground() -> None:
    """Stiff and at rest below: the same slip both ways as on the rigid ground."""
    common = {"end": 0.25, "friction": 0.1, "motion": BOTH_WAYS}
    ground = completed(scene(SQUAT, **common)).history
    history = completed(scene(SQUAT, foundation=PLATE | {"support": "bottom"}, **common)).history
    for column in ("block.slip_m", "block.slip_second_m"):
        peak = np.abs(ground[column]).max()
        assert peak > 0.01
        assert history[column] == pytest.approx(ground[column], abs=1e-3 * peak)


def test_second_degree_on_tetrahedra_and_at_gauss_points() -> None:
    """Curved facets that carry: a quarter of the weight a corner, and the ledger closes."""
    plate = ROLLERS | {"cell": "tetrahedron", "degree": 2, "cells": [4, 3, 1]}
    block = SQUAT | {"cells": [2, 2, 1], "degree": 2}
    history = completed(
        scene(block, end=0.08, friction=0.1, motion=BOTH_WAYS, foundation=plate)
    ).history
    assert history["block.normal_force_N"][1:].mean() == pytest.approx(9810.0, rel=1e-6)
    ends = np.array([history[f"block.gap_{k}_m"][-1] for k in (1, 2, 3, 4)])
    assert np.abs(ends).max() < 1e-7


@pytest.mark.slow
@pytest.mark.parametrize(("lower", "upper"), [("elastic", "rigid"), ("rigid", "elastic")])
def test_the_upper_block_of_a_stack_slides_as_on_the_ground(lower: str, upper: str) -> None:
    """The lower one sticks to the ground: the slip of the upper one is that of the ODE."""
    low = SQUAT | {"name": "low", "model": lower, "friction": 1.0}
    size = {"width": 0.6, "thickness": 0.5, "height": 0.3, "mass": 200.0, "cells": [2, 2, 2]}
    top = SQUAT | size | {"name": "top", "on": "low", "model": upper}
    motion = {key: value for key, value in BOTH_WAYS.items() if key != "second"}
    run = scene(low, top, end=0.3, friction=0.1, motion=motion)
    history = completed(run).history
    shaken = base_motion(run.motion, run.time.end)
    assert shaken is not None
    exact = sliding(
        acceleration=shaken.acceleration, friction=0.1, gravity=9.81, end=0.3, step=1e-3
    )
    slip = np.interp(history["time_s"], exact.time, exact.slip)
    assert history["top.slip_m"] == pytest.approx(slip, abs=5e-3 * np.abs(slip).max())
    assert np.abs(history["top.slip_second_m"]).max() < 1e-4 * np.abs(slip).max()
    assert np.abs(history["low.slip_m"]).max() < 1e-5
    assert history["top.normal_force_N"][1:].mean() == pytest.approx(200 * 9.81, rel=1e-4)
    assert history["low.normal_force_N"][1:].mean() == pytest.approx(1200 * 9.81, rel=1e-4)
