"""A step is what a full Newton method makes of the same equations, while contact changes."""

import numpy as np
import pytest

from benchmarks.full_newton import SOFT, agreement, changes, run, scene_of
from benchmarks.newton.contact_terms import PointLaw
from benchmarks.newton.solve import FullNewton
from solver.build.assembly import build, initial_state
from solver.law.friction import Bounds
from solver.stepping.step import balance_of, extrapolated


@pytest.mark.parametrize(("cells", "steps"), [((6, 12), 14), ((3, 2, 7), 12)])
def test_steps_agree_with_a_full_newton_method(cells: tuple[int, ...], steps: int) -> None:
    """A landing: points close, stick, slip and open; both ways stop at the same residual."""
    ours, textbook = (run(scene_of(cells, 1.0, SOFT), steps, full=full) for full in (False, True))
    displacements, forces = agreement(ours, textbook)
    assert displacements < 1e-9
    assert forces < 1e-8
    assert changes(ours) >= 4
    # Newton's method with the whole tangent: quadratic, whatever states change.
    assert sum(step.iterations for step in textbook.steps) <= 4.5 * steps


@pytest.mark.parametrize("cells", [(3, 4), (2, 2, 3)])
def test_the_tangent_is_the_derivative_of_the_residual(cells: tuple[int, ...]) -> None:
    """In a strained, turned state in which points stick, slip and are open."""
    scene, random = scene_of(cells, 1.0, SOFT), np.random.default_rng(1)
    assembly = build(scene)
    stepper = assembly.stepper
    state, _ = initial_state(scene, assembly)
    newton = FullNewton(stepper.system, stepper.links)
    step = stepper._begin(state, 1e-3)
    weights = [body.weights(step.scheme, 1e-3) for body in stepper.system.bodies]
    balance = balance_of(stepper.system, state, step, weights)
    u = extrapolated(stepper.system, state, step.turning)
    u += 1e-2 * random.standard_normal(len(u))
    (memory,) = balance.contact
    law = PointLaw.of(stepper.links[0].interface, memory)
    here = newton.place(balance, u)
    force, change = law.linearized(here.y, np.zeros_like(here.y), 1e8)
    assert (force[:, 0] > 0).any()
    # Forces that are settled at their states move with y alone.
    newton.assemble(balance, here, force, change)
    way = random.standard_normal(len(u))
    vector, product = newton.tangent.createVecs()
    vector.array[:] = way
    newton.tangent.mult(vector, product)
    h, ends = 1e-7, []
    for side in (1, -1):
        there = newton.place(balance, u + side * h * way)
        moved = force + np.einsum("pij,pj->pi", change, there.y - here.y)
        ends.append(newton.residual(balance, there, moved))
    expected = (ends[0] - ends[1]) / (2 * h)
    assert np.abs(product.array - expected).max() < 1e-6 * np.abs(expected).max()


@pytest.mark.parametrize("d", [2, 3])
def test_the_law_at_points_is_linearized_rightly(d: int) -> None:
    """Forces that settle the law to first order have the derivative that goes with them."""
    random, points = np.random.default_rng(d), 40
    law = PointLaw(
        softness=random.uniform(0.5, 2.0, points),
        anchor=random.standard_normal((points, d - 1)),
        bounds=Bounds.uniform(0.6, points),
        active=np.ones(points, dtype=bool),
    )
    y, force = random.standard_normal((2, points, d))
    for _ in range(60):
        force, change = law.linearized(y, force, 0.3)
    assert law.error(y, force, 0.3) < 1e-12
    stick = np.linalg.norm(force[:, 1:], axis=1) < 0.6 * force[:, 0] * (1 - 1e-9)
    is_open = force[:, 0] == 0
    assert stick.any() and is_open.any() and (~stick & ~is_open).any()
    h, way = 1e-6, random.standard_normal(y.shape)
    ends = []
    for side in (1, -1):
        there = force
        for _ in range(60):
            there, _ = law.linearized(y + side * h * way, there, 0.3)
        ends.append(there)
    expected = (ends[0] - ends[1]) / (2 * h)
    assert np.allclose(np.einsum("pij,pj->pi", change, way), expected, atol=1e-6)
