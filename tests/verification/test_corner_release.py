"""A block with a square base on one corner: released from it, and lifted there by two motions."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from rockslip import Scene, parse_scene, simulate

Array = NDArray[np.float64]

BASE, HEIGHT, DENSITY, G = 0.25, 1.0, 2670.0, 9.81

DIAGONAL = math.sqrt(2) * BASE / 2
"""From the middle of the base to a corner, m."""
SLENDERNESS = math.atan(2 * DIAGONAL / HEIGHT)
"""Of the plane through a diagonal, rad."""
RADIUS = math.hypot(DIAGONAL, HEIGHT / 2)
"""From a corner to the centre, m."""
FREQUENCY = math.sqrt(G * RADIUS / ((BASE**2 + HEIGHT**2) / 12 + RADIUS**2))
"""p of rocking about a corner in that plane, a plane of symmetry, 1/s."""

#: Tilt in degrees, and when the other corners touch the ground.
FIRST_TOUCH = ((3.0, 0.15973), (8.0, 0.30023))


def scene(block: dict[str, Any], **tables: Any) -> Scene:
    """The block on a floor on which it does not slide."""
    size = {"width": BASE, "thickness": BASE, "height": HEIGHT, "density": DENSITY}
    content = {"dimension": 3, "contact": {"friction": 10.0}, "block": [size | block]}
    return parse_scene(content | tables)


def swing(start: Array, times: tuple[float, float], peak: float = 0.0, omega: float = 0.0) -> Any:
    """The equation of a block on one corner, theta and theta' from the start up to theta = 0.

    Under half a sine of the ground along the diagonal, of this peak (m/s^2).
    """

    def rate(t: float, y: Array) -> list[float]:
        lean, a = SLENDERNESS - y[0], peak * math.sin(omega * t) / G
        return [y[1], -(FREQUENCY**2) * (math.sin(lean) - a * math.cos(lean))]

    def touch(_: float, y: Array) -> float:
        return float(y[0])

    touch.terminal, touch.direction = True, -1  # type: ignore[attr-defined]
    return solve_ivp(rate, times, start, rtol=1e-11, atol=1e-13, events=touch, dense_output=True)


def first_touch(run: Scene) -> float:
    """When the lean vanishes, by a parabola through the last rows before it."""
    result = simulate(run)
    assert result.status == "completed", result.summary["reason"]
    assert result.summary["energy"]["largest_gain_fraction"] < 1e-5
    history = result.history
    lean = np.hypot(history["block.angle_x_rad"], history["block.angle_y_rad"])
    assert np.abs(history["block.angle_z_rad"]).max() < 1e-6
    turn = int(np.argmin(lean))
    last = turn - 1 if lean[turn + 1] > lean[turn - 1] else turn
    rows = slice(last - 40, last - 9, 10)
    parabola = np.polynomial.Polynomial.fit(history["time_s"][rows], lean[rows], 2)
    return float(min(r.real for r in parabola.roots() if r.real > history["time_s"][last - 10]))


@pytest.mark.parametrize(("tilt", "time"), FIRST_TOUCH)
def test_the_equation_of_a_corner(tilt: float, time: float) -> None:
    found = swing(np.array([math.radians(tilt), 0.0]), (0.0, 1.0))
    assert found.t_events[0][0] == pytest.approx(time, abs=6e-6)


@pytest.mark.parametrize(("tilt", "time"), FIRST_TOUCH)
def test_a_rigid_block_released_on_a_corner(tilt: float, time: float) -> None:
    """The other three corners touch at once, within 1e-4 of the equation."""
    block = {"model": "rigid", "tilt_deg": tilt, "tilt_direction_deg": 45.0}
    run = scene(block, time={"end": 1.1 * time, "step": 1e-4})
    assert first_touch(run) == pytest.approx(time, rel=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize(("tilt", "time"), FIRST_TOUCH)
def test_an_elastic_block_released_on_a_corner(tilt: float, time: float) -> None:
    """Within 0.5 % of the rigid one."""
    block = {"tilt_deg": tilt, "tilt_direction_deg": 45.0, "young": 5e10, "poisson": 0.2}
    run = scene(block | {"cells": [2, 2, 6]}, time={"end": 1.1 * time, "step": 5e-4})
    assert first_touch(run) == pytest.approx(time, rel=5e-3)


def test_two_motions_lift_a_rigid_block_onto_a_corner() -> None:
    """Half a sine along x and along y at once: it leans in the plane between them, as one block."""
    peak, duration = 0.5 * G, 0.3
    along = {"kind": "half_sine", "amplitude_g": -peak / math.sqrt(2) / G, "duration": duration}
    run = scene(
        {"model": "rigid"},
        motion=along | {"second": along},
        time={"end": duration, "step": 1e-4},
    )
    history = simulate(run).history
    omega = math.pi / duration
    start = math.asin(math.tan(SLENDERNESS) * G / peak) / omega

    time = history["time_s"]
    after = time > start
    lean = np.hypot(history["block.angle_x_rad"], history["block.angle_y_rad"])
    expected = swing(np.zeros(2), (start, duration), peak, omega).sol(time[after])[0]
    assert expected[-1] > 0.02
    assert np.abs(lean[after] - expected).max() < 1e-3 * expected[-1]
    assert lean[~after].max() < 1e-5
    assert history["block.angle_x_rad"] == pytest.approx(-history["block.angle_y_rad"], abs=1e-9)
    assert history["block.angle_y_rad"][-1] > 0.0
