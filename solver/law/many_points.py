"""The local problem of hundreds and thousands of points, by the steps of `solver.law.newton`.

A dense solve in each Newton step would cost the third power of the number of points. Here W is only
applied: the equations of a step are solved by GMRES, with the factors of an earlier step's as its
preconditioner. These are kept from step to step of a run and made anew where too many points have
changed their state since.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from solver.law.friction import TOUCHING_SLOPE, Bounds
from solver.law.newton import (
    EXACT,
    STICK,
    Local,
    best_step,
    equations,
    error_of,
    left_over,
    lengths,
    project,
    trial_of,
    unknowns,
    write_forces,
)
from solver.types import Array, Indices

MANY_ROWS = 300
"""Rows of a local problem from which on it is solved here."""

ROUNDS = 40
"""Most Newton steps."""

HALVINGS = 12
"""Halvings of a step by the line search."""

GMRES_STEPS = (10, 150)
"""Fewest and most steps of GMRES after which the equations are factorized anew: in between, the
fortieth part of their number, which take about as long as the factors."""

GMRES_TOLERANCES = (1e-3, 1e-9)
"""What GMRES leaves of the residual of a Newton step: while steps do well and states change, and
otherwise. Points of a stiff body share its rigid motions, so that forces may be far from right
where it is small; with the first alone Newton's method then wanders."""

GOOD_STEPS, STALE = 3, 2.0
"""Steps of GMRES that good factors need at most, and what all steps beyond these may cost before
the factors are made anew: so many times as much as new ones."""

PATIENCE = 8
"""Newton steps that need not make the error smaller."""

PROXIMAL_ROUNDS = 30
"""Problems with a proximal term that are tried."""


class _Equations(NamedTuple):
    """The equations of a Newton step, A x = b, as `solver.law.newton.equations` has them.

    Attributes:
        local: The problem.
        r: Its lengths, (m, 2).
        trial: f - r y, at which they are linearised, (d m,), N.
        states: Of the points, (m,).
        rows: Rows of the unknowns x among all, (n,).
    """

    local: Local
    r: Array
    trial: Array
    states: Indices
    rows: Indices

    @classmethod
    def at(cls, local: Local, r: Array, trial: Array, states: Indices) -> _Equations:
        """Equations for the forces of closed points."""
        return cls(local, r, trial, states, unknowns(local, states))

    def forces(self, x: Array, *, change: bool = False) -> Array:
        """All forces by the unknowns, or their change by one of these."""
        found, constants = np.empty_like(self.trial), 0.0 if change else 1.0
        write_forces(self.local, self.trial, self.states, self.rows, x, constants, found)
        return found

    def residual(self, x: Array) -> Array:
        """What x leaves of the right-hand side, b - A x."""
        return -left_over(*self, x, self.local.W @ self.forces(x), 1.0)

    def image(self, x: Array) -> Array:
        """A x."""
        return left_over(*self, x, self.local.W @ self.forces(x, change=True), 0.0)

    def diagonal(self) -> Array:
        """Diagonal of A, that of slipping points in space taken as 1."""
        point, way = np.divmod(self.rows, self.local.d)
        value = self.r[point, np.minimum(way, 1)] * self.local.W[self.rows, self.rows]
        value[(way > 0) & (self.states[point] != STICK)] = 1.0
        return value


class _Factors:
    """LU factors of the equations of a Newton step, for those of later ones."""

    def __init__(self, equations_: _Equations, points: Indices):
        """Factorize the matrix of the equations of a Newton step, by numbers of the points."""
        from scipy.linalg import lu_factor

        self.rows, self.used = _numbered(equations_, points), 0
        matrix, _ = equations(*equations_)
        # The transposed one, which lies as LAPACK has it, is overwritten without a copy.
        self._lu = lu_factor(matrix.T, overwrite_a=True, check_finite=False)

    def preconditioner(self, equations_: _Equations, points: Indices) -> Any:
        """What nearly solves other equations; point by point where the factors know none."""
        from scipy.linalg import lu_solve

        _, here, there = np.intersect1d(
            _numbered(equations_, points), self.rows, assume_unique=True, return_indices=True
        )
        diagonal = equations_.diagonal()

        def apply(right: Array) -> Array:
            self.used += 1
            result, whole = right / diagonal, np.zeros(len(self.rows))
            whole[there] = right[here]
            result[here] = lu_solve(self._lu, whole, trans=1, check_finite=False)[there]
            return result

        return apply


def _numbered(equations_: _Equations, points: Indices) -> Indices:
    """The unknowns by numbers of their points, which are the same in other problems, too."""
    point, way = np.divmod(equations_.rows, equations_.local.d)
    return np.asarray(points[point] * equations_.local.d + way)


class ManyPoints:
    """Solver of local problems of many points that resemble one another from step to step."""

    def __init__(self) -> None:
        """Start without factors."""
        self._factors: _Factors | None = None
        self._points: Indices = np.empty(0, np.int64)
        self._wasted = 0
        self.factorizations = 0
        """How many were needed so far."""

    def solve(
        self,
        d: int,
        W: Array,
        q: Array,
        bounds: Bounds,
        f: Array,
        points: Indices | None = None,
    ) -> bool:
        """As `solver.law.local_problem.solve`: f is the guess and becomes the answer.

        By their numbers, (m,), points are known again in problems of other points.
        """
        self._points = np.arange(len(bounds.mu)) if points is None else points
        local = Local(d, W, q, bounds)
        if d > 1 and not (np.any(bounds.mu > 0.0) or np.any(bounds.cohesion > 0.0)):
            local = Local(1, np.ascontiguousarray(W[::d, ::d]), q[::d].copy(), bounds)
            normal = f[::d].copy()
            settled = self._settle(local, normal)
            f[:] = 0.0
            f[::d] = normal
            return settled
        return self._settle(local, f)

    def _settle(self, local: Local, f: Array) -> bool:
        """Newton's method, with line search, with cohesion built up, with proximal terms."""
        if self._settles(local, f):
            return True
        if np.any(local.bounds.cohesion > 0.0):
            touching = Bounds(local.bounds.mu, local.bounds.cohesion, TOUCHING_SLOPE)
            local = Local(local.d, local.W, local.q, touching)
            if self._settles(local, f):
                return True
        return self._by_proximal_terms(local, f)

    def _settles(self, local: Local, f: Array) -> bool:
        """Newton's method with full steps, then with line search and either length r."""
        for shared, halvings in ((True, 0), (True, HALVINGS), (False, HALVINGS)):
            if self._newton(local, lengths(local.d, local.W, shared), f, halvings):
                return True
        return False

    def _newton(self, local: Local, r: Array, f: Array, halvings: int) -> bool:
        """Newton's method from f; whether it settled. If not, f stays as it is."""
        force, nearest, states = f.copy(), np.empty_like(f), np.empty(len(r), np.int64)
        error, least, since, careful = np.inf, np.inf, 0, False
        before = np.full_like(states, -9)
        for k in range(ROUNDS + 1):
            last, trial = error, trial_of(local, r, force)
            project(local, trial, nearest, states)
            error = error_of(local.d, force, trial, nearest)
            # Forces that only balance each other show last: it goes on while that makes it better.
            if error <= EXACT or (k > 0 and error <= 1.0 and error > 0.5 * last):
                f[:] = force if error <= EXACT and k == 0 else nearest
                return True
            least, since = (error, 0) if error < least else (least, since + 1)
            if not error < np.inf or since > PATIENCE:
                return False
            careful = careful or since > 0
            tolerance, least_tolerance = GMRES_TOLERANCES
            if careful or np.array_equal(states, before):
                tolerance = min(tolerance, max(least_tolerance, EXACT / error))
            before[:], step = states, _Equations.at(local, r, trial, states)
            target = self._linearised(step, force, tolerance)
            part = 1.0 if halvings == 0 else best_step(local, r, force, target, halvings)
            force = target if part == 1.0 else force + part * (target - force)
        return False

    def _linearised(self, step: _Equations, force: Array, tolerance: float) -> Array:
        """The forces that solve the equations of a Newton step, from those before it."""
        if len(step.rows) <= MANY_ROWS:
            try:
                solution: Any = np.linalg.solve(*equations(*step))
            except np.linalg.LinAlgError:
                return np.full_like(force, np.nan)
            return step.forces(solution)
        start = force[step.rows]
        residual = step.residual(start)
        most = min(max(GMRES_STEPS[0], len(start) // 40), GMRES_STEPS[1])
        found, factors = None, self._factors
        if factors is not None and self._wasted <= STALE * most:
            apply, before = factors.preconditioner(step, self._points), factors.used
            found = gmres(step.image, apply, residual, most, tolerance)
            self._wasted += max(0, factors.used - before - GOOD_STEPS)
        if found is None:
            self._factors = factors = None  # before the room for others is taken
            self._factors, self._wasted = _Factors(step, self._points), 0
            self.factorizations += 1
            apply = self._factors.preconditioner(step, self._points)
            found = gmres(step.image, apply, residual, most, tolerance)
        return np.full_like(force, np.nan) if found is None else step.forces(start + found)

    def _by_proximal_terms(self, local: Local, f: Array) -> bool:
        """The proximal point algorithm, as in `solver.law.rescues`."""
        softness, now = 1e-2, f.copy()
        for _ in range(PROXIMAL_ROUNDS):
            soft, added = local.W.copy(), softness * np.diag(local.W)
            soft[np.diag_indices(len(f))] += added
            eased = Local(local.d, soft, local.q - added * now, local.bounds)
            if not self._settles(eased, now):
                softness *= 3.0
                continue
            trial = now.copy()
            if self._newton(local, lengths(local.d, local.W, True), trial, 0):
                f[:] = trial
                return True
            softness = max(1e-8, 0.1 * softness)
        return False


def gmres(
    image: Any, precondition: Any, right: Array, steps: int, tolerance: float
) -> Array | None:
    """GMRES, preconditioned from the right; None where it does not get there in so many steps.

    Args:
        image: A x.
        precondition: M^-1 b.
        right: b.
        steps: Most of them.
        tolerance: What may be left of the residual.
    """
    norm = float(np.linalg.norm(right))
    if not 0.0 < norm < np.inf:
        return np.zeros_like(right) if norm == 0.0 else None
    basis, ways = np.empty((steps + 1, len(right))), np.empty((steps, len(right)))
    H, basis[0] = np.zeros((steps + 1, steps)), right / norm
    for k in range(steps):
        ways[k] = precondition(basis[k])
        vector = image(ways[k])
        for _ in range(2):  # once more: what is left of others would be amplified
            parts = basis[: k + 1] @ vector
            H[: k + 1, k] += parts
            vector -= parts @ basis[: k + 1]
        H[k + 1, k] = np.linalg.norm(vector)
        if not np.isfinite(H[k + 1, k]):
            return None
        target = np.zeros(k + 2)
        target[0] = norm
        share = np.linalg.lstsq(H[: k + 2, : k + 1], target, rcond=None)[0]
        left = float(np.linalg.norm(H[: k + 2, : k + 1] @ share - target)) / norm
        if left <= tolerance:
            return np.asarray(share @ ways[: k + 1])
        basis[k + 1] = vector / H[k + 1, k]
    return None
