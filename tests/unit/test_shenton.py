"""Shenton's (1996) criteria against a table of his mu_R and the equations of motion."""

from __future__ import annotations

import math

import pytest

from solver.reference import initiation as shenton

TABLE = {
    2: {0.6: 0.5243, 0.8: 0.5688, 1.0: 0.6087, 2.0: 0.7586},
    4: {0.3: 0.2624, 0.4: 0.2865, 0.5: 0.3099, 0.8: 0.3753, 1.0: 0.4156, 2.0: 0.5843},
    6: {0.2: 0.1750, 0.4: 0.2234, 1.0: 0.3558},
    8: {0.2: 0.1436, 0.4: 0.1920, 1.0: 0.3274},
}


def rocking_acceleration(friction: float, slenderness_ratio: float) -> float:
    """The inverse of mu_R: [mu (1 + 4 r^2) - 3 r] / [4 + r^2 - 3 mu r]; infinite beyond."""
    mu, r = friction, slenderness_ratio
    below = 4 + r**2 - 3 * mu * r
    return (mu * (1 + 4 * r**2) - 3 * r) / below if below > 0 else math.inf


@pytest.mark.parametrize("r", TABLE)
def test_friction_that_rocking_needs(r: int) -> None:
    for acceleration, friction in TABLE[r].items():
        assert shenton.rocking_friction(acceleration, r) == pytest.approx(friction, abs=5e-5)
        assert rocking_acceleration(friction, r) == pytest.approx(acceleration, rel=2e-3)
    assert shenton.rocking_friction(1 / r, r) == pytest.approx(1 / r)


def test_friction_is_that_of_the_forces_at_the_pivot() -> None:
    """T/N of a block that starts to rock, from its equations of motion."""
    b, h, g, a = 0.125, 0.5, 9.81, 0.7 * 9.81
    turning = 0.75 * (a * h - g * b) / (b**2 + h**2)
    demand = (a - h * turning) / (g + b * turning)
    assert shenton.rocking_friction(0.7, 4) == pytest.approx(demand)


@pytest.mark.parametrize(
    ("acceleration", "friction", "mode"),
    [
        (0.2, 0.7, "rest"),
        (0.05, 0.1, "rest"),
        (0.2, 0.1, "slide"),
        (2.0, 0.24, "slide"),
        (0.26, 0.7, "rock"),
        (1.0, 0.42, "rock"),
        (1.0, 0.41, "slide-rock"),
        (2.0, 0.26, "slide-rock"),
    ],
)
def test_modes_of_the_paper_s_block(acceleration: float, friction: float, mode: str) -> None:
    assert shenton.initial_mode(acceleration, friction, 4.0) == mode


def test_with_much_friction_no_acceleration_makes_it_slide() -> None:
    """Above (4 + r^2)/(3 r)."""
    assert rocking_acceleration(1.67, 4.0) == math.inf
    assert shenton.initial_mode(1e6, 1.67, 4.0) == "rock"


def test_friction_at_release() -> None:
    """From the forces that accelerate the centre along its circle about the corner."""
    width, height, g, theta = 0.25, 1.0, 9.81, math.radians(3)
    alpha, radius = math.atan2(width, height), math.hypot(width, height) / 2
    lean = alpha - theta
    turning = 0.75 * g / radius * math.sin(lean)
    across, up = turning * radius * math.cos(lean), -turning * radius * math.sin(lean)
    assert shenton.release_friction(theta, alpha) == pytest.approx(across / (g + up))
    assert shenton.release_friction(-theta, alpha) == pytest.approx(across / (g + up))
