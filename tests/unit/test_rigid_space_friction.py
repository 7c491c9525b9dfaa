"""The local problem with discs of friction: Signorini and Coulomb hold at every point."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from solver.law.friction import TOUCHING_SLOPE, Bounds, radius
from solver.law.local_problem import named, new_counts, one_point, solve
from solver.law.newton import FEW, Local, product, solve_dense

Array = NDArray[np.float64]

CORNERS = np.array([(-1.0, -1.0, -1.0), (1.0, -1.0, -1.0), (1.0, 1.0, -1.0), (-1.0, 1.0, -1.0)])
MASS, GRAVITY, DT = 300.0, 9.81, 1e-3


def settle(W: Array, q: Array, f: Array, mu: Array, cohesion: Array) -> bool:
    """Solve the local problem from f in place."""
    states = np.empty(len(mu), dtype=np.int64)
    return solve(3, W, q, Bounds(mu, cohesion), f, states, new_counts())


def compliance(points: Array, half: Array) -> tuple[Array, Array]:
    """Rows of points of a box, (3 m, 6), and its compliance (6, 6) in a step."""
    inertia = MASS / 3 * ((half**2).sum() - half**2)
    rows = [np.hstack([np.eye(3), np.cross(arm, np.eye(3))])[[2, 0, 1]] for arm in points]
    return np.vstack(rows), DT**2 / 2 * np.diag([*np.full(3, 1 / MASS), *1 / inertia])


def problem(load: Array, half: Array, points: Array | None = None) -> tuple[Array, Array]:
    """W and q of a box under a force and a moment."""
    rows, soft = compliance(CORNERS * half if points is None else points, half)
    W = rows @ soft @ rows.T
    W[np.diag_indices_from(W)] *= 1 + 1e-7
    return W, rows @ soft @ load


def violation(W: Array, q: Array, f: Array, mu: float) -> float:
    """Largest breach of the laws, as a force relative to the largest."""
    y = (q + W @ f).reshape(-1, 3)
    forces, size = f.reshape(-1, 3), max(np.abs(f).max(), 1e-300)
    soft = np.diag(W).reshape(-1, 3).max(axis=1)
    normal, bound = forces[:, 0], mu * forces[:, 0]
    tangential, slip = np.linalg.norm(forces[:, 1:], axis=1), np.linalg.norm(y[:, 1:], axis=1)
    power = (forces[:, 1:] * y[:, 1:]).sum(axis=1)
    breaches = [
        np.maximum(-normal, 0),
        np.maximum(-y[:, 0] / soft, 0),
        np.minimum(np.abs(normal), np.abs(y[:, 0]) / soft),
        np.maximum(tangential - bound, 0),
        np.where(normal > 0, np.minimum(bound - tangential, slip / soft), 0),
        # Where a point slips, force and slip are opposite.
        np.where(normal > 0, (power + tangential * slip) / (soft * size), 0),
    ]
    return float(np.max(np.abs(breaches)) / size)


def loads() -> Iterator[tuple[Array, Array, float]]:
    """Forces and moments, sizes and friction; near the limits of friction, tipping, impacts."""
    random = np.random.default_rng(7)
    for k in range(400):
        half, mu = random.uniform(0.1, 0.6, 3), float(random.choice([0.0, 0.1, 0.3, 0.7, 1.0]))
        load = MASS * GRAVITY * np.array([0, 0, -1.0, 0, 0, 0])
        azimuth = random.uniform(0, 2 * np.pi)
        if k % 3 == 0:
            pull = mu * random.choice([0.5, 0.98, 1.02, 1.5])
            load[:2] = MASS * GRAVITY * pull * np.array([np.cos(azimuth), np.sin(azimuth)])
        elif k % 3 == 1:
            load += MASS * GRAVITY * np.r_[random.normal(0, 0.3, 3), random.normal(0, 0.1, 3)]
        else:
            load += MASS * GRAVITY * np.r_[random.normal(0, 30, 3), random.normal(0, 10, 3)]
        yield load, half, mu


@pytest.mark.slow
def test_four_corners_under_all_kinds_of_loads() -> None:
    """From nothing; in a run the forces of the last step are there to start from."""
    for load, half, mu in loads():
        W, q = problem(load, half)
        f = np.zeros(12)
        assert settle(W, q, f, np.full(4, mu), np.zeros(4))
        assert violation(W, q, f, mu) < 1e-6


def test_sliding_force_is_opposite_to_the_pull_for_every_azimuth() -> None:
    half, mu = np.array([0.5, 0.5, 0.1]), 0.3
    for azimuth in np.linspace(0, 2 * np.pi, 13):
        way = np.array([np.cos(azimuth), np.sin(azimuth)])
        W, q = problem(MASS * GRAVITY * np.array([*(0.5 * way), -1, 0, 0, 0]), half)
        f = np.zeros(12)
        assert settle(W, q, f, np.full(4, mu), np.zeros(4))
        total = f.reshape(4, 3).sum(axis=0)
        # A step's forces move the body by half dt^2/m each: the weight is met by its double.
        np.testing.assert_allclose(total[0], MASS * GRAVITY, rtol=1e-6)
        np.testing.assert_allclose(total[1:], -mu * MASS * GRAVITY * way, atol=1e-5 * total[0])


def test_cohesion_adds_to_the_limit() -> None:
    half = np.array([0.5, 0.5, 0.1])
    W, q = problem(MASS * GRAVITY * np.array([2.0, 0, -1, 0, 0, 0]), half)
    f = np.zeros(12)
    assert settle(W, q, f, np.full(4, 0.2), np.full(4, 100.0))
    assert f.reshape(4, 3)[:, 1].sum() == pytest.approx(-0.2 * MASS * GRAVITY - 400, rel=1e-6)


def test_one_point_sticks_slips_or_is_open() -> None:
    W = np.array([[2.0, 0.3, -0.2], [0.3, 1.5, 0.1], [-0.2, 0.1, 1.0]])
    for mu, free in ((0.9, (0.1, 5.0, 0.0)), (0.9, (-1.0, 0.1, 0.1)), (0.4, (-1.0, 2.0, -1.0))):
        q = np.array(free)
        f = np.array(one_point(Local(3, W, q, Bounds.uniform(mu, 1))))
        assert violation(W, q, f, mu) < 1e-12
        assert (f[0] == 0) == (free[0] > 0)


def test_cohesion_that_lifts_its_own_point_grows_with_the_force() -> None:
    """A rod leans on its corner and slips to where its centre is: all cohesion would lift it.

    Without pressure no cohesion acts, with pressure all of it: neither is a solution.
    """
    corner, half = np.array([[1.0, 0.0, -1.0]]), np.array([1.0, 0.2, 1.0])
    W, _ = problem(np.zeros(6), half, corner)
    q = np.array([-1e-9, -1e-5 * np.sign(W[0, 1]), 0.0])
    mu, cohesion, f = np.array([0.5]), np.array([200.0]), np.zeros(3)
    assert settle(W, q, f, mu, cohesion)
    y = q + W @ f
    assert f[0] > 0
    assert abs(y[0]) < 1e-9 * abs(q[1])
    acting = TOUCHING_SLOPE * f[0]
    assert 0 < acting < 200
    assert np.hypot(f[1], f[2]) == pytest.approx(0.5 * f[0] + acting, rel=1e-9)
    assert radius(Bounds(mu, cohesion, TOUCHING_SLOPE), 0, f[0]) == 0.5 * f[0] + acting
    assert f[1] * y[1] < 0


@pytest.mark.parametrize("size", [1, 2, 7, FEW, FEW + 1])
def test_elimination(size: int) -> None:
    random = np.random.default_rng(1)
    matrix, right = random.normal(size=(size, size)), random.normal(size=size)
    solution = right.copy()
    assert solve_dense(matrix.copy(), solution)
    np.testing.assert_allclose(matrix @ solution, right, atol=1e-12)
    np.testing.assert_allclose(product(matrix, solution), matrix @ solution, atol=1e-13)
    assert not solve_dense(np.zeros((size, size)), np.ones(size))


def test_elimination_needs_its_pivots() -> None:
    """A zero on the diagonal is none; numbers that are none have no solution."""
    turned, right = np.array([[0.0, 2.0], [1.0, 0.0]]), np.array([4.0, 3.0])
    assert solve_dense(turned, right)
    assert right.tolist() == [3.0, 2.0]
    for wrong in (np.nan, np.inf):
        assert not solve_dense(np.array([[1.0, 0.0], [0.0, wrong]]), np.ones(2))


@pytest.mark.parametrize("case", ["1e4", "1e4_halved", "1e6"])
@pytest.mark.parametrize("start", [0.0, 1e6])
def test_a_heavy_block_slides_on_a_light_one(case: str, start: float) -> None:
    """Density ratios of 1e4 and 1e6: friction above and below the light block is nearly equal.

    Newton's method cycles for both scalings; with a proximal term it settles.
    """
    with np.load(Path(__file__).parent / "data" / "heavy_on_light.npz") as recorded:
        W, q, mu = (recorded[f"{name}_{case}"] for name in ("W", "q", "mu"))
    f, counts, states = np.full(len(q), start), new_counts(), np.empty(len(mu), np.int64)
    bounds = Bounds(mu, np.zeros(len(mu)))
    assert solve(3, W, q, bounds, f, states, counts)
    assert violation(W, q, f, float(mu[0])) < 1e-6


def test_a_column_of_drums_whose_points_outnumber_its_motions() -> None:
    """22 points, 66 rows on 30 motions, and a diagonal of 1e-8 that makes the forces unique.

    They are unique nevertheless: the solution is exact, not one to within what the diagonal yields.
    """
    with np.load(Path(__file__).parent / "data" / "column_of_drums.npz") as recorded:
        W, q, mu, start = (recorded[name] for name in ("W", "q", "mu", "start"))
    f, counts, states = start.copy(), new_counts(), np.empty(len(mu), np.int64)
    assert solve(3, W, q, Bounds(mu, np.zeros(len(mu))), f, states, counts)
    assert violation(W, q, f, float(mu[0])) < 1e-12
    assert named(counts) == {"proximal": 1}
