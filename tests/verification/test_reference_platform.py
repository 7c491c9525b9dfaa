"""A sliding block on a platform: published numbers, limits, energy, laws of friction."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from benchmarks.verification.newmark import incline_distance, sliding_block, sliding_stop
from solver.reference.friction import Resistance
from solver.reference.platform import PlatformReference, sliding_on_platform
from solver.reference.sliding import sliding
from solver.scene import FrictionSpec
from solver.scene.foundation import Platform

G = 9.81
PLATFORM = Platform.on_spring(1.0, period=0.5, stiffness=None, damping_ratio=0.05)


def shaken(
    friction: float | Resistance, period: float, end: float, **options: Any
) -> PlatformReference:
    """0.4 g, six cycles; the block twice as heavy as the platform."""

    def ground(time: float) -> float:
        return 0.4 * G * math.sin(2 * math.pi * time / period) if time <= 6 * period else 0.0

    arguments: dict[str, Any] = {"acceleration": ground, "step": 2e-3} | options
    return sliding_on_platform(
        platform=PLATFORM, mass=2.0, friction=friction, gravity=G, end=end, **arguments
    )


@pytest.mark.parametrize(
    ("friction", "peak", "slip"), [(0.1, 0.07699, -0.1001), (0.3, 0.10089, 0.1359)]
)
def test_numbers_of_another_integration(friction: float, peak: float, slip: float) -> None:
    """Those that another integration of the same equations gave, to its last digits."""
    found = shaken(friction, 0.6, 6.0)
    assert np.abs(found.drift).max() == pytest.approx(peak, abs=6e-6)
    assert found.slip[-1] == pytest.approx(slip, abs=6e-5)
    assert found.slip_velocity[-1] == 0.0


@pytest.mark.parametrize(
    ("friction", "peak", "slip"),
    [
        (0.1, 88.83, 8.8),
        (0.2, 67.86, 37.35),
        (0.3, 81.62, 59.77),
        (0.4, 90.86, 35.25),
        (1e3, 93.84, 0.0),
    ],
)
def test_table_of_another_integration(friction: float, peak: float, slip: float) -> None:
    """Peak drift and residual slip, mm: not monotone in mu."""
    found = shaken(friction, 0.5, 8.0)
    assert 1e3 * np.abs(found.drift).max() == pytest.approx(peak, abs=0.01)
    assert 1e3 * abs(found.slip[-1]) == pytest.approx(slip, abs=0.06)


def test_energy_balance() -> None:
    """Kinetic and spring energy are what the ground gave less friction and damping."""
    p, ground = PLATFORM, lambda t: 0.4 * G * math.sin(2 * math.pi * t / 0.6)
    found = shaken(0.2, 0.6, 2.0, acceleration=ground, step=5e-4)
    u, v, w = found.drift, found.drift_velocity, found.slip_velocity
    stored = (2 * (v + w) ** 2 + v**2 + p.stiffness * u**2) / 2
    power = -np.array([ground(t) for t in found.time]) * (2 * (v + w) + v)
    power -= p.damping * v**2 + np.abs(2 * found.friction * w)
    change = np.concatenate([[0.0], np.cumsum((power[1:] + power[:-1]) / 2 * np.diff(found.time))])
    np.testing.assert_allclose(stored, change, atol=2e-5 * stored.max())


def test_momentum_and_acceleration() -> None:
    """The acceleration given is the derivative of the velocity, the force that of the block."""
    found = shaken(0.3, 0.6, 1.0, step=1e-4)
    slope = np.gradient(found.drift_velocity, found.time)
    smooth = np.abs(slope - found.drift_acceleration) < 0.02
    assert smooth.mean() > 0.99
    assert np.abs(found.friction).max() == pytest.approx(0.3 * G, rel=1e-9)


def test_a_stiff_platform_is_the_ground() -> None:
    stiff = Platform.on_spring(1.0, period=2e-3, stiffness=None, damping_ratio=1.0)

    def ground(time: float) -> float:
        return 0.5 * G * math.sin(math.pi * time / 0.5) if time <= 0.5 else 0.0

    options: dict[str, Any] = {"acceleration": ground, "gravity": G, "end": 1.0, "step": 1e-3}
    found = sliding_on_platform(platform=stiff, mass=2.0, friction=0.3, **options)
    assert found.slip[-1] == pytest.approx(sliding(friction=0.3, **options).slip[-1], rel=1e-4)


def test_a_frictionless_block_leaves_the_empty_platform_alone() -> None:
    """Free vibration from a step of gravity along the platform: closed form."""
    found = shaken(0.0, 0.6, 1.0, acceleration=lambda t: 0.0, along=1.0, step=1e-3)
    p, w0 = PLATFORM, 4 * math.pi
    wd = w0 * math.sqrt(1 - 0.05**2)
    t = found.time
    still = p.mass * 1.0 / p.stiffness
    decay = np.exp(-0.05 * w0 * t) * (np.cos(wd * t) + 0.05 * w0 / wd * np.sin(wd * t))
    np.testing.assert_allclose(found.drift, still * (1 - decay), atol=1e-10)
    np.testing.assert_allclose(found.slip + found.drift, t**2 / 2, atol=1e-9)


def test_a_thrown_block_drags_its_platform() -> None:
    """Momentum of a free pair: a very soft spring, the block stops on the platform."""
    soft = Platform.on_spring(1.0, period=1e4, stiffness=None, damping_ratio=0.0)
    found = sliding_on_platform(
        platform=soft,
        mass=2.0,
        friction=0.2,
        gravity=G,
        acceleration=lambda t: 0.0,
        end=1.0,
        step=1e-3,
        velocity=1.0,
    )
    assert found.drift_velocity[-1] == pytest.approx(2 / 3, rel=1e-5)
    # relative deceleration mu g (1 + m_L/m_P)
    assert found.slip[-1] == pytest.approx(1 / (2 * 0.2 * G * 3), rel=1e-5)


def law(**keys: float | bool) -> Resistance:
    return Resistance(law=FrictionSpec(static=0.6, **keys))  # type: ignore[arg-type]


def test_jump_of_friction_makes_stick_and_slip() -> None:
    """mu_s .6, mu_d .3 under slowly growing shaking: holds to .6, drops to .3, holds again."""

    def ground(time: float) -> float:
        return 0.1 * G * time * math.sin(2 * math.pi * time / 1.2)

    found = shaken(law(dynamic=0.3), 1.0, 8.0, acceleration=ground)
    slides = found.slip_velocity != 0
    begins = np.nonzero(~slides[:-1] & slides[1:])[0]
    ends = np.nonzero(slides[:-1] & ~slides[1:])[0]
    assert 1 <= len(begins) - len(ends) + 1 <= 2
    assert len(begins) >= 3
    # every slide from rest begins at mu_s g and goes on at mu_d g
    np.testing.assert_allclose(np.abs(found.friction[begins]), 0.6 * G, rtol=0.05)
    np.testing.assert_allclose(np.abs(found.friction[slides]), 0.3 * G, rtol=1e-12)
    assert np.abs(found.friction[~slides]).max() <= 0.6 * G * (1 + 1e-10)


def test_decay_of_friction_against_quadrature() -> None:
    """A thrown block under mu(v): time and distance are integrals over the velocity."""
    given = law(dynamic=0.2, decay=5.0)
    found = sliding(
        acceleration=lambda t: 0.0, friction=given, gravity=G, end=2.0, step=1e-3, velocity=2.0
    )
    speed = np.linspace(0, 2, 20001)
    slows = G * (0.2 + 0.4 * np.exp(-5.0 * speed))
    assert found.slip[-1] == pytest.approx(np.trapezoid(speed / slows, speed), rel=1e-7)
    stop = found.time[np.nonzero(found.velocity)[0][-1]]
    assert stop == pytest.approx(np.trapezoid(1 / slows, speed), abs=1.1e-3)


@pytest.mark.parametrize(("lost", "part"), [(False, 1.0), (True, 0.0)])
def test_cohesion(lost: bool, part: float) -> None:
    """It adds to what holds, and to what slows a sliding block unless it is lost."""
    given = Resistance(
        law=FrictionSpec(static=0.3, cohesion=1.0, cohesion_lost=lost), cohesion=0.1 * G
    )
    options: dict[str, Any] = {"friction": given, "gravity": G, "end": 2.0, "step": 1e-3}
    thrown = sliding(acceleration=lambda t: 0.0, velocity=2.0, **options)
    distance, _ = sliding_stop(speed=2.0, friction=0.3 + 0.1 * part, gravity=G)
    assert thrown.slip[-1] == pytest.approx(distance, rel=1e-9)
    assert not sliding(acceleration=lambda t: 0.39 * G, **options).slip.any()
    dragged = sliding(acceleration=lambda t: 0.41 * G, **options)
    assert dragged.slip[-1] == pytest.approx(-(0.11 - 0.1 * part) * G * 2.0**2 / 2, rel=1e-8)


def test_vertical_motion_changes_the_friction() -> None:
    """Upwards acceleration presses the block on: its deceleration is mu (g + a_v)."""
    found = sliding(
        acceleration=lambda t: 0.0,
        friction=0.2,
        gravity=G,
        end=2.0,
        step=1e-3,
        velocity=1.0,
        vertical=lambda t: 0.5 * G,
    )
    distance, _ = sliding_stop(speed=1.0, friction=0.2, gravity=1.5 * G)
    assert found.slip[-1] == pytest.approx(distance, rel=1e-9)


def test_closed_forms_of_newmark() -> None:
    a, duration = 0.5 * G, 0.25
    found = sliding(
        acceleration=lambda t: a if t <= duration else 0.0,
        friction=0.3,
        gravity=G,
        end=2.0,
        step=1e-3,
    )
    expected = sliding_block(acceleration=a, duration=duration, friction=0.3, gravity=G)
    assert found.slip[-1] == pytest.approx(-expected, rel=1e-8)
    assert sliding_block(acceleration=a, duration=duration, friction=0.6, gravity=G) == 0.0
    assert sliding_stop(speed=3.0, friction=0.5, gravity=10.0) == pytest.approx((0.9, 0.6))
    assert incline_distance(slope=0.1, friction=0.2, gravity=G, time=1.0) == 0.0
    slope = math.atan(0.75)
    assert incline_distance(slope=slope, friction=0.5, gravity=10.0, time=2.0) == pytest.approx(4.0)


def test_against_a_regularised_law() -> None:
    """An independent solution: friction mu g tanh(w/eps), one stiff ODE without events."""
    mu, eps, p = 0.2, 2e-5, PLATFORM

    def rates(time: float, y: Any) -> list[float]:
        ground = 0.4 * G * math.sin(2 * math.pi * time / 0.6)
        force = -mu * G * math.tanh(y[1] / eps)
        under = -ground - p.damping * y[3] - p.stiffness * y[2] - 2 * force
        return [y[1], force - ground - under, y[3], under]

    end = 1.2
    smooth = solve_ivp(rates, (0, end), [0.0] * 4, method="LSODA", rtol=1e-8, atol=1e-11)
    found = shaken(mu, 0.6, end)
    assert found.slip[-1] == pytest.approx(smooth.y[0, -1], abs=2e-5)
    assert found.drift[-1] == pytest.approx(smooth.y[2, -1], abs=2e-5)
