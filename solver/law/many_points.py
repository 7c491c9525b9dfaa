"""The local problem of hundreds and thousands of points, by the steps of `dense_problem.hpp`.

A dense solve in each Newton step would cost the third power of the number of points. Here the
equations of a step are solved by GMRES, preconditioned by the factors of an earlier step, in which
points are known by their numbers, so that factors serve problems of other points, too. They are
kept from step to step of a run, and made anew where GMRES takes too long with them.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from solver.kernels import meshed
from solver.law.friction import TOUCHING_SLOPE, Bounds
from solver.types import Array, Indices

MANY_ROWS = 300
"""Rows of a local problem from which on it is solved here."""

ROUNDS = 40
"""Most Newton steps."""

GMRES_STEPS = (10, 150)
"""Fewest and most steps of GMRES after which the equations are factorized anew: in between, the
fortieth part of their number, which take about as long as the factors."""

GMRES_TOLERANCES = (1e-3, 1e-9)
"""Relative residuals of GMRES in a Newton step: while steps do well and states change, and
otherwise. Points of a stiff body share its rigid motions, so that forces may be far from right
where it is small; with the first alone Newton's method then wanders."""

PATIENCE = 8
"""Newton steps that need not make the error smaller."""

PROXIMAL_ROUNDS = 100
"""Problems with a proximal term that are tried."""

HARDENING, SOFTENING, HARDEST = 0.1, 3.0, 1e-12
"""Factors of that term after a problem solved and one not, and the least that is not 0."""

SHORTER = 1e-3
"""Part of the normal lengths r with which Newton's method tries again."""

ENOUGH = 10.0
"""Times the error tolerated, where proximal terms make it no smaller."""

EXACT = 0.02
"""Part of the error tolerated (`meshed.error_of`) that no further step makes smaller."""


class DenseProblem(NamedTuple):
    """A local problem, as compiled functions take it, field by field."""

    d: int
    """Rows of a point: 3 in space, 2 in the plane, 1 without friction."""
    W: Array
    """Compliance, (d m, d m), m/N; rows of a point side by side, normal first."""
    q: Array
    """Free values, (d m,), m."""
    mu: Array
    """Bounds of friction, as `Bounds` has them, like the next two."""
    cohesion: Array
    slope: float


class ManyPoints:
    """Solver of local problems of many points that resemble one another from step to step.

    Attributes:
        factorizations: How many were needed so far.
    """

    def __init__(self) -> None:
        """Start without factors."""
        self._factors: Any = None
        self._rows: Indices = np.empty(0, np.int64)
        """Rows of the equations of the factors, by numbers of the points."""
        self._points: Indices = np.empty(0, np.int64)
        self.factorizations = 0

    def solve(
        self,
        d: int,
        W: Array,
        q: Array,
        bounds: Bounds,
        f: Array,
        points: Indices | None = None,
    ) -> bool:
        """As `meshed.solve`: f is the guess and becomes the answer.

        By their numbers, (m,), points are known again in problems of other points.
        """
        self._points = np.arange(len(bounds.mu)) if points is None else points
        if d == 1 or np.any(bounds.mu > 0.0) or np.any(bounds.cohesion > 0.0):
            return self._settle(DenseProblem(d, W, q, *bounds), f)
        normal = f[::d].copy()
        smooth = DenseProblem(1, np.ascontiguousarray(W[::d, ::d]), q[::d].copy(), *bounds)
        settled = self._settle(smooth, normal)
        f[:] = 0.0
        f[::d] = normal
        return settled

    def _settle(self, local: DenseProblem, f: Array) -> bool:
        """Newton's method, then the proximal point algorithm, with cohesion built up."""
        r = np.empty((len(local.mu), 2))
        meshed.lengths(local.d, local.W, r)
        if self._newton(local, r, f):
            return True
        local = local._replace(slope=TOUCHING_SLOPE)
        if self._by_proximal_terms(local, r, f, cohesion_only=False):
            return True
        afresh = np.zeros_like(f)
        if self._by_proximal_terms(local, r, afresh, cohesion_only=True):
            f[:] = afresh
            return True
        return False

    def _newton(self, local: DenseProblem, r: Array, f: Array, moves: bool = False) -> bool:
        """Newton's method from f with full steps; if it does not settle, f stays as it is.

        One is made in any case if it `moves`, else only where f is not the solution.
        """
        force, trial, nearest = f.copy(), np.empty_like(f), np.empty_like(f)
        states = np.empty(len(r), np.int64)
        error, least, since, careful = np.inf, np.inf, 0, False
        before = np.full_like(states, -9)
        for k in range(ROUNDS + 1):
            last = error
            meshed.trial_of(*local, r, force, trial)
            meshed.project(*local, trial, nearest, states)
            error = meshed.error_of(local.d, force, trial, nearest)
            # Forces that only balance each other show last: it goes on while that makes it better.
            if k == 0:
                if error <= EXACT and not moves:
                    return True
            elif error <= EXACT or (error <= 1.0 and error > 0.5 * last):
                f[:] = nearest
                return True
            least, since = (error, 0) if error < least else (least, since + 1)
            if not error < np.inf or since > PATIENCE:
                return False
            careful = careful or since > 0
            tolerance, least_tolerance = GMRES_TOLERANCES
            if careful or np.array_equal(states, before):
                tolerance = max(least_tolerance, min(tolerance, EXACT / max(error, EXACT)))
            before[:] = states
            force = self._linearised(local, r, trial, states, force, tolerance)
        return False

    def _linearised(
        self,
        local: DenseProblem,
        r: Array,
        trial: Array,
        states: Indices,
        force: Array,
        tolerance: float,
    ) -> Array:
        """The root of f - P(f - r y), linearised at `trial`, from forces before it."""
        from scipy.linalg import lu_factor, lu_solve

        rows: Indices = np.empty(len(trial), np.int64)
        rows = rows[: meshed.unknowns(*local, states, rows)]
        A, right = np.empty((len(rows), len(rows))), np.empty(len(rows))
        meshed.equations(*local, r, trial, states, rows, A, right)
        x, found = force[rows], np.empty_like(force)
        numbered = self._points[rows // local.d] * local.d + rows % local.d
        most = min(max(GMRES_STEPS[0], len(rows) // 40), GMRES_STEPS[1])
        change = None
        if self._factors is not None:
            change = gmres(A, self._preconditioner(A, numbered), right - A @ x, most, tolerance)
        if change is None:
            self._factors = None  # before the room for others is taken
            self._factors, self._rows = lu_factor(A, check_finite=False), numbered
            self.factorizations += 1
            x = lu_solve(self._factors, right, check_finite=False)
        else:
            x = x + change
        meshed.write_forces(*local, trial, states, rows, x, found)
        return found

    def _preconditioner(self, A: Array, numbered: Indices) -> Any:
        """Approximate solver by the factors, of numbered rows; by the diagonal where these miss."""
        from scipy.linalg import lu_solve

        _, here, there = np.intersect1d(
            numbered, self._rows, assume_unique=True, return_indices=True
        )
        factors, diagonal, whole = self._factors, A.diagonal().copy(), np.zeros(len(self._rows))

        def apply(right: Array) -> Array:
            result = right / diagonal
            whole[there] = right[here]
            result[here] = lu_solve(factors, whole, check_finite=False)[there]
            return result

        return apply

    def _by_proximal_terms(
        self, local: DenseProblem, r: Array, f: Array, cohesion_only: bool
    ) -> bool:
        """The proximal point algorithm, as in `dense_problem.hpp`, from f; r are its lengths."""
        softness, last, now = 1.0, np.inf, f.copy()
        soft, free, lengths = local.W.copy(), np.empty_like(f), np.empty_like(r)
        trial, nearest, states = np.empty_like(f), np.empty_like(f), np.empty(len(r), np.int64)
        eased = local._replace(W=soft, q=free)
        for _ in range(PROXIMAL_ROUNDS):
            meshed.ease(*local, softness, cohesion_only, now, soft, free, lengths)
            if not self._newton(eased, lengths, now, moves=True):
                lengths[:, 0] *= SHORTER
                if not self._newton(eased, lengths, now, moves=True):
                    softness = SOFTENING * max(softness, HARDEST)
                    continue
            meshed.trial_of(*local, r, now, trial)
            meshed.project(*local, trial, nearest, states)
            error = meshed.error_of(local.d, now, trial, nearest)
            if error <= ENOUGH and error >= 0.5 * last:
                f[:] = now
                return True
            last, softness = error, HARDENING * softness
            if softness < HARDEST:
                softness = 0.0
        return False


def gmres(A: Array, precondition: Any, right: Array, steps: int, tolerance: float) -> Array | None:
    """GMRES, preconditioned from the right; None where it does not get there in so many steps.

    Args:
        A: Matrix, (n, n).
        precondition: M^-1 b.
        right: b.
        steps: Most of them.
        tolerance: What may be left of the residual.
    """
    from scipy.sparse.linalg import LinearOperator
    from scipy.sparse.linalg import gmres as solve

    if not np.isfinite(right).all():
        return None
    operator = LinearOperator(A.shape, lambda x: A @ precondition(x), dtype=float)
    found, left = solve(operator, right, rtol=tolerance, restart=steps, maxiter=1)
    return None if left else np.asarray(precondition(found))
