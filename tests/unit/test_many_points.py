"""Local problems of hundreds of points: the small solver's answer, and the law at every point."""

from typing import Any

import numpy as np
import pytest

from solver.kernels import meshed
from solver.law import many_points
from solver.law.friction import Bounds
from solver.law.local_problem import LocalProblem, image, new_counts
from solver.law.many_points import MANY_ROWS, ManyPoints, gmres
from solver.law.velocity import impulse_correction
from tests.unit.test_local_problem import block, violation


def half_space(side: int, d: int) -> tuple[np.ndarray, np.ndarray]:
    """Compliance of side^2 points on an elastic body of its own mass, and their places, (m, 2)."""
    line = (np.arange(side) + 0.5) / side - 0.5
    x, y = (axis.ravel() for axis in np.meshgrid(line, line))
    apart = np.hypot(x[:, None] - x, y[:, None] - y)
    m, near = len(x), 0.3 / side
    kernel = 1e-2 / np.maximum(apart, near) / m
    rigid = np.zeros((m, 3, 6))  # translations, and turns about three axes, of a body of height 2
    rigid[:, [0, 1, 2], [0, 1, 2]] = 1.0
    rigid[:, 0, 3], rigid[:, 1, 3] = 3 * x, -3.0
    rigid[:, 0, 4], rigid[:, 2, 4] = 3 * y, -3.0
    rigid[:, 1, 5], rigid[:, 2, 5] = -2 * y, 2 * x
    rows = np.ascontiguousarray(rigid[:, :d]).reshape(d * m, 6)
    W = (rows @ rows.T).reshape(m, d, m, d)
    for k in range(d):
        W[:, k, :, k] += kernel + 1e-2 * np.eye(m) / m * side
    return W, np.stack([x, y], axis=1)


def pressed(places: np.ndarray, d: int, *, tilt: float, push: float) -> np.ndarray:
    """Free values of a block pressed down, tilted and pushed along, (m, d)."""
    q = np.zeros((len(places), d))
    q[:, 0] = -1.0 + tilt * places[:, 0]
    q[:, 1] = push - tilt - 0.3 * push * places[:, 1]
    if d == 3:
        q[:, 2] = 0.3 * push * places[:, 0]
    return q


def law_violation(W: np.ndarray, q: np.ndarray, f: np.ndarray, bounds: Bounds) -> float:
    """By how much forces break the law, over the largest force or displacement."""
    y = q + image(W, f)
    size, way = np.linalg.norm(f[:, 1:], axis=1), np.linalg.norm(y[:, 1:], axis=1)
    limit = np.where(f[:, 0] > 0, bounds.mu * f[:, 0] + bounds.cohesion, 0.0)
    force, length = np.abs(f).max(), np.abs(q).max()
    inside = size < limit * (1 - 1e-9)
    against = np.sum(f[:, 1:] * y[:, 1:], axis=1) + size * way
    return float(
        max(
            np.max(-f[:, 0]) / force,
            np.max(-y[:, 0]) / length,
            np.max(np.abs(f[:, 0] * y[:, 0])) / (force * length),
            np.max(size - limit) / force,
            np.max(way[inside], initial=0.0) / length,
            np.max(against[f[:, 0] > 0], initial=0.0) / (force * length),
        )
    )


CASES = {
    "sticks": (0.0, 0.2, 0.7, 0.0),
    "slides": (0.0, 0.9, 0.3, 0.0),
    "half lifted": (3.0, 0.3, 0.6, 0.0),
    "coheres": (1.0, 0.5, 0.3, 1e-5),
    "smooth": (1.0, 0.5, 0.0, 0.0),
}


@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("case", CASES)
def test_the_answer_is_that_of_the_small_solver(case: str, d: int) -> None:
    tilt, push, mu, cohesion = CASES[case]
    W, places = half_space(18, d)
    q, m = pressed(places, d, tilt=tilt, push=push), len(places)
    assert q.size > MANY_ROWS
    bounds = Bounds(np.full(m, mu), np.full(m, cohesion))
    small = np.zeros((m, d))
    assert meshed.solve_points(W, q, *bounds, small, new_counts())
    many = LocalProblem().solve(W, q, np.zeros((m, d)), bounds)
    np.testing.assert_allclose(many, small, rtol=0, atol=1e-9 * np.abs(small).max())
    assert law_violation(W, q, many, bounds) < 1e-10


def test_a_thousand_points_obey_the_law_with_one_factorization_while_they_stick() -> None:
    """A block that is pushed ever harder."""
    W, places = half_space(32, 3)
    m, force, solver = len(places), np.zeros((1024, 3)), ManyPoints()
    bounds, flat = Bounds.uniform(5.0, m), W.reshape(3 * m, 3 * m)
    for k in range(4):
        q = pressed(places, 3, tilt=0.01 * k, push=0.02 * k)
        assert solver.solve(3, flat, q.ravel(), bounds, force.reshape(-1))
        assert law_violation(W, q, force, bounds) < 1e-10
    assert solver.factorizations == 1
    assert (force[:, 0] > 0).all()


def test_factors_serve_a_block_that_lifts_on_one_side() -> None:
    W, places = half_space(18, 3)
    m, force, solver = len(places), np.zeros((324, 3)), ManyPoints()
    bounds, flat = Bounds.uniform(5.0, m), W.reshape(3 * m, 3 * m)
    for tilt in (0.0, 1.8):
        q = pressed(places, 3, tilt=tilt, push=0.08)
        assert solver.solve(3, flat, q.ravel(), bounds, force.reshape(-1))
        assert law_violation(W, q, force, bounds) < 1e-10
    assert 0 < np.count_nonzero(force[:, 0] > 0) < m
    assert solver.factorizations < 8


@pytest.mark.slow
def test_points_that_begin_to_slip_one_after_another_obey_the_law() -> None:
    W, places = half_space(18, 3)
    m, force, solver, slipping = len(places), np.zeros((324, 3)), ManyPoints(), []
    bounds, flat = Bounds.uniform(0.1, m), W.reshape(3 * m, 3 * m)
    for push in np.arange(0.06, 0.09, 0.004):
        q = pressed(places, 3, tilt=0.0, push=float(push))
        assert solver.solve(3, flat, q.ravel(), bounds, force.reshape(-1))
        assert law_violation(W, q, force, bounds) < 1e-10
        size = np.linalg.norm(force[:, 1:], axis=1)
        slipping.append(int(np.count_nonzero(size > 0.1 * force[:, 0] * (1 - 1e-9))))
    assert slipping[0] == 0
    assert slipping == sorted(slipping)
    assert slipping[-1] > 200
    assert solver.factorizations < 60


@pytest.mark.parametrize("d", [2, 3])
def test_impulses_of_many_points_are_those_of_the_small_solver(d: int) -> None:
    W, places = half_space(18, d)
    m, rng = len(places), np.random.default_rng(3)
    bounds = Bounds.uniform(0.5, m)
    impulse = np.abs(rng.standard_normal((m, d))) / m
    impulse[::2, 1:] *= 0.1
    impulse[1::2, 1:] *= (
        0.5 * impulse[1::2, :1] / np.linalg.norm(impulse[1::2, 1:], axis=1, keepdims=True)
    )
    velocity = pressed(places, d, tilt=1.0, push=0.2)
    found = impulse_correction(LocalProblem(), velocity, W, impulse, bounds, 1.0)
    q = np.empty((m, d))
    small = meshed.correct_impulses(W, velocity, impulse, *bounds, 1.0, False, new_counts(), q)
    assert found is not None
    assert small[0]
    np.testing.assert_allclose(found.q, q, rtol=0, atol=1e-9 * np.abs(q).max())
    assert found.contact == pytest.approx(small[1], rel=1e-8)
    assert found.friction == pytest.approx(small[2], rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("seed", [6, 8, 12, 24, 45])
def test_what_newtons_method_leaves_is_settled(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Points under a rigid block, friction up to 50, some with cohesion."""
    W, q, bounds = block(seed, 104)
    force, terms, ease = np.zeros_like(q), [], meshed.ease

    def counted(*arguments: Any) -> None:
        terms.append(arguments[6])
        ease(*arguments)

    monkeypatch.setattr(many_points.meshed, "ease", counted)
    flat = W.reshape(q.size, q.size), q.ravel(), bounds, force.reshape(-1)
    assert ManyPoints().solve(3, *flat)
    assert len(terms) > 1
    assert violation(W, q, force, bounds) < 1e-9


def test_gmres_says_when_it_does_not_get_there() -> None:
    rng = np.random.default_rng(0)
    A, b = rng.standard_normal((200, 200)), rng.standard_normal(200)
    assert gmres(A, lambda x: x, b, 5, 1e-8) is None
    found = gmres(A, lambda x: np.linalg.solve(A + 1e-3, x), b, 40, 1e-8)
    assert found is not None
    np.testing.assert_allclose(A @ found, b, atol=1e-7 * np.linalg.norm(b))


def test_newtons_method_does_not_wander_where_a_block_lifts(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It took hundreds of steps where GMRES left a thousandth of each one's residual."""
    W, places = half_space(18, 3)
    m, force, solver, steps = len(places), np.zeros((324, 3)), ManyPoints(), []

    def counted(*arguments: Any) -> np.ndarray | None:
        steps.append(1)
        return gmres(*arguments)

    monkeypatch.setattr(many_points, "gmres", counted)
    bounds, flat = Bounds.uniform(1.0, m), W.reshape(3 * m, 3 * m)
    for k in range(7):
        q = pressed(places, 3, tilt=3 * np.sin(np.pi * k / 19), push=0.05 * np.sin(np.pi * k / 9.5))
        assert solver.solve(3, flat, q.ravel(), bounds, force.reshape(-1))
        assert law_violation(W, q, force, bounds) < 1e-10
    assert np.count_nonzero(force[:, 0] > 0) == 202
    assert len(steps) < 100


def test_points_are_known_again_by_their_numbers() -> None:
    """After points before them are gone, the factors serve the others."""
    W, places = half_space(18, 3)
    bounds, solver, forces = Bounds.uniform(5.0, 324), ManyPoints(), np.zeros((324, 3))
    made = []
    for numbers in (np.arange(324), np.arange(4, 324)):
        part = np.ascontiguousarray(W[numbers][:, :, numbers])
        q, force = pressed(places[numbers], 3, tilt=0.1, push=0.05), forces[numbers]
        some = Bounds(bounds.mu[numbers], bounds.cohesion[numbers])
        flat = part.reshape(q.size, q.size), q.ravel(), some, force.reshape(-1)
        assert solver.solve(3, *flat, numbers)
        assert law_violation(part, q, force, some) < 1e-10
        forces[numbers] = force
        made.append(solver.factorizations)
    assert made[1] == made[0]
