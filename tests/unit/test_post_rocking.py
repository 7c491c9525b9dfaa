"""Swings, impacts and modes, against the closed form of slender rocking (Housner 1963)."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from geometry.block import Block
from solver.results import rocking
from solver.results.angular_velocity import rigid_moment, rocking_acceleration

Array = NDArray[np.float64]
SHAPE = Block(width=0.25, height=1.0, thickness=0.75, density=503.0 / 0.1875)
GRAVITY = 9.81
ALPHA = SHAPE.slenderness


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
    found = rocking.impacts(t, angle, SHAPE, GRAVITY)
    np.testing.assert_allclose([i.time_s for i in found], times[:-1], atol=2e-8)
    turned = rocking.peaks(t, angle, ALPHA)
    signs = (-1.0) ** np.arange(6)
    np.testing.assert_allclose([a for _, a in turned], signs * peaks[:6], rtol=2e-6)


def test_impact_times_do_not_depend_on_where_the_rows_lie() -> None:
    """The kink falls anywhere between two rows; a straight line across it would err by 2e-5 s."""
    times, peaks = linear_rocking(math.radians(3), 0.9, 6)
    for step in (9.7e-4, 1e-3, 1.03e-3, 1.1e-3):
        t, angle = linear_history(times, peaks, step)
        found = rocking.impacts(t, angle, SHAPE, GRAVITY)
        np.testing.assert_allclose([i.time_s for i in found], times[:-1], atol=2e-8)


def test_impact_of_a_swing_of_few_rows() -> None:
    """Two rows before the zero tell no parabola: the straight line between the rows."""
    t = np.array([0.0, 0.1, 0.2, 0.3, 0.4])
    angle = ALPHA * np.array([0.0, 0.3, 0.1, -0.1, -0.3])
    assert rocking.impacts(t, angle, SHAPE, GRAVITY)[0].time_s == pytest.approx(0.25)


def test_restitution_from_exact_peaks() -> None:
    """With peaks that conserve Housner's energy between impacts, e comes out as it went in."""
    e, peak = 0.9118, math.radians(3)
    alpha = ALPHA
    energies = [math.cos(alpha - peak) - math.cos(alpha)]
    tops = [peak]
    for _ in range(4):
        energies.append(e**2 * energies[-1])
        tops.append(alpha - math.acos(energies[-1] + math.cos(alpha)))
    # triangular swings with these peaks: the restitution depends on the peaks only
    t = np.linspace(0, 9, 9001)
    nodes_t = [0.0] + [1.0 + k for k in range(9)]
    nodes_a = [tops[0], 0, -tops[1], 0, tops[2], 0, -tops[3], 0, tops[4], 0]
    angle = np.interp(t, nodes_t, nodes_a)
    found = rocking.impacts(t, angle, SHAPE, GRAVITY)
    assert [i.restitution for i in found[:4]] == pytest.approx([e] * 4, rel=1e-3)
    assert [i.time_s for i in found[:4]] == pytest.approx([1, 3, 5, 7], abs=1e-3)


def test_restitution_of_a_swing_that_is_not_over_is_unknown() -> None:
    """The record ends before the second peak."""
    t = np.linspace(0, 1, 101)
    angle = 0.05 * np.cos(1.2 * math.pi * t / 2)
    found = rocking.impacts(t, angle, SHAPE, GRAVITY)
    assert len(found) == 1
    assert found[0].time_s == pytest.approx(1 / 1.2, abs=1e-4)
    assert found[0].restitution is None


def test_a_bounce_on_the_same_side_is_an_impact() -> None:
    """A squat block may come back to the side from which it fell."""
    t = np.linspace(0, 2, 2001)
    angle = 0.02 * np.abs(np.cos(math.pi * t / 2)) + 1e-7
    found = rocking.impacts(t, angle, SHAPE, GRAVITY)
    assert [i.time_s for i in found] == pytest.approx([1.0], abs=1e-3)
    assert found[0].restitution is None  # the second peak is the last row


def test_noise_of_a_block_at_rest_is_no_rocking() -> None:
    """Movements below the stated part of alpha are not counted, whatever their number."""
    rng = np.random.default_rng(3)
    t = np.linspace(0, 1, 1001)
    angle = 0.9 * rocking.SMALLEST_SWING * ALPHA * rng.uniform(-1, 1, 1001)
    assert rocking.swings(t, angle, ALPHA) == []
    assert rocking.impacts(t, angle, SHAPE, GRAVITY) == []


def test_rocking_to_rest_ends_with_an_impact() -> None:
    """The last swing ends where it first meets zero, not somewhere in the long rest."""
    t = np.linspace(0, 3, 3001)
    angle = np.where(t < 1, 0.02 * np.cos(math.pi * t / 2), 1e-8 * np.sin(40 * (t - 1)))
    found = rocking.impacts(t, angle, SHAPE, GRAVITY)
    assert len(found) == 1
    assert found[0].time_s == pytest.approx(1.0, abs=2e-3)
    assert found[0].restitution == pytest.approx(0, abs=1e-2)


def test_rocking_energy_is_that_of_the_raised_centre() -> None:
    """m g (height of the centre above upright) over 4/3 m R^2."""
    angle = 0.1
    centre = np.array([-SHAPE.width / 2, SHAPE.height / 2])  # from the right corner
    turned = math.cos(angle) * centre[1] - math.sin(angle) * centre[0]
    work = SHAPE.weight(GRAVITY) * (turned - centre[1])
    expected = work / SHAPE.rotary_inertia_about_corner
    assert rocking.rocking_energy(angle, SHAPE, GRAVITY) == pytest.approx(expected)


def housner(
    e: float, start: float, end: float, step: float, base: Callable[[float], float]
) -> tuple[Array, ...]:
    """Time, angle and acceleration of the base: Housner's block by an integrator of its own."""
    rows, angle, velocity, fine = [], start, 0.0, 1e-5
    for k in range(round(end / fine)):
        t = k * fine
        if k % round(step / fine) == 0:
            rows.append((t, angle, base(t)))
        torque = math.copysign(GRAVITY * math.sin(ALPHA - abs(angle)), angle)
        torque += base(t) * math.cos(ALPHA - abs(angle))
        velocity -= fine * 3 / (4 * SHAPE.half_diagonal) * torque
        after = angle + fine * velocity
        if after * angle < 0:
            velocity *= e
        angle = after
    time, angles, along = map(np.array, zip(*rows, strict=True))
    return time, angles, along


@pytest.mark.parametrize("step", [1e-3, 5e-3])
def test_restitution_on_a_base_that_moves_is_read_next_to_the_impact(step: float) -> None:
    """Housner's block on a base that accelerates like a sine."""
    e = 0.9
    time, angles, base = housner(e, 0.06, 1.2, step, lambda t: 1.2 * math.sin(4 * math.pi * t))
    free = rocking_acceleration(angles, SHAPE, base, np.full_like(base, GRAVITY))
    found = [i.restitution for i in rocking.impacts(time, angles, SHAPE, GRAVITY, free)]
    assert len(found) >= 3
    assert found[:2] == pytest.approx([e] * 2, abs=2e-3 if step > 2e-3 else 5e-4)
    still = rocking.impacts(time, angles, SHAPE, GRAVITY)[0]
    assert still.restitution is None and still.reason == rocking.FASTER
    assert still.ratio is not None and still.ratio > e + 0.05, "peaks tell what the base did"


def test_a_swing_that_follows_a_smaller_one_says_nothing_of_an_impact() -> None:
    """Swings that come and go, many of them too small to be counted."""
    e = 0.8

    def base(t: float) -> float:
        return 1.5 * GRAVITY * ALPHA * max(0.0, math.sin(4 * t)) * math.sin(30 * t)

    time, angles, along = housner(e, 1.3e-3, 6.0, 1e-3, base)
    free = rocking_acceleration(angles, SHAPE, along, np.full_like(along, GRAVITY))
    found = [i.restitution for i in rocking.impacts(time, angles, SHAPE, GRAVITY, free)]
    read = [ratio for ratio in found if ratio is not None]
    assert len(read) > 10 and len(read) < len(found) - 1
    assert read == pytest.approx([e] * len(read), abs=0.01)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_peak_of_a_parabola_is_exact_whatever_the_distances_of_its_rows(side: float) -> None:
    for t in (np.array([0.0, 0.3, 0.5, 1.2, 1.5]), np.array([0.0, 0.1, 0.65, 0.8, 1.4])):
        angle = side * (0.05 - 0.04 * (t - 0.6) ** 2)
        ((at, peak),) = rocking.peaks(t, angle, ALPHA)
        assert at == pytest.approx(0.6, rel=1e-12)
        assert peak == pytest.approx(side * 0.05, rel=1e-12)


CUBIC = np.polynomial.Polynomial([0.02, -0.3, 0.8, -1.1])
"""An angle whose acceleration changes evenly."""


@pytest.mark.parametrize("rows", [[0.2, 0.3, 0.55, 0.7, 1.1], [1.1, 1.3, 1.4, 1.9]])
@pytest.mark.parametrize("end", [0, -1])
def test_a_cubic_angle_is_read_exactly_at_either_end_of_coarse_rows(
    rows: list[float], end: int
) -> None:
    t = np.array(rows)
    found = rigid_moment(t, CUBIC(t), CUBIC.deriv(2)(t), rows[end])
    assert found is not None
    assert found.angle == pytest.approx(CUBIC(rows[end]), rel=1e-10)
    assert found.velocity == pytest.approx(CUBIC.deriv()(rows[end]), rel=1e-10)


@pytest.mark.parametrize("at", [0.1, 1.25])
def test_an_impact_between_rows_is_read_exactly_from_a_steady_acceleration(at: float) -> None:
    """A parabola, 0.1 s before the first row and 0.15 s after the last one."""
    angle = CUBIC.cutdeg(2)
    t = np.array([0.2, 0.3, 0.55, 0.7, 1.1])
    found = rigid_moment(t, angle(t), angle.deriv(2)(t) + 0 * t, at)
    assert found is not None
    assert found.angle == pytest.approx(angle(at), rel=1e-10)
    assert found.velocity == pytest.approx(angle.deriv()(at), rel=1e-10)


def test_what_an_impact_does_to_a_base_that_gives_way_is_no_acceleration_of_the_block() -> None:
    """For 0.01/p after each impact the platform's acceleration is that of the impact, 60 g."""
    e = 0.9
    time, angles, base = housner(e, 0.06, 1.2, 5e-4, lambda t: 0.3 * math.sin(4 * math.pi * t))
    free = rocking_acceleration(angles, SHAPE, base, np.full_like(base, GRAVITY))
    for impact in rocking.impacts(time, angles, SHAPE, GRAVITY, free):
        since = time - impact.time_s
        free[(since >= 0) & (since < 0.01 / SHAPE.frequency(GRAVITY))] += 600.0
    given = [
        [i.restitution for i in rocking.impacts(time, angles, SHAPE, GRAVITY, free, gives_way=w)]
        for w in (True, False)
    ]
    assert given[0][:2] == pytest.approx([e] * 2, abs=2e-3)
    assert given[1][0] is None or abs(given[1][0] - e) > 0.05


@pytest.mark.parametrize(("aside", "known"), [(0.009, True), (0.02, False)])
@pytest.mark.parametrize("swing", [0, 1, 2])
def test_a_block_that_rolls_in_a_swing_beside_an_impact_has_no_restitution_there(
    aside: float, known: bool, swing: int
) -> None:
    """Triangular swings of 0.04 rad; it leans out of their plane by a part of that in one swing."""
    t = np.linspace(0, 6, 601)
    angle = np.interp(t, [0, 1, 3, 5, 6], [0.04, 0.0, 0.0, 0.0, -0.04])
    angle += 0.04 * (np.interp(t, [3, 4, 5], [0, 1, 0]) - np.interp(t, [1, 2, 3], [0, 1, 0]))
    out = np.where(np.abs(t - 2 * swing) < 0.5, aside * 0.04, 0.0)
    found = rocking.impacts(t, angle, SHAPE, GRAVITY, aside=out)
    assert [i.time_s for i in found[:2]] == pytest.approx([1.0, 3.0], abs=1e-9)
    for number, impact in enumerate(found[:2]):
        rolls = not known and swing in (number, number + 1)
        assert (impact.restitution is None) is rolls


def test_where_the_parabola_meets_zero_too_late_the_line_between_rows_tells_the_impact() -> None:
    """After 0.30, 0.29, 0.27 it would at a row later; from 0.27 to -0.18 it is 0.6 of the step."""
    t = 0.1 * np.arange(7)
    angle = ALPHA * np.array([0.1, 0.3, 0.29, 0.27, -0.18, -0.2, -0.1])
    assert rocking.impacts(t, angle, SHAPE, GRAVITY)[0].time_s == pytest.approx(0.36)


def _comes_to_rest(end: float) -> list[rocking.Impact]:
    """From 0.5 alpha to zero within 1 s, then half the smallest swing, which dies out."""
    t = np.linspace(0, end, round(100 * end) + 1)
    small = 0.5 * rocking.SMALLEST_SWING
    part = np.interp(t, [0, 1, 1.5, 2], [0.5, 0.0, -small, 0.0])
    return rocking.impacts(t, ALPHA * part, SHAPE, GRAVITY)


def test_movements_smaller_than_a_swing_tell_the_restitution_once_they_had_time() -> None:
    """Their largest angle counts, not their last one; they need twice the time of the fall."""
    (soon,), (late,) = _comes_to_rest(2.8), _comes_to_rest(3.2)
    assert soon.restitution is None
    small = 0.5 * rocking.SMALLEST_SWING
    energies = [math.cos((1 - x) * ALPHA) - math.cos(ALPHA) for x in (small, 0.5)]
    assert late.restitution == pytest.approx(math.sqrt(energies[0] / energies[1]), rel=1e-9)


def test_between_peaks_beyond_return_no_energy_tells_the_restitution() -> None:
    """Beyond 2 alpha it has less energy than upright."""
    t = np.linspace(0, 4, 401)
    for first, second in ((0.5, -2.5), (2.5, -0.5)):
        angle = ALPHA * np.interp(t, [0, 1, 2, 3, 4], [first, 0, second, 0, 0.5])
        assert rocking.impacts(t, angle, SHAPE, GRAVITY)[0].restitution is None


def test_a_block_beyond_return_is_beyond_its_point_of_balance() -> None:
    """2 alpha; 89 degrees of a squat one; alpha of a plate whose diagonal is flatter than that."""
    for degrees, lost in ((14.0, 28.0), (44.0, 88.0), (60.0, 89.0), (89.5, 89.5)):
        assert rocking.no_return(math.radians(degrees)) == pytest.approx(math.radians(lost))


def damped_rocking(
    drag: float, restitution: float, push: Callable[[float], float]
) -> tuple[Array, Array]:
    """Times and angles of Housner's equation with -lambda theta', up to its fifth impact."""
    square = SHAPE.frequency(GRAVITY) ** 2
    time, state, times, angles = 0.0, [math.radians(3), 0.0], [np.zeros(0)], [np.zeros(0)]
    for swing in range(5):
        side = (-1) ** swing

        def rate(t: float, y: Array, side: float = side) -> list[float]:
            lean = ALPHA - side * y[0]
            pull = side * math.sin(lean) + push(t) / GRAVITY * math.cos(lean)
            return [y[1], -square * pull - drag * y[1]]

        def lands(t: float, y: Array, side: float = side, since: float = time) -> float:
            return float(y[0]) if t > since + 1e-6 else side

        setattr(lands, "terminal", True)
        exact = {"rtol": 1e-11, "atol": 1e-13, "max_step": 2e-3}
        found = solve_ivp(rate, (time, time + 5), state, events=lands, **exact)
        times.append(found.t[:-1])
        angles.append(found.y[0, :-1])
        time, state = float(found.t[-1]), [0.0, restitution * float(found.y[1, -1])]
    whole = np.concatenate(times)
    new = np.diff(whole, prepend=-1.0) > 0
    return whole[new], np.concatenate(angles)[new]


@pytest.mark.parametrize("drag", [0.5, 3.0])
def test_what_damping_takes_in_swings_is_no_loss_of_impacts(drag: float) -> None:
    """Read from peaks without it, restitution is 0.86 and 0.56."""
    time, angle = damped_rocking(drag, 0.92, lambda t: 0.0)
    found = rocking.impacts(time, angle, SHAPE, GRAVITY, drag=drag)
    known = [impact.restitution for impact in found[:3]]
    assert known == pytest.approx([0.92] * 3, abs=1e-4)
    ignored = rocking.impacts(time, angle, SHAPE, GRAVITY)[0].restitution
    assert ignored is not None and ignored < 0.9


@pytest.mark.parametrize("share", [0.01, 0.5, 0.95])
@pytest.mark.parametrize("drag", [-3.0, -0.5, 1e-12, 0.5, 3.0])
def test_speed_at_an_impact_after_a_swing_with_drag(share: float, drag: float) -> None:
    """The same by the equation over time; without drag that of the energy."""
    peak, square = share * ALPHA, SHAPE.frequency(GRAVITY) ** 2

    def lands(t: float, y: Array) -> float:
        return float(y[0])

    setattr(lands, "terminal", True)
    (end,) = solve_ivp(
        lambda t, y: [y[1], -square * math.sin(ALPHA - y[0]) - drag * y[1]],
        (0, 20), [peak, 0.0], events=lands, rtol=1e-11, atol=1e-14,
    ).y_events[0]  # fmt: skip
    found = rocking.speed_at_impact(peak, SHAPE, GRAVITY, drag)
    assert found == pytest.approx(-end[1], rel=1e-6)
    assert math.isnan(rocking.speed_at_impact(1.01 * ALPHA, SHAPE, GRAVITY, drag))


@pytest.mark.parametrize(("part", "hops"), [(0.14, False), (0.16, True)])
def test_a_block_that_hops_has_no_restitution(part: float, hops: bool) -> None:
    """Its peaks have lost what is in the hop: a part of its energy at the peak before."""
    time, angle = linear_history(*linear_rocking(math.radians(3), 0.9, 4), 1e-3)
    first, second, *_ = rocking.impacts(time, angle, SHAPE, GRAVITY)
    rise = SHAPE.half_diagonal * (math.cos(ALPHA - math.radians(3)) - math.cos(ALPHA))
    low = part * rise * (np.abs(time - first.time_s - 0.01) < 0.01)
    found = rocking.impacts(time, angle, SHAPE, GRAVITY, low=low)
    assert (found[0].reason == rocking.HOPS) == (found[0].restitution is None) == hops
    assert found[0].ratio == (first.restitution if hops else None)
    assert found[1] == second


def test_no_restitution_is_above_one() -> None:
    assert rocking.Impact.of(1.0, 1.001, "").restitution == 1.001
    told = rocking.Impact.of(1.0, 1.1, "")
    assert (told.restitution, told.ratio, told.reason) == (None, 1.1, rocking.FASTER)
