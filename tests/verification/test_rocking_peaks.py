"""Housner's block in compiled steps, against the adaptive integration of the same equation."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from geometry.block import Block
from solver.excitation.sampled import SampledMotion
from solver.reference.housner import housner
from solver.reference.kernels.rocking import rocking_peaks
from solver.reference.rocking_peaks import sampled_rocking
from solver.results.rocking import no_return
from solver.types import Array

PAPER = Block(width=0.25, height=1.0, thickness=0.75, density=503.0 / 0.1875)


def noise(seed: int, peak: float, duration: float = 3.0, step: float = 0.02) -> SampledMotion:
    """Samples that a block feels, of a largest acceleration (m/s2), the first one after 0.1 s."""
    time = 0.1 + step * np.arange(round(duration / step) + 1)
    rng = np.random.default_rng(seed)
    value = sum(
        rng.normal() * np.sin(2 * math.pi * f * time + rng.uniform(0, 7))
        for f in (0.8, 1.3, 2.1, 3)
    )
    value[0] = value[-1] = 0.0
    return SampledMotion(time=time, value=peak * value / np.abs(value).max(), step=step)


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("restitution", [None, 0.95])
def test_peaks_and_impacts_of_the_equation(seed: int, restitution: float | None) -> None:
    motion = noise(seed, 4.5)
    found = sampled_rocking(PAPER, motion, gravity=9.81, end=4.0, restitution=restitution)
    equation = housner(
        PAPER, gravity=9.81, end=4.0, step=1e-3, acceleration=motion.acceleration,
        restitution=restitution,
    )  # fmt: skip
    assert found.angle > 0.1 * PAPER.slenderness
    assert (found.overturned_at is not None) == equation.overturned
    # The equation's history is sampled: a peak between two samples is missed by up to 1e-5.
    if not equation.overturned:
        assert found.angle == pytest.approx(np.abs(equation.angle).max(), rel=1e-4)
        assert found.impacts == pytest.approx(len(equation.impacts), abs=2)


def test_no_uplift_below_g_tan_alpha() -> None:
    limit = 9.81 * math.tan(PAPER.slenderness)
    still, moves = (
        sampled_rocking(PAPER, noise(1, part * limit), gravity=9.81, end=4.0)
        for part in (0.999, 1.05)
    )
    assert (still.angle, still.impacts) == (0.0, 0)
    assert 0 < moves.angle < 0.1


def test_a_scale_is_a_stronger_motion() -> None:
    twice = sampled_rocking(PAPER, noise(2, 2.0), gravity=9.81, end=4.0, scale=2.0)
    assert twice == sampled_rocking(PAPER, noise(2, 4.0), gravity=9.81, end=4.0)
    fallen = sampled_rocking(PAPER, noise(2, 40.0), gravity=9.81, end=4.0)
    assert fallen.overturned_at is not None and fallen.overturned_at < 2.0
    assert fallen.angle == no_return(PAPER.slenderness)


@pytest.mark.parametrize("longest", [0.013, 0.03, 0.05])
def test_peaks_within_long_steps(longest: float) -> None:
    """A push, then still ground: the peak is that of a root of the velocity, found by LSODA.

    It lies between the ends of the steps, of which the nearest one misses it by up to 1 %.
    """
    alpha, g, size = math.atan(0.25), 9.81, 0.75 / PAPER.half_diagonal
    push, until = 4.0, 0.23

    def rate(time: float, state: Array, ground: float) -> list[float]:
        lean = -alpha - state[0]  # to the left: the ground goes to the right
        return [state[1], -size * (g * math.sin(lean) + ground * math.cos(lean))]

    def turns(time: float, state: Array, ground: float) -> float:
        return float(state[1]) if time > 0 else -1.0

    exact = {"method": "LSODA", "rtol": 1e-11, "atol": 1e-13}
    pushed = solve_ivp(rate, (0, until), [0.0, 0.0], args=(push,), **exact).y[:, -1]
    setattr(turns, "terminal", True)
    rest = solve_ivp(rate, (0, 2), pushed, args=(0.0,), events=turns, **exact)
    top = abs(rest.y_events[0][0][0])
    assert rest.t_events[0][0] > 0.05 and 0.1 < top / alpha < 0.9
    angle, impacts, _ = rocking_peaks(
        np.array([push, 0.0]), np.zeros(2), np.array([until, rest.t_events[0][0] + longest]),
        longest, (alpha, g, size), 0.9, 1e-6, 1.5,
    )  # fmt: skip
    assert impacts == 0
    assert angle == pytest.approx(top, rel=2e-5)
