"""What SNES is told about an iteration that gets nowhere."""

from mpi4py import MPI

import numpy as np
import pytest

from solver.stepping.nonlinear import NonlinearSolver

pytestmark = pytest.mark.serial


@pytest.mark.parametrize(
    ("factor", "reason"), [(-1.0, ""), (1e3, "the residual grows"), (0.5, "largest number")]
)
def test_an_iteration_that_diverges_is_ended_early(factor, reason):
    """Corrections of the right size, far too large ones, and ones of the wrong sign."""
    seen = []

    def residual(u: np.ndarray) -> np.ndarray:
        seen.append(u)
        return u

    solver = NonlinearSolver(
        MPI.COMM_SELF, 2, residual, lambda r: np.asarray(factor * r), ZeroDivisionError
    )
    _, outcome = solver.solve(np.ones(2), 1e-9)
    solver.destroy()
    assert outcome.converged == (not reason)
    assert reason in outcome.reason
    assert len(seen) == {-1.0: 2, 1e3: 4, 0.5: 31}[factor]


def test_an_iteration_that_falls_slowly_is_followed_to_the_end():
    """By a fifth each time: neither round-off nor the end, however near that is."""
    solver = NonlinearSolver(
        MPI.COMM_SELF, 1, lambda u: u, lambda r: np.asarray(-0.2 * r), ZeroDivisionError
    )
    _, outcome = solver.solve(np.ones(1), 0.05)
    solver.destroy()
    assert outcome.converged
    assert outcome.residual < 0.05
