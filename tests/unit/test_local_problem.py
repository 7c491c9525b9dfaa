"""The condensed contact problem: the law itself, all 4^m states one by one, and the hard cases."""

from itertools import product
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import nnls

from solver.kernels import meshed
from solver.law.friction import TOUCHING_SLOPE, Bounds
from solver.law.local_problem import (
    LocalProblem,
    NoContactSolution,
    image,
    named,
    new_counts,
)

OPEN, STICK = 0, 1  # states of points

deterministic = settings(derandomize=True, deadline=None, max_examples=60)
SEEDS = st.integers(0, 10**6)


def easy(seed: int, points: int, d: int = 2) -> tuple[np.ndarray, np.ndarray]:
    """A well conditioned compliance and free values of either sign."""
    rng = np.random.default_rng(seed)
    matrix = rng.standard_normal((d * points, d * points))
    W = matrix @ matrix.T / (d * points) + np.eye(d * points)
    q = rng.standard_normal((points, d))
    q[:, 0] -= 0.5
    return W.reshape(points, d, points, d), q


def stiff(seed: int, points: int) -> tuple[np.ndarray, np.ndarray, float]:
    """Points under a stiff body: three rigid motions, and next to no compliance of their own."""
    rng = np.random.default_rng(seed)
    x, height = np.sort(rng.uniform(-1, 1, points)), rng.uniform(0.5, 4)
    rigid = np.zeros((points, 2, 3))
    rigid[:, 0, 1], rigid[:, 1, 0] = 1, 1
    rigid[:, 0, 2], rigid[:, 1, 2] = x, height
    rows = rigid.reshape(-1, 3)
    matrix = rng.standard_normal((2 * points, 2 * points))
    own = 10.0 ** rng.uniform(-6, -2)
    W = rows @ np.diag([1, 1, 3]) @ rows.T
    W += own * (matrix @ matrix.T / (2 * points) + np.eye(2 * points))
    q = rigid @ rng.standard_normal(3) + own * rng.standard_normal((points, 2))
    q[:, 0] -= rng.uniform(0, 1)
    friction = float(rng.choice([0.1, 0.7, 2, 10, 50]))
    return W.reshape(points, 2, points, 2), q, friction


def base_rows(x: np.ndarray, y: np.ndarray, height: float) -> np.ndarray:
    """Rows (points, 3, 6): what motions of a block's centre and turns about it do to its base."""
    arms = np.stack([x, y, np.full_like(x, -height / 2)], axis=1)
    rows = np.zeros((len(x), 3, 6))
    for k, axis in enumerate(np.eye(3)[[2, 0, 1]]):  # normal z, tangential x and y
        rows[:, k, :3], rows[:, k, 3:] = axis, np.cross(arms, axis)
    return rows


def block(seed: int, points: int) -> tuple[np.ndarray, np.ndarray, Bounds]:
    """Points under a block of unit width, rigid (but for 1e-9) or nearly so; some with cohesion."""
    rng = np.random.default_rng(seed)
    depth, height = rng.uniform(0.5, 2), rng.uniform(0.3, 5)
    x, y = rng.uniform(-0.5, 0.5, points), depth * rng.uniform(-0.5, 0.5, points)
    if points == 4:
        x, y = np.array([-1, 1, 1, -1]) / 2, depth * np.array([-1, -1, 1, 1]) / 2
    rows = base_rows(x, y, height)
    squares = np.array([1.0, depth, height]) ** 2
    inverse = np.concatenate([np.ones(3), 12 / (squares.sum() - squares)])
    W = (rows * inverse).reshape(-1, 6) @ rows.reshape(-1, 6).T
    own = 10.0 ** rng.choice([-9, -5, -3, -1])
    W[np.diag_indices(3 * points)] *= 1 + own
    motion = rng.standard_normal(6) * 10.0 ** rng.uniform(-2, 0.5, 6)
    motion[2] = -abs(motion[2])
    q = rows @ motion
    mu = float(rng.choice([0.1, 0.5, 2, 10, 50])) * rng.uniform(0.5, 1, points)
    c = rng.uniform(0, 0.2, points) * abs(motion[2]) * (seed % 3 == 0)
    return W.reshape(points, 3, points, 3), q, Bounds(mu, c)


def violation(W: np.ndarray, q: np.ndarray, f: np.ndarray, bounds: Bounds) -> float:
    """By how much forces break the law, relative to the largest force and free value."""
    y = (q + image(W, f)) / np.abs(q).max()
    scale = np.abs(f).max() or 1.0
    mu, f = bounds.mu, f / scale
    bound = np.where(f[:, 0] > 0, mu * f[:, 0] + bounds.cohesion / scale, 0.0)
    friction, slip = np.linalg.norm(f[:, 1:], axis=1), np.linalg.norm(y[:, 1:], axis=1)
    worst = [np.max(-f[:, 0]), np.max(-y[:, 0]), np.minimum(np.abs(f[:, 0]), np.abs(y[:, 0])).max()]
    worst.append(np.max((friction - bound) / np.maximum(mu, 1.0)))
    for k in np.flatnonzero(f[:, 0] > 1e-12):
        within = (bound[k] - friction[k]) / max(mu[k], 1.0)
        if f[k, 0] * TOUCHING_SLOPE < bounds.cohesion[k] / scale:
            within = 0.0  # cohesion that would lift the point is built up in part
        # Opposite: y_t |f_t| + f_t |y_t| = 0.
        turned = np.linalg.norm(y[k, 1:] * friction[k] + f[k, 1:] * slip[k])
        worst.append(min(slip[k], max(within, turned / (friction[k] or 1.0))))
    return float(max(worst))


def all_solutions(W: np.ndarray, q: np.ndarray, mu: float, c: float = 0.0) -> list[np.ndarray]:
    """Every solution, by trying open, sticking, slipping left, slipping right for every point."""
    size, bounds = q.size, Bounds(np.full(len(q), mu), np.full(len(q), c))
    flat, found = W.reshape(size, size), []
    for states in product("open stick left right".split(), repeat=len(q)):
        matrix, right = np.eye(size), np.zeros(size)
        for k, state in enumerate(states):
            n, t = 2 * k, 2 * k + 1
            if state != "open":
                matrix[n], right[n] = flat[n], -q[k, 0]
            if state == "stick":
                matrix[t], right[t] = flat[t], -q[k, 1]
            elif state != "open":
                sign = 1.0 if state == "right" else -1.0
                matrix[t, n], right[t] = -sign * mu, sign * c
        f = np.linalg.solve(matrix, right).reshape(q.shape)
        if violation(W, q, f, bounds) < 1e-10:
            found.append(f)
    return found


def solved(W: np.ndarray, q: np.ndarray, bounds: Bounds) -> np.ndarray:
    return LocalProblem().solve(W, q, np.zeros_like(q), bounds)


@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("points", [1, 2, 3, 5, 12])
@pytest.mark.parametrize("mu", [0.3, 0.9])
@pytest.mark.parametrize("cohesion", [0.0, 0.05])
def test_the_law_holds(d, points, mu, cohesion):
    """Whatever the problem; and all states occur."""
    states = set()

    @settings(deterministic, max_examples=30 if points > 1 else 100)
    @given(seed=SEEDS)
    def holds(seed):
        W, q = easy(seed, points, d)
        each = np.random.default_rng(seed).uniform(0.5, 1, points)
        bounds = Bounds(mu * each, cohesion * each)
        f = solved(W, q, bounds)
        assert violation(W, q, f, bounds) < 1e-10
        size = np.linalg.norm(f[:, 1:], axis=1)
        sticks = size < (bounds.mu * f[:, 0] + bounds.cohesion) * (1 - 1e-9)
        states.update("closed" if n > 0 else "open" for n in f[:, 0])
        states.update("stick" if s else "slip" for s in sticks[f[:, 0] > 0])

    holds()
    assert states == {"open", "closed", "stick", "slip"}


@pytest.mark.parametrize("points", [1, 2, 3, 4])
@pytest.mark.parametrize("cohesion", [0.0, 0.02])
@settings(deterministic, max_examples=20)
@given(seed=SEEDS)
def test_agrees_with_the_enumeration_of_all_states(points, cohesion, seed):
    W, q = easy(seed, points)
    expected = all_solutions(W, q, 0.5, cohesion)
    assert len(expected) == 1 or (cohesion and not expected)
    f = solved(W, q, Bounds(np.full(points, 0.5), np.full(points, cohesion)))
    if expected:
        assert f == pytest.approx(expected[0], abs=1e-10)
    else:  # cohesion would lift one of the points
        assert ((f[:, 0] > 0) & (f[:, 0] < cohesion / TOUCHING_SLOPE)).sum() == 1


@pytest.mark.parametrize("points", [2, 3, 5, 8])
@deterministic
@given(seed=SEEDS)
def test_the_law_holds_under_stiff_bodies(points, seed):
    """Nearly of rank three, friction up to 50."""
    W, q, friction = stiff(seed, points)
    bounds = Bounds.uniform(friction, points)
    assert violation(W, q, solved(W, q, bounds), bounds) < 1e-9


@pytest.mark.parametrize("points", [2, 4, 7])
@deterministic
@given(seed=SEEDS)
def test_the_law_holds_under_blocks_in_space(points, seed):
    """Twelve rows on six unknowns, friction up to 50, with and without cohesion."""
    W, q, bounds = block(seed, points)
    assert violation(W, q, solved(W, q, bounds), bounds) < 1e-8


@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("points", [1, 2, 6, 15])
def test_without_friction_it_is_a_least_squares_problem(points, d):
    """min f.W f/2 + q.f, f >= 0, by scipy's nnls; no tangential force."""
    for seed in range(10):
        W, q = easy(200 + seed, points, d)
        lower = np.linalg.cholesky(W[:, 0, :, 0])
        expected, _ = nnls(lower.T, -np.linalg.solve(lower, q[:, 0]))
        f = solved(W, q, Bounds.uniform(0.0, points))
        assert f[:, 0] == pytest.approx(expected, abs=1e-10)
        assert f.shape == q.shape and not f[:, 1:].any()


@pytest.mark.parametrize(
    ("q", "force"),
    [
        ((1.0, 7.0), (0.0, 0.0)),  # open, whatever slides
        ((-2.0, 0.5), (1.0, -0.125)),  # sticks
        ((-2.0, 9.0), (1.0, -0.3)),  # slips to the right
        ((-2.0, -9.0), (1.0, 0.3)),
    ],
)
def test_one_point(q, force):
    """W = diag(2, 4), mu = 0.3: everything by hand."""
    W = np.diag([2.0, 4.0]).reshape(1, 2, 1, 2)
    f = solved(W, np.array([q]), Bounds.uniform(0.3, 1))
    assert f[0] == pytest.approx(force)


def test_one_point_in_space_by_hand():
    """W = diag(2, 4, 4), mu = 0.5: y_t = (3, 4) without friction slips against (0.6, 0.8)."""
    W = np.diag([2.0, 4.0, 4.0]).reshape(1, 3, 1, 3)
    f = solved(W, np.array([[-2.0, 3.0, 4.0]]), Bounds.uniform(0.5, 1))
    assert f[0] == pytest.approx([1.0, -0.3, -0.4])
    f = solved(W, np.array([[-2.0, 3.0, 4.0]]), Bounds(np.array([0.5]), np.array([0.25])))
    assert f[0] == pytest.approx([1.0, -0.45, -0.6])
    f = solved(W, np.array([[-2.0, 1.2, 1.6]]), Bounds.uniform(0.5, 1))
    assert f[0] == pytest.approx([1.0, -0.3, -0.4])  # just held
    assert not solved(W, np.array([[0.1, 3.0, 4.0]]), Bounds.uniform(0.5, 1)).any()


@pytest.mark.parametrize("d", [2, 3])
def test_cohesion_that_would_lift_its_point_is_built_up_as_far_as_it_does_not(d):
    """W_nt f_t = 0.6 f_t > 0.1 where all of c = 1 acts: no state of the law itself is left."""
    W = np.eye(d)
    W[0, 1] = W[1, 0] = 0.6
    q = np.array([[-0.1, -2.0, 0.0]])[:, :d]
    W = W.reshape(1, d, 1, d)
    if d == 2:
        assert not all_solutions(W, q, 0.0, 1.0)
    for points in (1, 2):  # by the closed form in 2-D, and beside a point far away
        both = np.zeros((points, d, points, d))
        for k in range(points):
            both[k, :, k] = W[0, :, 0]
        rest = np.vstack([q, np.full((points - 1, d), 5.0)])
        f = solved(both, rest, Bounds(np.zeros(points), np.ones(points)))
        assert 0 < f[0, 0] < 1e-4
        assert f[0, 1] == pytest.approx(0.1 / 0.6, rel=1e-3)
        assert (rest + image(both, f))[0, :2] == pytest.approx([0, -2 + 0.1 / 0.6], abs=1e-4)


def test_a_sticking_pair_of_a_rigid_body_by_hand():
    """Two corners at x = -1 and 1 under a weight of 2 and no moment: each carries half of it."""
    rigid = np.array([[[0, 1, -1], [1, 0, 0]], [[0, 1, 1], [1, 0, 0]]], dtype=float)
    W = np.einsum("iak,jbk->iajb", rigid, rigid)
    W += 1e-9 * np.eye(4).reshape(2, 2, 2, 2)
    q = rigid @ (0.2, -2.0, 0.0)
    f = solved(W, q, Bounds.uniform(0.5, 2))
    assert f == pytest.approx(np.array([[1.0, -0.1], [1.0, -0.1]]), abs=1e-6)


def test_four_corners_of_a_rigid_block_by_hand():
    """12 rows on 6 unknowns: unit mass falling at 1 and sliding at (.3, .4), mu = .25, no height.

    All of the fall is taken, 1/4 at each corner, and .25 of the .5 of sliding.
    """
    corners = np.array([-1.0, 1, 1, -1]), np.array([-1.0, -1, 1, 1])
    rows = base_rows(*corners, height=0.0)
    W = np.einsum("iak,jbk->iajb", rows, rows)
    number = np.arange(12)
    W.reshape(12, 12)[number, number] *= 1 + 1e-9
    f = solved(W, rows @ (0.3, 0.4, -1.0, 0, 0, 0), Bounds.uniform(0.25, 4))
    assert f[:, 0] == pytest.approx(np.full(4, 0.25), abs=1e-6)
    assert f.sum(axis=0) == pytest.approx([1.0, -0.15, -0.2], abs=1e-6)


@pytest.mark.parametrize("seed", range(6))
def test_in_a_plane_the_disc_is_the_interval(seed):
    """Nothing coupled to the second tangential direction: the solution of two dimensions."""
    points = 2 + seed
    W, q = easy(600 + seed, points)
    bounds = Bounds(np.linspace(0.2, 0.8, points), np.linspace(0.0, 0.1, points))
    space = np.zeros((points, 3, points, 3))
    space[:, :2, :, :2] = W
    space[np.arange(points), 2, np.arange(points), 2] = 1.0
    f = solved(space, np.hstack([q, np.zeros((points, 1))]), bounds)
    assert f[:, :2] == pytest.approx(solved(W, q, bounds), abs=1e-9)
    assert np.abs(f[:, 2]).max() < 1e-12


@pytest.mark.parametrize("angle", [0.3, 1.2, 2.5])
def test_the_disc_has_no_favourite_direction(angle):
    turn = np.eye(3)
    turn[1:, 1:] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    slid = 0
    for seed in range(10):
        W, q = easy(700 + seed, 5, 3)
        bounds = Bounds(np.linspace(0.2, 0.8, 5), np.full(5, 0.02))
        turned = np.einsum("ab,ibjc,dc->iajd", turn, W, turn)
        f, g = solved(W, q, bounds), solved(turned, q @ turn.T, bounds)
        assert g == pytest.approx(f @ turn.T, abs=1e-9)
        bound = bounds.mu * f[:, 0] + bounds.cohesion
        slid += int((np.linalg.norm(f[:, 1:], axis=1) > bound * (1 - 1e-9)).sum())
    assert slid >= 10


@pytest.mark.parametrize("d", [2, 3])
def test_the_guess_changes_nothing(d):
    """Neither does it that the last problem had other bounds or none at all."""
    rng = np.random.default_rng(5)
    remembering = LocalProblem()
    for seed in range(20):
        W, q = easy(300 + seed, 4, d)
        bounds = Bounds.uniform((0.4, 0.0, 0.2)[seed % 3], 4)
        expected = solved(W, q, bounds)
        f = remembering.solve(W, q, 3 * rng.standard_normal((4, d)), bounds)
        assert f == pytest.approx(expected, abs=1e-10)
        again = remembering.solve(W, q, f, bounds)
        assert again == pytest.approx(expected, abs=1e-10)


@pytest.mark.parametrize("d", [2, 3])
def test_image_is_the_matrix_product(d):
    W, q = easy(1, 3, d)
    for i, a in np.ndindex(3, d):
        expected = sum(W[i, a, j, b] * q[j, b] for j, b in np.ndindex(3, d))
        assert image(W, q)[i, a] == pytest.approx(expected)


def lengths(d: int, W: np.ndarray) -> np.ndarray:
    r = np.empty((len(W) // d, 2))
    meshed.lengths(d, np.ascontiguousarray(W), r)
    return r


def test_lengths_by_hand():
    """One over row sums within a direction; one for both tangential ones."""
    W = (np.arange(1.0, 37.0).reshape(2, 3, 2, 3) * (1, -1, 1)).reshape(6, 6)
    assert lengths(3, W)[1] == pytest.approx([1 / (19 + 22), 1 / (33 + 36)])
    assert lengths(2, W[:4, :4])[1, 1] == pytest.approx(1 / (20 + 22))


@pytest.mark.parametrize("cohesion_only", [False, True])
def test_a_proximal_term_by_hand(cohesion_only):
    """It holds two points, of which the second builds up its cohesion: its friction is steep."""
    W = np.array([[2.0, 0.1, 0, 0], [0.1, 4.0, 0, 0], [0, 0, -1.0, 0], [0, 0, 0, 8.0]])
    q, held = np.arange(1.0, 5.0), np.array([3.0, -1.0, 1.0, 5.0])
    bounds = Bounds(np.array([0.5, 0.25]), np.array([0.0, 20.0]), 10.0)
    soft, free, r = W.copy(), np.empty(4), np.empty((2, 2))
    meshed.ease(2, W, q, *bounds, 0.1, cohesion_only, held, soft, free, r)
    slopes = (0.0, 10.0) if cohesion_only else (0.5, 10.25)
    added = np.array([0.2 * (1 + slopes[0]), 0.4, 0.1 * (1 + slopes[1]), 0.8])
    np.testing.assert_allclose(soft, W + np.diag(added), rtol=1e-14)
    np.testing.assert_allclose(free, q - added * held, rtol=1e-14)
    normal = np.abs(soft.diagonal()[::2]) * (1 + 0.1 * np.array(slopes))
    np.testing.assert_allclose(r, np.stack([1 / normal, 1 / soft.diagonal()[1::2]], axis=1))


@pytest.mark.parametrize("d", [2, 3])
def test_without_points_there_is_no_force(d):
    nothing = np.zeros((0, d))
    W = np.zeros((0, d, 0, d))
    assert LocalProblem().solve(W, nothing, nothing, Bounds.uniform(0.5, 0)).shape == (0, d)


@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("points", [1, 3, 8])
def test_the_proximal_point_algorithm_finds_what_newton_finds(d, points):
    for seed in range(10):
        W, q = easy(400 + seed, points, d)
        local, bounds = LocalProblem(), Bounds.uniform(0.6, points)
        expected = local.solve(W, q, np.zeros_like(q), bounds)
        assert not local.fallbacks
        problem = d, W.reshape(q.size, q.size), q.ravel(), *bounds
        found, states = np.zeros(q.size), np.empty(points, dtype=np.int64)
        assert meshed.by_proximal_points(*problem, found, states)
        assert found.reshape(q.shape) == pytest.approx(expected, abs=1e-9)
        assert ((states != OPEN) == (expected[:, 0] > 0)).all()
        sticks = np.linalg.norm(expected[:, 1:], axis=1) < 0.6 * expected[:, 0] * (1 - 1e-9)
        assert ((states == STICK) == sticks).all()


# Points and seed of `stiff` for which Newton's method cycles; the last seven had been settled by
# Gauss-Seidel sweeps only, before there was a line search.
HARD = [
    *[(2, 97), (2, 179), (3, 62), (3, 279), (4, 106), (5, 222), (7, 61), (7, 423)],
    *[(2, 29), (2, 1121), (3, 112), (4, 9), (4, 208), (5, 26), (7, 0), (7, 111)],
    *[(2, 197), (2, 845), (3, 652), (4, 540), (4, 755), (5, 1468), (7, 804)],
]


@pytest.mark.parametrize(("points", "seed"), HARD)
def test_hard_cases(points, seed):
    """Nearly of rank three, friction up to 50: solved all the same, and counted as rescued."""
    W, q, friction = stiff(seed, points)
    local, bounds = LocalProblem(), Bounds.uniform(friction, points)
    f = local.solve(W, q, np.zeros_like(q), bounds)
    assert violation(W, q, f, bounds) < 1e-10
    assert sum(local.fallbacks.values()) == 1
    if points <= 4:
        (expected,) = all_solutions(W, q, friction)
        assert f == pytest.approx(expected, rel=1e-8, abs=1e-8 * np.abs(f).max())


# Points and seed of `block` for which Newton's method cycles.
HARD_IN_SPACE = [
    *[(2, 255), (2, 308), (2, 28), (2, 668), (7, 26), (7, 579)],
    *[(12, 69), (12, 164), (12, 490), (12, 586), (7, 20), (7, 123), (12, 466)],
    *[(2, 14), (2, 66), (2, 85), (7, 609), (12, 41), (12, 155), (12, 670)],
    *[(3, 6), (4, 191), (7, 483), (12, 84)],
]


@pytest.mark.parametrize(("points", "seed"), HARD_IN_SPACE)
def test_hard_cases_in_space(points, seed):
    W, q, bounds = block(seed, points)
    local = LocalProblem()
    f = local.solve(W, q, np.zeros_like(q), bounds)
    assert violation(W, q, f, bounds) < 1e-9
    assert sum(local.fallbacks.values()) == 1


def test_a_case_that_was_hard_for_lengths_by_the_diagonal():
    W, q, bounds = block(56, 2)
    local = LocalProblem()
    f = local.solve(W, q, np.zeros_like(q), bounds)
    assert violation(W, q, f, bounds) < 1e-9
    assert not local.fallbacks


def test_blocks_on_their_corners_are_solved_as_a_rule_without_fallbacks():
    rescued = 0
    for seed in range(100):
        W, q, bounds = block(seed, 4)
        local = LocalProblem()
        f = local.solve(W, q, np.zeros_like(q), bounds)
        assert violation(W, q, f, bounds) < 1e-9
        # From the solution of the same problem there is nothing to do.
        if not local.fallbacks:
            again = LocalProblem()
            same = again.solve(W, q, f, bounds)
            assert same == pytest.approx(f, abs=1e-8 * np.abs(f).max())
            assert not again.fallbacks
        rescued += sum(local.fallbacks.values())
    assert rescued <= 20


@pytest.mark.parametrize("d", [2, 3])
def test_a_problem_without_solution_is_given_up(d):
    """Two points that press each other down: y_n = -1 + f_n - 2 f_n of the other."""
    W = np.eye(2 * d).reshape(2, d, 2, d)
    W[0, 0, 1, 0] = W[1, 0, 0, 0] = -2.0
    q = np.tile(-np.eye(d)[0], (2, 1))
    with pytest.raises(NoContactSolution, match="2 points"):
        LocalProblem().solve(W, q, np.zeros_like(q), Bounds.uniform(0.5, 2))


@pytest.mark.parametrize("d", [2, 3])
def test_newton_gives_up_forces_beyond_all_numbers(d):
    """Those of an iteration that diverges; large ones, whose squares are infinite, scale."""
    W, q = easy(900, 4, d)
    r, states = lengths(d, W.reshape(q.size, q.size)), np.empty(4, dtype=np.int64)
    found = []
    for size in (1.0, 1e200, np.inf, np.nan):
        bounds, f = Bounds.uniform(0.5, 4), np.zeros(q.size)
        problem = d, W.reshape(q.size, q.size), size * q.ravel(), *bounds
        with np.errstate(over="ignore", invalid="ignore"):
            if meshed.newton(*problem, r, f, states, 30, False):
                found.append(f / size)
    assert len(found) == 2 and found[1] == pytest.approx(found[0])


def solution(W: np.ndarray, q: np.ndarray, law: Bounds) -> tuple[np.ndarray, np.ndarray]:
    """Forces and states from a cold start."""
    count = len(q) // 2
    f, states = np.zeros(2 * count), np.zeros(count, dtype=np.int64)
    assert meshed.solve(2, W, q, *law, f, states, new_counts())
    return f, states


def rigid_problem(seed: int, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Points of one rigid block, more of them than it has unknowns, driven into the floor."""
    random = np.random.default_rng(seed)
    G = np.zeros((2 * count, 3))
    x, y = random.uniform(-1, 1, count), random.uniform(-2, 0, count)
    G[::2, 1], G[1::2, 0], G[::2, 2], G[1::2, 2] = 1.0, 1.0, -x, y
    W = G @ np.diag([1.0, 1.0, random.uniform(0.5, 3.0)]) @ G.T
    W[np.diag_indices(2 * count)] *= 1 + 1e-9
    return W, G @ (random.normal(size=3) - np.array([0.0, 1.0, 0.0]))


def test_cohesion_holds_with_the_pressure() -> None:
    """|f_t| <= c + mu f_n, and nothing where the point is open."""
    law = Bounds(np.full(1, 0.5), np.full(1, 0.3))
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


def test_forces_of_the_same_problem_are_kept() -> None:
    """One linear solve from them, whatever their states."""
    W, q = rigid_problem(3, 2)
    law = Bounds.uniform(0.4, 2)
    expected, states = solution(W, q, law)
    f, following, counts = expected.copy(), np.zeros_like(states), new_counts()
    assert meshed.solve(2, W, q, *law, f, following, counts)
    assert counts[0] == 1 and not named(counts)
    assert (following == states).all()
    assert f == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("size", [1, 2, 3, 4, 5, 7, 24, 66])
def test_elimination(size: int) -> None:
    random = np.random.default_rng(1)
    matrix, right = random.normal(size=(size, size)), random.normal(size=size)
    solution = right.copy()
    assert meshed.solve_dense(matrix.copy(), solution)
    np.testing.assert_allclose(matrix @ solution, right, atol=1e-12)
    assert not meshed.solve_dense(np.zeros((size, size)), np.ones(size))


def test_elimination_needs_its_pivots() -> None:
    """A zero on the diagonal is none; numbers that are none have no solution."""
    turned, right = np.array([[0.0, 2.0], [1.0, 0.0]]), np.array([4.0, 3.0])
    assert meshed.solve_dense(turned, right)
    assert right.tolist() == [3.0, 2.0]
    for wrong in (np.nan, np.inf):
        assert not meshed.solve_dense(np.array([[1.0, 0.0], [0.0, wrong]]), np.ones(2))


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
    assert meshed.solve(3, W, q, *bounds, f, states, counts)
    m = len(mu)
    points = W.reshape(m, 3, m, 3), q.reshape(m, 3), f.reshape(m, 3)
    assert violation(*points, bounds) < 1e-6


def test_a_column_of_drums_whose_points_outnumber_its_motions() -> None:
    """22 points, 66 rows on 30 motions, and a diagonal of 1e-8 that makes the forces unique.

    They are unique nevertheless: the solution is exact, not one to within what the diagonal yields.
    """
    with np.load(Path(__file__).parent / "data" / "column_of_drums.npz") as recorded:
        W, q, mu, start = (recorded[name] for name in ("W", "q", "mu", "start"))
    f, counts, states = start.copy(), new_counts(), np.empty(len(mu), np.int64)
    bounds, m = Bounds(mu, np.zeros(len(mu))), len(mu)
    assert meshed.solve(3, W, q, *bounds, f, states, counts)
    points = W.reshape(m, 3, m, 3), q.reshape(m, 3), f.reshape(m, 3)
    assert violation(*points, bounds) < 1e-12
    assert named(counts) == {"proximal": 1}
