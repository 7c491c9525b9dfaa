"""The rigid rocking reference against tables, quadrature and closed forms."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from geometry.block import Block
from solver.reference.housner import housner, housner_restitution

G = 9.81
SPECIMEN = Block(width=0.25, height=1.0, thickness=0.75, density=503.0 / 0.1875)
ALPHA = SPECIMEN.slenderness
P = SPECIMEN.frequency(G)

# Specimen 1 of Pena et al. (2007) from 3 degrees: e, times of impacts (s), peaks (degrees)
FREE = [
    (
        None,
        [0.1916, 0.5305, 0.8323, 1.1024, 1.3451, 1.5637, 1.7612],
        [3, 2.440, 1.994, 1.636, 1.345, 1.109, 0.915],
    ),
    (
        0.93,
        [0.1916, 0.5393, 0.8563, 1.1462, 1.4122, 1.6567, 1.8819],
        [3, 2.550, 2.174, 1.858, 1.591, 1.364, 1.172],
    ),
    (
        0.95,
        [0.1916, 0.5492, 0.8837, 1.1972, 1.4916, 1.7683, 2.0289],
        [3, 2.673, 2.386, 2.133, 1.908, 1.710, 1.533],
    ),
]


def free(tilt, restitution=None, end=2.2, step=0.01):
    return housner(SPECIMEN, gravity=G, tilt=tilt, end=end, step=step, restitution=restitution)


def forced(acceleration, end=2.0, step=2e-3):
    return housner(SPECIMEN, gravity=G, end=end, step=step, acceleration=acceleration)


@pytest.mark.parametrize(("restitution", "impacts", "peaks"), FREE)
def test_free_rocking(restitution, impacts, peaks):
    found = free(math.radians(3), restitution)
    np.testing.assert_allclose(found.impacts[:7], impacts, atol=6e-5)
    alternating = np.array(peaks) * (-1.0) ** np.arange(7)
    np.testing.assert_allclose(np.degrees(found.peaks[:7]), alternating, atol=6e-4)
    assert not found.overturned


def test_first_quarter_by_quadrature():
    # w^2 / 2 = p^2 (cos(alpha - theta) - cos(alpha - theta_0)); theta = theta_0 - x^2: no pole
    start = math.radians(3)

    def slowness(x):
        energy = P**2 * (math.cos(ALPHA - start + x**2) - math.cos(ALPHA - start))
        return 2 * x / math.sqrt(2 * abs(energy))

    expected, _ = quad(slowness, 0, math.sqrt(start), epsabs=1e-12)
    assert free(start, end=0.3).impacts[0] == pytest.approx(expected, abs=1e-8)


def test_peaks_follow_from_the_energy_at_impacts():
    found = free(math.radians(3))
    e = housner_restitution(SPECIMEN)
    barrier = math.cos(ALPHA)
    energies = np.cos(ALPHA - np.abs(found.peaks)) - barrier
    np.testing.assert_allclose(energies[1:8] / energies[:7], e**2, rtol=1e-7)


def test_directions_are_mirror_images():
    one, other = free(math.radians(3)), free(-math.radians(3))
    np.testing.assert_allclose(one.angle, -other.angle, atol=1e-12)
    np.testing.assert_allclose(one.impacts, other.impacts, atol=1e-12)


def test_velocity_is_the_derivative_of_the_angle():
    found = free(math.radians(3), step=1e-4, end=0.5)
    slope = np.gradient(found.angle, found.time)
    away = np.abs(found.time - found.impacts[0]) > 3e-4
    np.testing.assert_allclose(slope[away][1:-1], found.angular_velocity[away][1:-1], atol=2e-6)


def test_comes_to_rest():
    found = free(math.radians(0.5), restitution=0.5, end=3.0)
    assert found.angle[-1] == 0.0
    assert found.angular_velocity[-1] == 0.0
    assert 5 < len(found.impacts) < 60
    assert len(free(math.radians(3), restitution=0.0).impacts) == 1


def test_beyond_slenderness_it_overturns_and_stays():
    found = free(ALPHA + 0.01, end=4.0)
    assert found.overturned
    assert found.angle[-1] == pytest.approx(math.pi / 2)
    assert found.angular_velocity[-1] == 0.0
    assert not len(found.impacts)
    assert not free(ALPHA - 0.01, end=4.0).overturned


def test_uplift_needs_g_times_width_over_height():
    assert not forced(lambda time: 0.2499 * G).angle.any()
    pushed = forced(lambda time: 0.2501 * G if time < 0.3 else 0.0)
    # The ground goes to +x, so the block leans to -x.
    assert pushed.angle.min() < 0
    assert pushed.angle[:100].max() == 0


def test_initial_acceleration_after_shenton():
    a, b, h = 0.6 * G, 0.125, 0.5
    found = housner(SPECIMEN, gravity=G, end=1e-3, step=1e-3, acceleration=lambda time: a)
    expected = 0.75 * (a * h - G * b) / (b**2 + h**2)
    assert -found.angular_velocity[-1] / 1e-3 == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize(("ratio", "limit"), [(2.0, 1.801), (4.0, 2.797)])
def test_overturning_by_a_half_sine(ratio, limit):
    # Nonlinear specimen 1 without impact, in units of g tan(alpha), frequency over p = ratio.
    frequency = ratio * P

    def pulse(amplitude):
        size = amplitude * G * math.tan(ALPHA)
        return lambda time: size * math.sin(frequency * time) if frequency * time < math.pi else 0.0

    assert not forced(pulse(limit - 1e-3), end=5.0).overturned
    beyond = forced(pulse(limit + 1e-3), end=5.0)
    assert beyond.overturned
    assert not len(beyond.impacts)
    assert beyond.angle[-1] == pytest.approx(-math.pi / 2)


def test_refuses():
    with pytest.raises(ValueError, match=r"restitution=1\.1"):
        free(0.1, restitution=1.1)
    with pytest.raises(ValueError, match="tilt"):
        free(2.0)


def test_constant_vertical_acceleration_is_more_gravity():
    """Yim, Chopra and Penzien: g becomes g + a_v, for the motion as for the uplift."""
    more = housner(
        SPECIMEN, gravity=G, tilt=0.05, end=2.0, step=2e-3, vertical=lambda time: 0.3 * G
    )
    heavy = housner(SPECIMEN, gravity=1.3 * G, tilt=0.05, end=2.0, step=2e-3)
    np.testing.assert_allclose(more.angle, heavy.angle, atol=1e-9)
    for push, lifts in ((0.324 * G, False), (0.326 * G, True)):
        found = housner(
            SPECIMEN,
            gravity=G,
            end=0.5,
            step=2e-3,
            acceleration=lambda time, push=push: push,
            vertical=lambda time: 0.3 * G,
        )
        assert found.angle.any() == lifts


def test_vertical_harmonic_by_another_integration():
    """The first swing, by the classical Runge-Kutta method."""

    def heave(time):
        return 0.4 * G * math.sin(2 * math.pi * time / 0.13 + 0.4)

    def rate(time, state):
        pull = 3 / (4 * SPECIMEN.half_diagonal) * (G + heave(time))
        return np.array([state[1], -pull * math.sin(ALPHA - state[0])])

    state, dt = np.array([math.radians(3), 0.0]), 1e-4
    for k in range(1500):
        t = k * dt
        a = rate(t, state)
        b = rate(t + dt / 2, state + dt / 2 * a)
        c = rate(t + dt / 2, state + dt / 2 * b)
        state = state + dt / 6 * (a + 2 * b + 2 * c + rate(t + dt, state + dt * c))
    found = housner(SPECIMEN, gravity=G, tilt=math.radians(3), end=0.15, step=1e-3, vertical=heave)
    assert not len(found.impacts)
    assert found.angle[-1] == pytest.approx(state[0], abs=1e-10)
    assert found.angular_velocity[-1] == pytest.approx(state[1], abs=1e-9)
