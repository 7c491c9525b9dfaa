"""Statistics of ensembles: intervals, a known curve recovered, distances; measures of motions."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import norm

from solver.errors import SceneError
from solver.excitation.sampled import SampledMotion
from solver.study.suite.intensity import Intensity
from solver.study.suite.numbers import Sample, distances, fitted, fragility_text, interval


def samples(
    median: float, beta: float, levels: list[float], trials: int, seed: int
) -> tuple[list[int], list[int]]:
    """Numbers of motions that overturn a block of a known fragility at each level, and of all."""
    rng = np.random.default_rng(seed)
    probability = norm.cdf(np.log(np.array(levels) / median) / beta)
    return rng.binomial(trials, probability).tolist(), [trials] * len(levels)


LEVELS = [0.2, 0.3, 0.4, 0.5, 0.65, 0.8, 1.0, 1.3]


@pytest.mark.parametrize(("median", "beta"), [(0.5, 0.4), (0.8, 0.25), (0.35, 0.6)])
def test_a_known_fragility_is_recovered(median: float, beta: float) -> None:
    """From 20000 motions a level within 1 %; from expected numbers of motions exactly."""
    found = fitted(LEVELS, *samples(median, beta, LEVELS, 20000, seed=1))
    assert found is not None
    assert found.median == pytest.approx(median, rel=0.01)
    assert found.beta == pytest.approx(beta, rel=0.02)
    trials = 10**9
    expected = (trials * norm.cdf(np.log(np.array(LEVELS) / median) / beta)).round()
    exact = fitted(LEVELS, expected.astype(int).tolist(), [trials] * len(LEVELS))
    assert exact is not None
    assert (exact.median, exact.beta) == pytest.approx((median, beta), rel=1e-4)


def test_intervals_hold_as_often_as_they_say() -> None:
    """300 ensembles of 100 motions: the true median within its interval in about 95 % of them."""
    inside, errors, spreads = 0, [], []
    for seed in range(300):
        found = fitted(LEVELS, *samples(0.5, 0.4, LEVELS, 100, seed))
        assert found is not None
        inside += found.median_interval[0] < 0.5 < found.median_interval[1]
        errors.append(found.beta - 0.4)
        spreads.append(found.beta_error)
    assert 0.91 < inside / 300 < 0.98
    assert np.std(errors) == pytest.approx(np.mean(spreads), rel=0.15)


def test_samples_that_no_curve_goes_through() -> None:
    """None overturns, all do, or a step; and one that falls."""
    assert fitted([0.1, 0.2, 0.3], [0, 0, 0], [9, 9, 9]) is None
    assert fitted([0.1, 0.2, 0.3], [9, 9, 9], [9, 9, 9]) is None
    assert fitted([0.1, 0.2, 0.3], [0, 0, 9], [9, 9, 9]) is None
    assert (
        fitted([0.1, 0.2, 0.3], [0, 4, 9], [9, 9, 9]) is None
    )  # any steep enough curve is as good
    assert fitted([0.1, 0.2, 0.3], [8, 4, 1], [9, 9, 9]) is None
    # As many at all levels: the slope is round-off then, of either sign.
    assert fitted([0.3, 0.4, 0.5], [5, 5, 5], [10, 10, 10]) is None
    assert fitted([0.2, 0.4], [3, 3], [30, 30]) is None
    assert fitted([0.1, 0.2, 0.3], [1, 4, 8], [9, 9, 9]) is not None


def test_intervals_of_probabilities() -> None:
    """Clopper and Pearson's: closed forms where none or all overturn."""
    low, high = interval(0, 20)
    assert low == 0.0 and high == pytest.approx(1 - 0.025 ** (1 / 20))
    assert interval(20, 20) == pytest.approx((0.025 ** (1 / 20), 1.0))
    low, high = interval(10, 100)
    assert (low, high) == pytest.approx((0.0490, 0.1762), abs=1e-4)


def test_intensities() -> None:
    """Of 2 m/s^2 sin(2 pi t/0.5): PGA, PGV = a T/pi from rest, PSA at rest and in resonance."""
    time = np.arange(0.0, 20.0005, 0.001)
    motion = SampledMotion(time=time, value=2.0 * np.sin(4 * math.pi * time), step=0.001)
    assert Intensity.read("pga").of(motion) == pytest.approx(2 / 9.81)
    for sign in (1.0, -1.0):  # largest between two samples, both ways
        kink = SampledMotion(
            time=np.array([0.0, 0.1, 0.2, 0.3]), value=sign * np.array([0.0, 1.0, -1.0, 0.0])
        )
        assert Intensity.read("PGV").of(kink) == pytest.approx(0.075)
    assert Intensity.read("PGV").of(motion) == pytest.approx(2 * 0.5 / math.pi, rel=1e-4)
    assert Intensity.read("PSA:0.5").of(motion) == pytest.approx(2 / 9.81 / (2 * 0.05), rel=0.01)
    assert Intensity.read("PSA:0.5").name == "PSA(0.5 s)"
    for word in ("PGD", "PSA", "PSA:0", "PSA:x", "PGA:1"):
        with pytest.raises(SceneError, match="--intensity"):
            Intensity.read(word)
    uneven = SampledMotion(time=np.delete(time, 1), value=np.delete(motion.value, 1))
    assert Intensity.read("PSA:0.5").of(uneven) == pytest.approx(
        Intensity.read("PSA:0.5").of(motion), rel=1e-4
    )


@pytest.mark.parametrize("levels", [[0.05, 0.08, 0.12, 0.2, 0.3], [0.7, 1.0, 1.5, 2.0]])
def test_the_interval_of_a_median_far_from_the_levels_is_fisher_s(levels: list[float]) -> None:
    """Of ln(median) and beta themselves: z = (ln x - ln median)/beta, the weights as in probit.

    I = sum n phi(z)^2/(Phi(z) (1 - Phi(z))) grad z grad z^T, grad z = -(1, z)/beta.
    """
    median, beta, trials = 0.5, 0.6, 10**7
    z = np.log(np.array(levels) / median) / beta
    counts = (trials * norm.cdf(z)).round().astype(int).tolist()
    found = fitted(levels, counts, [trials] * len(levels))
    assert found is not None
    weight = trials * norm.pdf(z) ** 2 / (norm.cdf(z) * norm.sf(z))
    slopes = -np.stack([np.ones_like(z), z]) / beta
    errors = np.sqrt(np.diag(np.linalg.inv(slopes * weight @ slopes.T)))
    reach = 1.959964 * errors[0]
    known = (median * math.exp(-reach), median * math.exp(reach))
    assert np.log(np.array(found.median_interval) / median) == pytest.approx(
        np.log(np.array(known) / median), rel=0.02
    )
    assert found.beta_error == pytest.approx(errors[1], rel=1e-3)


def test_the_second_engine_that_overturns_more_has_points_more() -> None:
    """1 of 4 by the first one, 3 of 4 by the second one: +50 points; the other way round -50."""
    group = (("block", "a"),)
    few = Sample(group, "rigid", 0.5, (0.1, 0.2, 0.3, math.inf), ())
    many = Sample(group, "ode", 0.5, (0.1, math.inf, math.inf, math.inf), ())
    for pair, points in (((few, many), 50), ((many, few), -50)):
        (row,) = distances(pair)
        assert row["engines"] == [sample.engine for sample in pair]
        assert row["overturned"] == pytest.approx(points / 100)
        assert f"overturned {points:+d} points" in fragility_text([], [], [row], "")


def test_the_row_of_a_sample_has_quantiles_that_are_values_of_it() -> None:
    """Of ten motions: the second, fifth and ninth largest angle; one that overturns has none."""
    angles = (0.9, 1.2, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, math.inf, math.inf)
    slips = tuple(0.001 * k for k in range(1, 11))
    sample = Sample((("contact.friction", "0.3"), ("block", "a")), "rigid", 0.5, angles, slips)
    row = sample.row()
    assert (row["motions"], row["overturned"], row["probability"]) == (10, 2, 0.2)
    found = [row[f"angle_over_alpha_{q}"] for q in (16, 50, 84)]
    assert found == [0.2, 0.5, None]
    assert [row[f"slip_m_{q}"] for q in (16, 50, 84)] == pytest.approx([0.002, 0.005, 0.009])
    words = fragility_text([sample], [], [], "").splitlines()[1].split()
    assert words[:4] == ["contact.friction", "0.3,", "a", "rigid"]
    assert words[4:8] == ["0.5", "10", "2", "0.200"]
    assert words[-5:] == ["0.200", "0.500", "over", "5.000", "9.000"]


def test_engines_are_compared_at_the_same_level_and_block_only() -> None:
    """Pairs of samples of one block at one level; slips where both engines have them."""
    a, b = (("block", "a"),), (("block", "b"),)
    found = distances([
        Sample(a, "rigid", 0.5, (0.1, 0.2), (0.01, 0.02)),
        Sample(b, "rigid", 0.5, (0.1, 0.2), (0.01, 0.02)),
        Sample(a, "ode", 0.5, (0.1, 0.3), ()),
        Sample(a, "elastic", 0.5, (0.3, 0.4), (0.02, 0.03)),
        Sample(a, "ode", 0.7, (0.1, 0.2, math.inf, math.inf), ()),
        Sample(a, "rigid", 0.7, (0.1, 0.2, 0.3, math.inf), ()),
    ])  # fmt: skip
    assert [row["engines"] for row in found] == [
        ["rigid", "ode"], ["rigid", "elastic"], ["ode", "elastic"], ["ode", "rigid"]
    ]  # fmt: skip
    assert [row["angle"] for row in found] == pytest.approx([0.5, 1.0, 0.5, 0.25])
    assert [row["slip"] for row in found] == [None, pytest.approx(0.5), None, None]
    assert {row["block"] for row in found} == {"a"}
