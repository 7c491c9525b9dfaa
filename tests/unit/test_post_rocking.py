"""Swings, their ends and peaks, against the closed form of slender rocking (Housner 1963)."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from geometry.block import Block
from solver.results import rocking

Array = NDArray[np.float64]


def impacts(time: Array, angle: Array) -> list[float]:
    """Times at which swings end."""
    found = rocking.swings(time, angle, ALPHA)
    return [rocking.end_of(s, time, angle)[1] for s in found if s.last < len(time) - 1]


SHAPE = Block(width=0.25, height=1.0, thickness=0.75, density=503.0 / 0.1875)
GRAVITY = 9.81
ALPHA = SHAPE.slenderness()


def linear_rocking(
    start: float, restitution: float, swings: int
) -> tuple[list[float], list[float]]:
    """Impact times and peaks of the linear slender block (Housner 1963).

    First quarter acosh(1/(1 - phi))/p, phi = theta/alpha;
    peaks phi' = 1 - sqrt(1 - e^2 (1 - (1 - phi)^2)).
    """
    p = SHAPE.frequency(GRAVITY)
    phi, time = start / ALPHA, 0.0
    times, peaks = [], [start]
    for _ in range(swings):
        quarter = math.acosh(1 / (1 - phi)) / p
        time += quarter
        times.append(time)
        phi = 1 - math.sqrt(1 - restitution**2 * (1 - (1 - phi) ** 2))
        time += math.acosh(1 / (1 - phi)) / p
        peaks.append(phi * ALPHA)
    return times, peaks


def linear_history(times: list[float], peaks: list[float], step: float) -> tuple[Array, Array]:
    """The angle theta = +-[alpha - (alpha - peak) cosh(p (t - t_peak))] of that motion."""
    p = SHAPE.frequency(GRAVITY)
    t = np.arange(0, times[-1] - 0.01, step)
    angle = np.empty_like(t)
    tops = [0.0]
    for time, peak in zip(times, peaks[1:], strict=True):
        tops.append(time + math.acosh(1 / (1 - peak / ALPHA)) / p)
    for i, now in enumerate(t):
        k = sum(time <= now for time in times)
        arc = ALPHA - (ALPHA - peaks[k]) * math.cosh(p * (now - tops[k]))
        angle[i] = (-1) ** k * arc
    return t, angle


def test_impacts_and_peaks_of_linear_rocking() -> None:
    """Times and peaks to the error of a parabola through rows 1 ms apart."""
    times, peaks = linear_rocking(math.radians(3), 0.9, 6)
    t, angle = linear_history(times, peaks, 1e-3)
    np.testing.assert_allclose(impacts(t, angle), times[:-1], atol=2e-8)
    turned = rocking.peaks(t, angle, ALPHA)
    signs = (-1.0) ** np.arange(6)
    np.testing.assert_allclose([a for _, a in turned], signs * peaks[:6], rtol=2e-6)


def test_impact_times_do_not_depend_on_where_the_rows_lie() -> None:
    """The kink falls anywhere between two rows; a straight line across it would err by 2e-5 s."""
    times, peaks = linear_rocking(math.radians(3), 0.9, 6)
    for step in (9.7e-4, 1e-3, 1.03e-3, 1.1e-3):
        t, angle = linear_history(times, peaks, step)
        np.testing.assert_allclose(impacts(t, angle), times[:-1], atol=2e-8)


def test_impact_of_a_swing_of_few_rows() -> None:
    """Two rows before the zero tell no parabola: the straight line between the rows."""
    t = np.array([0.0, 0.1, 0.2, 0.3, 0.4])
    angle = ALPHA * np.array([0.0, 0.3, 0.1, -0.1, -0.3])
    assert impacts(t, angle)[0] == pytest.approx(0.25)


def test_a_bounce_on_the_same_side_is_an_impact() -> None:
    """A squat block may come back to the side from which it fell."""
    t = np.linspace(0, 2, 2001)
    angle = 0.02 * np.abs(np.cos(math.pi * t / 2)) + 1e-7
    assert impacts(t, angle) == pytest.approx([1.0], abs=1e-3)


def test_noise_of_a_block_at_rest_is_no_rocking() -> None:
    """Movements below the stated part of alpha are not counted, whatever their number."""
    rng = np.random.default_rng(3)
    t = np.linspace(0, 1, 1001)
    angle = 0.9 * rocking.SMALLEST_SWING * ALPHA * rng.uniform(-1, 1, 1001)
    assert rocking.swings(t, angle, ALPHA) == []


def test_rocking_to_rest_ends_with_an_impact() -> None:
    """The last swing ends where it first meets zero, not somewhere in the long rest."""
    t = np.linspace(0, 3, 3001)
    angle = np.where(t < 1, 0.02 * np.cos(math.pi * t / 2), 1e-8 * np.sin(40 * (t - 1)))
    assert impacts(t, angle) == pytest.approx([1.0], abs=2e-3)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_peak_of_a_parabola_is_exact_whatever_the_distances_of_its_rows(side: float) -> None:
    for t in (np.array([0.0, 0.3, 0.5, 1.2, 1.5]), np.array([0.0, 0.1, 0.65, 0.8, 1.4])):
        angle = side * (0.05 - 0.04 * (t - 0.6) ** 2)
        ((at, peak),) = rocking.peaks(t, angle, ALPHA)
        assert at == pytest.approx(0.6, rel=1e-12)
        assert peak == pytest.approx(side * 0.05, rel=1e-12)


def test_where_the_parabola_meets_zero_too_late_the_line_between_rows_tells_the_impact() -> None:
    """After 0.30, 0.29, 0.27 it would at a row later; from 0.27 to -0.18 it is 0.6 of the step."""
    t = 0.1 * np.arange(7)
    angle = ALPHA * np.array([0.1, 0.3, 0.29, 0.27, -0.18, -0.2, -0.1])
    assert impacts(t, angle)[0] == pytest.approx(0.36)


def test_a_block_beyond_return_is_beyond_its_point_of_balance() -> None:
    """2 alpha; 89 degrees of a squat one; alpha of a plate whose diagonal is flatter than that."""
    for degrees, lost in ((14.0, 28.0), (44.0, 88.0), (60.0, 89.0), (89.5, 89.5)):
        assert rocking.no_return(math.radians(degrees)) == pytest.approx(math.radians(lost))
