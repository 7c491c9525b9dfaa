"""The sliding block on ground and on platforms: closed forms, other programs, limits, laws."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from newmark import incline_distance, sliding_block, sliding_stop
from scipy.integrate import solve_ivp

from solver.excitation.sampled import SampledMotion
from solver.reference.sliding import Resistance, SlidingReference, coulomb, sliding
from solver.scene import FrictionSpec
from solver.scene.foundation import Platform

G = 9.81
PLATFORM = Platform.on_spring(1.0, period=0.5, stiffness=None, damping_ratio=0.05)


def slip(
    acceleration: Any, friction: float, end: float = 4.0, step: float = 1e-3
) -> SlidingReference:
    """On firm ground."""
    return sliding(acceleration=acceleration, friction=friction, gravity=G, end=end, step=step)


def half_sine(time: float) -> float:
    return 0.5 * G * math.sin(math.pi * time / 0.5) if time <= 0.5 else 0.0


def test_half_sine_pulse() -> None:
    # Independent programs (design, "What other programs do with the same cases", T3).
    found = slip(half_sine, 0.3, end=1.5)
    assert found.slip[-1] == pytest.approx(-0.0996332, abs=6e-8)
    assert found.slip_velocity[-1] == 0.0
    assert len(found.time) == 1501
    mirrored = slip(lambda time: -half_sine(time), 0.3, end=1.5)
    np.testing.assert_allclose(mirrored.slip, -found.slip, atol=1e-13)


def test_sticks_below_the_limit() -> None:
    assert not slip(half_sine, 0.5001).slip.any()
    assert slip(half_sine, 0.499).slip[-1] < 0


def test_starts_when_the_limit_is_passed() -> None:
    found = slip(half_sine, 0.3)
    begin = 0.5 / math.pi * math.asin(0.6)
    assert found.time[found.slip_velocity != 0][0] == pytest.approx(begin, abs=1e-3)
    assert found.time[found.slip_velocity != 0][0] > begin


def test_pulse_and_counterpulse() -> None:
    # Slides back, is caught while the ground pushes the other way, slides forward, is stopped.
    a, b, t1 = 0.5 * G, 0.2 * G, 0.3
    found = slip(lambda time: a if time <= t1 else (-a if time <= 2 * t1 else 0.0), 0.2)
    back = (a - b) * t1
    caught = back / (a + b)
    forward = (a - b) * (t1 - caught)
    expected = -(back**2) / 2 * (1 / (a - b) + 1 / (a + b)) + forward**2 / 2 * (1 / (a - b) + 1 / b)
    assert found.slip[-1] == pytest.approx(expected, rel=1e-7)


def test_without_friction_the_block_stays_in_space() -> None:
    found = slip(lambda time: math.sin(2 * math.pi * time), 0.0, end=1.0)
    w = 2 * math.pi
    ground = found.time / w - np.sin(w * found.time) / w**2
    np.testing.assert_allclose(found.slip, -ground, atol=1e-9)


def test_step_changes_the_output_times_only() -> None:
    coarse, fine = slip(half_sine, 0.3, step=0.01), slip(half_sine, 0.3, step=0.001)
    np.testing.assert_allclose(coarse.slip, fine.slip[::10], atol=1e-9)


def test_the_last_time_belongs_to_the_motion() -> None:
    """0.29/2e-4 steps end beyond 0.29 by round-off: the block must not jump back."""
    result = sliding(
        acceleration=lambda t: 0.2 * 9.81 * np.sin(4 * np.pi * t),
        friction=0.1,
        gravity=9.81,
        end=0.29,
        step=2e-4,
    )
    assert result.slip[-1] == pytest.approx(result.slip[-2], rel=1e-2)
    assert result.slip[-1] < -0.015


def shaken(
    friction: float | Resistance, period: float, end: float, **options: Any
) -> SlidingReference:
    """0.4 g, six cycles; the block twice as heavy as the platform."""

    def ground(time: float) -> float:
        return 0.4 * G * math.sin(2 * math.pi * time / period) if time <= 6 * period else 0.0

    arguments: dict[str, Any] = {"acceleration": ground, "step": 2e-3} | options
    return sliding(platform=PLATFORM, mass=2.0, friction=friction, gravity=G, end=end, **arguments)


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


def test_a_stiff_platform_is_the_ground() -> None:
    stiff = Platform.on_spring(1.0, period=2e-3, stiffness=None, damping_ratio=1.0)

    def ground(time: float) -> float:
        return 0.5 * G * math.sin(math.pi * time / 0.5) if time <= 0.5 else 0.0

    options: dict[str, Any] = {"acceleration": ground, "gravity": G, "end": 1.0, "step": 1e-3}
    found = sliding(platform=stiff, mass=2.0, friction=0.3, **options)
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
    found = sliding(
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
    stop = found.time[np.nonzero(found.slip_velocity)[0][-1]]
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


def shaking(step: float = 0.02, count: int = 150) -> SampledMotion:
    """Rough samples that begin and end with a jump, none of them at time 0."""
    time = 0.013 + step * np.arange(count)
    noise = np.random.default_rng(4).uniform(-1.0, 1.0, count)
    return SampledMotion(time=time, value=4.0 * np.cos(11.0 * time) + noise)


JUMP = Resistance(law=FrictionSpec(static=0.25, dynamic=0.12))
GLUE = Resistance(law=FrictionSpec(static=0.1, cohesion=1.0, cohesion_lost=True), cohesion=0.7)


def sampled(step: float = 5e-3, *, integrated: bool = False, **changes: Any) -> SlidingReference:
    """Under rough samples, in closed form or integrated."""
    given: dict[str, Any] = {
        "platform": Platform.on_spring(500.0, period=0.5, stiffness=None, damping_ratio=0.05),
        "mass": 1000.0,
        "friction": coulomb(0.1),
        "gravity": 9.81,
        "end": 3.2,
    }
    motion = shaking()
    return sliding(
        acceleration=motion.acceleration if integrated else motion, step=step, **given | changes
    )


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"friction": JUMP, "along": -0.4},
        {"friction": GLUE},
        {"friction": coulomb(0.0), "velocity": 0.3},
        {"friction": coulomb(5.0), "velocity": -0.2},
        {"platform": Platform.on_spring(500.0, period=0.5, stiffness=None, damping_ratio=1.4)},
        {"platform": None},
        {"platform": None, "friction": JUMP, "velocity": 0.5},
    ],
)
def test_it_agrees_with_the_integrator(changes: dict[str, Any]) -> None:
    """Every number, to what the integrator gives: it steps over the kinks of the samples."""
    one = sampled(**changes)
    other = sampled(**changes, integrated=True)
    for name in ("slip", "slip_velocity", "drift", "drift_velocity", "friction"):
        exact, found = getattr(other, name), getattr(one, name)
        # Friction jumps where the slip rate changes its sign, maybe just before an output time.
        good = np.abs(found - exact) < 1e-6 * max(np.abs(exact).max(), 1e-3)
        assert good.sum() >= len(good) - (2 if name == "friction" else 0), name
    assert np.abs(other.drift).max() > 0.01 or changes.get("platform", 0) is None
    np.testing.assert_array_equal(one.time, other.time)


def test_it_does_not_depend_on_the_output_step() -> None:
    fine, coarse = sampled(step=1e-3), sampled(step=0.05)
    for name in ("slip", "slip_velocity", "drift", "drift_velocity", "drift_acceleration"):
        np.testing.assert_allclose(
            getattr(fine, name)[::50], getattr(coarse, name), rtol=0, atol=1e-11
        )
