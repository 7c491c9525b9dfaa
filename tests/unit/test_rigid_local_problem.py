"""The local problem as rigid blocks in the plane pose it: few points, flat arrays, states."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from solver.law.friction import Bounds
from solver.law.local_problem import FALLBACKS, LocalProblem, fallback, named, new_counts, solve
from solver.law.newton import OPEN, SLIP, STICK, Local

Array = NDArray[np.float64]
FORWARD, BACKWARD = SLIP, -SLIP


def bounds(count: int, friction: float, cohesion: float = 0.0) -> Bounds:
    """The same friction at all points."""
    return Bounds(np.full(count, friction), np.full(count, cohesion))


def solution(W: Array, q: Array, law: Bounds) -> tuple[Array, NDArray[np.int64]]:
    """Forces and states from a cold start."""
    count = len(q) // 2
    f, states = np.zeros(2 * count), np.zeros(count, dtype=np.int64)
    assert solve(2, W, q, law, f, states, new_counts())
    return f, states


def violation(W: Array, q: Array, law: Bounds, f: Array) -> float:
    """How far a solution is from Signorini's and Coulomb's conditions, in units of force."""
    r = 1.0 / np.diag(W)
    y = q + W @ f
    normal = np.abs(f[::2] - np.maximum(f[::2] - r[::2] * y[::2], 0.0)).max()
    limit = np.where(f[::2] > 0, law.cohesion + law.mu * f[::2], 0.0)
    moved = f[1::2] - r[1::2] * y[1::2]
    return float(max(normal, np.abs(f[1::2] - np.clip(moved, -limit, limit)).max()))


def rigid_problem(seed: int, count: int) -> tuple[Array, Array]:
    """Points of one rigid block, more of them than it has unknowns, driven into the floor."""
    random = np.random.default_rng(seed)
    G = np.zeros((2 * count, 3))
    x, y = random.uniform(-1, 1, count), random.uniform(-2, 0, count)
    G[::2, 1], G[1::2, 0], G[::2, 2], G[1::2, 2] = 1.0, 1.0, -x, y
    W = G @ np.diag([1.0, 1.0, random.uniform(0.5, 3.0)]) @ G.T
    W[np.diag_indices(2 * count)] *= 1 + 1e-9
    return W, G @ (random.normal(size=3) - np.array([0.0, 1.0, 0.0]))


@pytest.mark.parametrize(
    ("q", "state", "force"),
    [
        ((0.1, 0.3), OPEN, (0.0, 0.0)),
        ((-1.0, 0.2), STICK, (0.5, -0.05)),
        ((-1.0, -4.0), FORWARD, (0.5, 0.25)),
        ((-1.0, 4.0), BACKWARD, (0.5, -0.25)),
    ],
)
def test_one_point(q: tuple[float, float], state: int, force: tuple[float, float]) -> None:
    """W = diag(2, 4), mu = .5: each state with its force."""
    f, states = solution(np.diag([2.0, 4.0]), np.array(q), bounds(1, 0.5))
    assert states[0] == state
    assert f == pytest.approx(force)


def test_cohesion_holds_with_the_pressure() -> None:
    """|f_t| <= c + mu f_n, and nothing where the point is open."""
    law = bounds(1, 0.5, cohesion=0.3)
    f, _ = solution(np.diag([2.0, 4.0]), np.array([-1.0, -4.0]), law)
    assert f == pytest.approx((0.5, 0.3 + 0.25))
    f, _ = solution(np.diag([2.0, 4.0]), np.array([0.1, -4.0]), law)
    assert not f.any()


def test_a_smooth_point_beside_a_rough_one_has_no_tangential_force() -> None:
    """Its tangential row is dropped, whatever slides; W_nt of the rough one alone counts."""
    W = np.diag([2.0, 4.0, 2.0, 4.0])
    W[0, 3] = W[3, 0] = 0.5
    law = Bounds(np.array([0.0, 0.5]), np.zeros(2))
    f, _ = solution(W, np.array([-1.0, 7.0, -1.0, -4.0]), law)
    assert f == pytest.approx(((1.0 - 0.5 * 0.25) / 2, 0.0, 0.5, 0.25))


@pytest.mark.parametrize("friction", [0.0, 0.3, 2.0, 50.0])
@pytest.mark.parametrize("count", [1, 2, 4, 6])
@settings(derandomize=True, deadline=None, max_examples=50)
@given(seed=st.integers(0, 10**6))
def test_conditions_hold(friction: float, count: int, seed: int) -> None:
    """Points that share the motions of one rigid block."""
    law = bounds(count, friction)
    W, q = rigid_problem(seed, count)
    f, _ = solution(W, q, law)
    assert violation(W, q, law, f) < 1e-6 * max(1.0, np.abs(f).max())


def test_it_agrees_with_arrays_by_point() -> None:
    """On well-conditioned problems with one solution."""
    random = np.random.default_rng(1)
    for _ in range(30):
        A = random.normal(size=(8, 8))
        W, q = A @ A.T + 4 * np.eye(8), random.normal(size=8) - 1.0
        f, _ = solution(W, q, bounds(4, 0.4))
        other = LocalProblem().solve(
            W.reshape(4, 2, 4, 2), q.reshape(4, 2), np.zeros((4, 2)), Bounds.uniform(0.4, 4)
        )
        assert f == pytest.approx(other.ravel(), abs=1e-10)


@pytest.mark.parametrize("method", range(len(FALLBACKS)), ids=FALLBACKS)
def test_fall_backs_find_the_same(method: int) -> None:
    """Each of them alone, where Newton's method finds a solution, too."""
    solved = 0
    for seed in range(20):
        W, q = rigid_problem(seed, 2)
        law = bounds(2, 0.4)
        expected, _ = solution(W, q, law)
        f, states = np.zeros(4), np.zeros(2, dtype=np.int64)
        if fallback(method, Local(2, W, q, law), f, states):
            solved += 1
            assert W @ f == pytest.approx(W @ expected, abs=1e-7)
    assert solved >= 18


def test_forces_of_the_same_problem_are_kept() -> None:
    """One linear solve from them, whatever their states."""
    W, q = rigid_problem(3, 2)
    law = bounds(2, 0.4)
    expected, states = solution(W, q, law)
    f, following, counts = expected.copy(), np.zeros_like(states), new_counts()
    assert solve(2, W, q, law, f, following, counts)
    assert counts[0] == 1 and not named(counts)
    assert (following == states).all()
    assert f == pytest.approx(expected, rel=1e-9)


def test_cohesion_that_would_lift_its_own_point_grows_with_pressure() -> None:
    """A block that slides fast on a corner below its centre: all cohesion at once has no solution.

    Point by point: 0 <= f_n, and friction at its bound is 1e4 times the pressure.
    """
    W = np.array([[1.0, 0.8], [0.8, 1.0]])
    q, law = np.array([-1.0, -10.0]), bounds(1, 0.3, 5.0)
    # With all of it f_t = c + mu f_n lifts: y_n = -1 + f_n + .8 (5 + .3 f_n) > 0 for any f_n >= 0,
    # and open it would sink.
    f, states = solution(W, q, law)
    assert states[0] not in (OPEN, STICK) and f[1] > 0
    assert f[0] == pytest.approx(1.0 / (1.0 + 0.8 * (0.3 + 1e4)), rel=1e-12)
    assert f[1] == pytest.approx((0.3 + 1e4) * f[0], rel=1e-12)
    assert q[0] + W[0] @ f == pytest.approx(0.0, abs=1e-12)
    assert f[1] < 5.0
