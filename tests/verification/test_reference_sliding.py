"""The stick-slip reference against Newmark's closed forms and an independent program's number."""

import math

import numpy as np
import pytest

from solver.reference.sliding import sliding

G = 9.81


def slip(acceleration, friction, end=4.0, step=1e-3):
    return sliding(acceleration=acceleration, friction=friction, gravity=G, end=end, step=step)


def half_sine(time):
    return 0.5 * G * math.sin(math.pi * time / 0.5) if time <= 0.5 else 0.0


def test_half_sine_pulse():
    # Independent programs (design, "What other programs do with the same cases", T3).
    found = slip(half_sine, 0.3, end=1.5)
    assert found.slip[-1] == pytest.approx(-0.0996332, abs=6e-8)
    assert found.velocity[-1] == 0.0
    assert len(found.time) == 1501
    mirrored = slip(lambda time: -half_sine(time), 0.3, end=1.5)
    np.testing.assert_allclose(mirrored.slip, -found.slip, atol=1e-13)


def test_sticks_below_the_limit():
    assert not slip(half_sine, 0.5001).slip.any()
    assert slip(half_sine, 0.499).slip[-1] < 0


def test_starts_when_the_limit_is_passed():
    found = slip(half_sine, 0.3)
    begin = 0.5 / math.pi * math.asin(0.6)
    assert found.time[found.velocity != 0][0] == pytest.approx(begin, abs=1e-3)
    assert found.time[found.velocity != 0][0] > begin


@pytest.mark.parametrize("friction", [0.1, 0.3, 0.45])
def test_rectangular_pulse(friction):
    # Newmark's sliding block: V = a t1, slip = V^2 / (2 mu g) (1 - mu g / a), backwards.
    a, duration = 0.5 * G, 0.25
    found = slip(lambda time: a if time <= duration else 0.0, friction)
    speed = a * duration
    expected = speed**2 / (2 * friction * G) * (1 - friction * G / a)
    assert found.slip[-1] == pytest.approx(-expected, rel=1e-8)
    stop = np.nonzero(found.velocity)[0][-1]
    assert found.time[stop] == pytest.approx(speed / (friction * G), abs=1.1e-3)


def test_pulse_and_counterpulse():
    # Slides back, is caught while the ground pushes the other way, slides forward, is stopped.
    a, b, t1 = 0.5 * G, 0.2 * G, 0.3
    found = slip(lambda time: a if time <= t1 else (-a if time <= 2 * t1 else 0.0), 0.2)
    back = (a - b) * t1
    caught = back / (a + b)
    forward = (a - b) * (t1 - caught)
    expected = -(back**2) / 2 * (1 / (a - b) + 1 / (a + b)) + forward**2 / 2 * (1 / (a - b) + 1 / b)
    assert found.slip[-1] == pytest.approx(expected, rel=1e-7)


def test_without_friction_the_block_stays_in_space():
    found = slip(lambda time: math.sin(2 * math.pi * time), 0.0, end=1.0)
    w = 2 * math.pi
    ground = found.time / w - np.sin(w * found.time) / w**2
    np.testing.assert_allclose(found.slip, -ground, atol=1e-9)


def test_step_changes_the_output_times_only():
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
