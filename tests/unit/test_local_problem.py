"""The condensed contact problem: the law itself, all 4^m states one by one, and the hard cases."""

from itertools import product

import numpy as np
import pytest
from scipy.optimize import nnls

from solver.contact.local_problem import (
    LocalProblem,
    NoContactSolution,
    image,
    row_sum_scaling,
)

RESCUES = ["_tresca", "_projected", "_gauss_seidel"]


def easy(seed: int, points: int) -> tuple[np.ndarray, np.ndarray]:
    """A well conditioned compliance and free values of either sign."""
    rng = np.random.default_rng(seed)
    matrix = rng.standard_normal((2 * points, 2 * points))
    W = matrix @ matrix.T / (2 * points) + np.eye(2 * points)
    return W.reshape(points, 2, points, 2), rng.standard_normal((points, 2)) - (0.5, 0.0)


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


def violation(W: np.ndarray, q: np.ndarray, f: np.ndarray, friction: float) -> float:
    """By how much forces break the law, relative to the largest force and free value."""
    y = (q + image(W, f)) / np.abs(q).max()
    f = f / (np.abs(f).max() or 1.0)
    worst = [np.max(-f[:, 0]), np.max(-y[:, 0]), np.minimum(np.abs(f[:, 0]), np.abs(y[:, 0])).max()]
    bound = friction * f[:, 0]
    worst.append(np.max(np.abs(f[:, 1]) - bound) / max(friction, 1.0))
    for k in np.flatnonzero(f[:, 0] > 1e-12):
        within = (bound[k] - abs(f[k, 1])) / max(friction, 1.0)
        against = y[k, 1] * np.sign(f[k, 1])
        worst.append(min(abs(y[k, 1]), max(within, against)))
    return float(max(worst))


def all_solutions(W: np.ndarray, q: np.ndarray, friction: float) -> list[np.ndarray]:
    """Every solution, by trying open, sticking, slipping left, slipping right for every point."""
    size = q.size
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
                matrix[t, n] = friction if state == "left" else -friction
        f = np.linalg.solve(matrix, right).reshape(q.shape)
        if violation(W, q, f, friction) < 1e-10:
            found.append(f)
    return found


@pytest.mark.parametrize("points", [1, 2, 3, 5, 12])
@pytest.mark.parametrize("friction", [0.3, 0.9])
def test_the_law_holds(points, friction):
    states = set()
    for seed in range(30):
        W, q = easy(seed, points)
        f = LocalProblem(friction).solve(W, q, np.zeros_like(q))
        assert violation(W, q, f, friction) < 1e-10
        sticks = np.abs(f[:, 1]) < friction * f[:, 0] * (1 - 1e-12)
        states |= {"closed" if n > 0 else "open" for n in f[:, 0]}
        states |= {"stick" if s else "slip" for s in sticks[f[:, 0] > 0]}
    assert states == {"open", "closed", "stick", "slip"}


@pytest.mark.parametrize("points", [1, 2, 3, 4])
def test_agrees_with_the_enumeration_of_all_states(points):
    for seed in range(12):
        W, q = easy(100 + seed, points)
        expected = all_solutions(W, q, 0.5)
        assert len(expected) == 1
        f = LocalProblem(0.5).solve(W, q, np.zeros_like(q))
        assert f == pytest.approx(expected[0], abs=1e-10)


@pytest.mark.parametrize("points", [1, 2, 6, 15])
def test_without_friction_it_is_a_least_squares_problem(points):
    """min f.W f/2 + q.f, f >= 0, by scipy's nnls; no tangential force."""
    for seed in range(10):
        W, q = easy(200 + seed, points)
        lower = np.linalg.cholesky(W[:, 0, :, 0])
        expected, _ = nnls(lower.T, -np.linalg.solve(lower, q[:, 0]))
        f = LocalProblem(0.0).solve(W, q, np.zeros_like(q))
        assert f[:, 0] == pytest.approx(expected, abs=1e-10)
        assert not f[:, 1].any()


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
    f = LocalProblem(0.3).solve(W, np.array([q]), np.zeros((1, 2)))
    assert f[0] == pytest.approx(force)


def test_a_sticking_pair_of_a_rigid_body_by_hand():
    """Two corners at x = -1 and 1 under a weight of 2 and no moment: each carries half of it."""
    rigid = np.array([[[0, 1, -1], [1, 0, 0]], [[0, 1, 1], [1, 0, 0]]], dtype=float)
    W = np.einsum("iak,jbk->iajb", rigid, rigid)
    W += 1e-9 * np.eye(4).reshape(2, 2, 2, 2)
    q = rigid @ (0.2, -2.0, 0.0)
    f = LocalProblem(0.5).solve(W, q, np.zeros_like(q))
    assert f == pytest.approx(np.array([[1.0, -0.1], [1.0, -0.1]]), abs=1e-6)


def test_the_guess_and_what_is_remembered_change_nothing():
    rng = np.random.default_rng(5)
    remembering = LocalProblem(0.4)
    for seed in range(20):
        W, q = easy(300 + seed, 4)
        expected = LocalProblem(0.4).solve(W, q, np.zeros_like(q))
        f = remembering.solve(W, q, 3 * rng.standard_normal((4, 2)))
        assert f == pytest.approx(expected, abs=1e-10)
        again = remembering.solve(W, q, f, row_sum_scaling(W))
        assert again == pytest.approx(expected, abs=1e-10)


def test_image_is_the_matrix_product():
    W, q = easy(1, 3)
    for i, a in np.ndindex(3, 2):
        expected = sum(W[i, a, j, b] * q[j, b] for j, b in np.ndindex(3, 2))
        assert image(W, q)[i, a] == pytest.approx(expected)


@pytest.mark.parametrize("rescue", RESCUES)
@pytest.mark.parametrize("points", [1, 3, 8])
def test_every_rescue_finds_what_newton_finds(rescue, points):
    for seed in range(10):
        W, q = easy(400 + seed, points)
        newton = LocalProblem(0.6)
        expected = newton.solve(W, q, np.zeros_like(q))
        assert not newton.rescues
        local = LocalProblem(0.6)
        found = getattr(local, rescue)(W, q, np.zeros_like(q), row_sum_scaling(W))
        assert found == pytest.approx(expected, abs=1e-10)


# Points and seed of `stiff` for which Newton's method cycles, by the method that settles them.
HARD = {
    "_tresca": [(2, 97), (2, 179), (3, 62), (3, 279), (4, 106), (5, 222), (7, 61), (7, 423)],
    "_projected": [(2, 29), (2, 1121), (3, 112), (4, 9), (4, 208), (5, 26), (7, 0), (7, 111)],
    "_gauss_seidel": [(2, 197), (2, 845), (3, 652), (4, 540), (4, 755), (5, 1468), (7, 804)],
}


@pytest.mark.parametrize(
    ("method", "points", "seed"), [(method, *case) for method in HARD for case in HARD[method]]
)
def test_hard_cases(method, points, seed):
    """Nearly of rank three, friction up to 50: solved all the same, and counted as rescued."""
    W, q, friction = stiff(seed, points)
    local = LocalProblem(friction)
    f = local.solve(W, q, np.zeros_like(q))
    assert violation(W, q, f, friction) < 1e-10
    assert sum(local.rescues.values()) == 1
    directly = getattr(LocalProblem(friction), method)(W, q, 0 * q, row_sum_scaling(W))
    assert directly == pytest.approx(f, rel=1e-8, abs=1e-8 * np.abs(f).max())
    if points <= 4:
        (expected,) = all_solutions(W, q, friction)
        assert f == pytest.approx(expected, rel=1e-8, abs=1e-8 * np.abs(f).max())


def test_without_patience_a_hard_case_is_given_up():
    points, seed = HARD["_projected"][0]
    W, q, friction = stiff(seed, points)
    for patience in (0, 1):  # Newton's method alone, and with the Tresca fixed point
        with pytest.raises(NoContactSolution, match=f"{points} points"):
            LocalProblem(friction, patience=patience).solve(W, q, np.zeros_like(q))
