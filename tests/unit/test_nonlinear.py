"""Verdicts on iterations that SNES cannot finish."""

from collections.abc import Callable
from dataclasses import dataclass

from mpi4py import MPI

import numpy as np
import pytest

from solver.stepping.convergence import (
    Convergence,
    IterationRecord,
    IterationTolerances,
    IterationVerdict,
    ResidualTolerance,
)
from solver.stepping.nonlinear import NonlinearSolver
from solver.types import Array

pytestmark = pytest.mark.serial


@dataclass
class Problem:
    """A residual, and what turns it into a correction."""

    residual: Callable[[Array], Array]
    correction: Callable[[Array], Array]
    forces: float = 0.0
    acceleration: Callable[[], float] = lambda: 0.0


@pytest.mark.parametrize(
    ("factor", "reason"), [(-1.0, ""), (1e3, "the residual grows"), (0.5, "largest number")]
)
def test_an_iteration_that_diverges_is_ended_early(factor, reason):
    """Corrections of the right size, far too large ones, and ones of the wrong sign."""
    seen = []

    def residual(u: np.ndarray) -> np.ndarray:
        seen.append(u)
        return u

    solver = NonlinearSolver(MPI.COMM_SELF, 2, ZeroDivisionError)
    problem = Problem(residual, lambda r: np.asarray(factor * r))
    _, outcome = solver.solve(problem, np.ones(2), ResidualTolerance.of_norm(1e-9))
    solver.close()
    assert outcome.converged == (not reason)
    assert reason in outcome.reason
    assert len(seen) == {-1.0: 2, 1e3: 4, 0.5: 31}[factor]


def test_an_iteration_that_falls_slowly_is_followed_to_the_end():
    """By a fifth each time: neither round-off nor the end, however near that is."""
    solver = NonlinearSolver(MPI.COMM_SELF, 1, ZeroDivisionError)
    problem = Problem(lambda u: u, lambda r: np.asarray(-0.2 * r))
    _, outcome = solver.solve(problem, np.ones(1), ResidualTolerance.of_norm(0.05))
    solver.close()
    assert outcome.converged
    assert outcome.residual < 0.05


@pytest.mark.parametrize(
    ("residuals", "forces", "verdict"),
    [
        ([1e-12], 0.0, IterationVerdict.ITERATING),  # the first guess is corrected once in any case
        ([1.0, 1e-10], 0.0, IterationVerdict.SMALL_RESIDUAL),
        ([1.0, 0.5, 1e-10], 0.0, IterationVerdict.ITERATING),  # a slow rate says that it was chance
        ([1.0, 1e-6, 1e-10], 0.0, IterationVerdict.SMALL_RESIDUAL),
        (
            [1.0, 1.3e-8, 1.2e-8],
            0.0,
            IterationVerdict.SMALL_CORRECTION,
        ),  # round-off stays
        ([1.0, 2e-8, 1.9e-8], 0.0, IterationVerdict.ITERATING),  # too much for round-off
        ([1.0, 1.3e-8, 1e-8], 0.0, IterationVerdict.ITERATING),
        ([1.0, 1.7e-5, 1e-10], 0.0, IterationVerdict.SMALL_RESIDUAL),  # 2.9e-10 expected
        ([1.0, 1e-4, 1e-10], 0.0, IterationVerdict.ITERATING),  # 1e-8 expected: one more is certain
        ([1e-6, 1e3], 0.0, IterationVerdict.GROWING),
        (
            [1e-6, 1e3],
            1e4,
            IterationVerdict.ITERATING,
        ),  # contact has just brought this
        ([1e-12, 1e-2], 0.0, IterationVerdict.ITERATING),  # not much beside the tolerance
        ([1.0, np.nan], 0.0, IterationVerdict.NOT_A_NUMBER),
        ([1.0] * 31, 0.0, IterationVerdict.TOO_MANY_ITERATIONS),
        ([0.9**k for k in range(31)], 0.0, IterationVerdict.ITERATING),
    ],
)
def test_verdicts(residuals: list[float], forces: float, verdict: IterationVerdict) -> None:
    """At a tolerance of 1e-9 N."""
    record = IterationRecord(
        residuals, correction=1.0, unknowns=1.0, forces=forces, acceleration=lambda: 0.0
    )
    tolerances = IterationTolerances(ResidualTolerance(1e-9, 0.0, 1e-9), 0.0, 1e-15)
    assert Convergence().judge(record, tolerances) is verdict


@pytest.mark.parametrize(
    ("residuals", "acceleration", "verdict"),
    [
        ([1.0, 1e-10], 1e-11, IterationVerdict.SMALL_RESIDUAL),
        ([1.0, 1e-10], 3e-11, IterationVerdict.ITERATING),
        ([1.0, 1e-10, 0.95e-10], 3e-11, IterationVerdict.SMALL_CORRECTION),  # round-off
        ([1.0, 2e-10, 1.9e-10], 3e-11, IterationVerdict.ITERATING),  # too much for round-off
    ],
)
def test_a_small_residual_that_does_not_balance_itself_is_corrected(
    residuals: list[float], acceleration: float, verdict: IterationVerdict
) -> None:
    """At a tolerance of 1e-9 N, of 2e-11 m/s2 for the resultant, and round-off of 1e-11 N."""
    record = IterationRecord(
        residuals, correction=1.0, unknowns=1.0, forces=0.0, acceleration=lambda: acceleration
    )
    tolerances = IterationTolerances(ResidualTolerance(1e-9, 2e-11, 1e-11), 0.0, 1e-15)
    assert Convergence().judge(record, tolerances) is verdict
