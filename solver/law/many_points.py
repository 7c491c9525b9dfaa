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
    OPEN,
    STICK,
    Local,
    best_step,
    error_of,
    lengths,
    project,
    trial_of,
)
from solver.types import Array, Indices

MANY_ROWS = 600
"""Rows of a local problem from which on it is solved here."""

ROUNDS = 40
"""Most Newton steps."""

HALVINGS = 12
"""Halvings of a step by the line search."""

GMRES_STEPS = (40, 150)
"""Fewest and most steps of GMRES after which the equations are factorized anew: in between, the
hundredth part of their number, which take about as long as the factors."""

GMRES_TOLERANCES = (1e-3, 1e-8)
"""What GMRES leaves of the residual of a Newton step while states change and where they stay."""

PROXIMAL_ROUNDS = 30
"""Problems with a proximal term that are tried."""


class _Equations(NamedTuple):
    """The equations of a Newton step for the forces of closed points: A x = b.

    With P(tau) = l e of a point that slips, of derivative e dl + (l/|tau|)(I - e e^T) dtau.

    Attributes:
        local: The problem.
        rows: Rows of closed points among all, (n,).
        scale: r of these rows.
        slip: Which points slip: places of their normal rows among `rows`, (k,).
        e: Directions of their friction, (k, d - 1).
        slope: dl/df_n, (k,).
        intercept: l - slope f_n, (k,), N.
        share: l/|tau|, (k,).
    """

    local: Local
    rows: Indices
    scale: Array
    slip: Indices
    e: Array
    slope: Array
    intercept: Array
    share: Array

    @classmethod
    def at(cls, local: Local, r: Array, trial: Array, states: Indices) -> _Equations:
        """The equations, linearised at f - r y."""
        d, bounds = local.d, local.bounds
        closed = np.flatnonzero(states != OPEN)
        rows = (closed[:, None] * d + np.arange(d)).ravel()
        scale = np.column_stack([r[closed, :1]] + [r[closed, 1:]] * (d - 1)).ravel()
        which = np.flatnonzero(states[closed] != STICK) if d > 1 else np.empty(0, np.int64)
        points = closed[which]
        tau = trial.reshape(-1, d)[points, 1:]
        normal, size = trial.reshape(-1, d)[points, 0], np.linalg.norm(tau, axis=1)
        grows = bounds.slope * normal < bounds.cohesion[points]
        slope = np.where(grows, bounds.mu[points] + bounds.slope, bounds.mu[points])
        intercept = np.where(grows, 0.0, bounds.cohesion[points])
        limit, length = slope * normal + intercept, np.where(size > 0, size, 1.0)
        e = tau / length[:, None]
        return cls(local, rows, scale, which * d, e, slope, intercept, limit / length)

    @property
    def tangential(self) -> Indices:
        """Places of the tangential rows of points that slip, (k, d - 1)."""
        return np.asarray(self.slip[:, None] + np.arange(1, self.local.d))

    def across(self, vectors: Array) -> Array:
        """(l/|tau|)(I - e e^T) x of points that slip, (k, d - 1) or (k, d - 1, n)."""
        e = self.e.reshape(self.e.shape + (1,) * (vectors.ndim - 2))
        share = self.share.reshape((-1,) + (1,) * (vectors.ndim - 1))
        along = np.sum(e * vectors, axis=1, keepdims=True)
        return np.asarray(share * (vectors - e * along))

    def right(self) -> Array:
        """The right-hand side b."""
        value = -self.scale * self.local.q[self.rows]
        if len(self.slip):
            t = self.tangential
            value[t] = self.e * self.intercept[:, None] + self.across(value[t])
        return value

    def image(self, x: Array) -> Array:
        """A x."""
        force = np.zeros(len(self.local.q))
        force[self.rows] = x
        value = self.scale * (self.local.W @ force)[self.rows]
        if len(self.slip):
            t = self.tangential
            along = self.e * (self.slope * x[self.slip])[:, None]
            value[t] = x[t] - along - self.across(x[t] - value[t])
        return value

    def matrix(self) -> Array:
        """A."""
        A = self.local.W[np.ix_(self.rows, self.rows)]
        A *= self.scale[:, None]
        if len(self.slip):
            t, k = self.tangential, np.arange(len(self.slip))
            A[t] = self.across(A[t])
            d = self.local.d
            own = np.eye(d - 1) - self.across(np.tile(np.eye(d - 1), (len(k), 1, 1)))
            for i in range(d - 1):
                A[t[:, i], self.slip] -= self.slope * self.e[:, i]
                for j in range(d - 1):
                    A[t[:, i], t[:, j]] += own[:, i, j]
        return A

    def diagonal(self) -> Array:
        """Diagonal of A, that of slipping points taken as 1."""
        value = self.scale * self.local.W[self.rows, self.rows]
        value[self.tangential] = 1.0
        return value


class _Factors:
    """LU factors of the equations of a Newton step, for those of later ones."""

    def __init__(self, equations: _Equations):
        """Factorize the matrix of the equations of a Newton step."""
        from scipy.linalg import lu_factor

        self.rows = equations.rows
        self._lu = lu_factor(equations.matrix(), overwrite_a=True, check_finite=False)

    def preconditioner(self, equations: _Equations) -> Any:
        """What nearly solves other equations; point by point where the factors know none."""
        from scipy.linalg import lu_solve

        _, here, there = np.intersect1d(
            equations.rows, self.rows, assume_unique=True, return_indices=True
        )
        diagonal = equations.diagonal()

        def apply(right: Array) -> Array:
            result, whole = right / diagonal, np.zeros(len(self.rows))
            whole[there] = right[here]
            result[here] = lu_solve(self._lu, whole, check_finite=False)[there]
            return result

        return apply


class ManyPoints:
    """Solver of local problems of many points that resemble one another from step to step."""

    def __init__(self) -> None:
        """Start without factors."""
        self._factors: _Factors | None = None
        self.factorizations = 0
        """How many were needed so far."""

    def solve(self, d: int, W: Array, q: Array, bounds: Bounds, f: Array) -> bool:
        """As `solver.law.local_problem.solve`: f is the guess and becomes the answer."""
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
        error, seen, before = np.inf, np.full_like(states, -9), np.full_like(states, -9)
        for k in range(ROUNDS + 1):
            last, trial = error, trial_of(local, r, force)
            project(local, trial, nearest, states)
            error = error_of(local.d, force, trial, nearest)
            # Forces that only balance each other show last: it goes on while that makes it better.
            if error <= EXACT or (k > 0 and error <= 1.0 and error > 0.5 * last):
                f[:] = force if error <= EXACT and k == 0 else nearest
                return True
            if not error < np.inf or (halvings == 0 and k > 8 and np.array_equal(states, seen)):
                return False
            if k & (k + 1) == 0 and error > 1e3:
                seen[:] = states
            tolerance = GMRES_TOLERANCES[int(np.array_equal(states, before))]
            before[:] = states
            target = self._linearised(_Equations.at(local, r, trial, states), force, tolerance)
            step = 1.0 if halvings == 0 else best_step(local, r, force, target, halvings)
            force = target if step == 1.0 else force + step * (target - force)
        return False

    def _linearised(self, equations: _Equations, force: Array, tolerance: float) -> Array:
        """The forces that solve the equations of a Newton step, from those before it."""
        result, rows = np.zeros_like(force), equations.rows
        if len(rows) <= MANY_ROWS:
            try:
                result[rows] = np.linalg.solve(equations.matrix(), equations.right())
            except np.linalg.LinAlgError:
                result[:] = np.nan
            return result
        start = force[rows]
        residual = equations.right() - equations.image(start)
        steps = min(max(GMRES_STEPS[0], len(rows) // 100), GMRES_STEPS[1])
        found = None
        if self._factors is not None:
            apply = self._factors.preconditioner(equations)
            found = gmres(equations.image, apply, residual, steps, tolerance)
        if found is None:
            self._factors = None  # before the room for others is taken
            self._factors = _Factors(equations)
            self.factorizations += 1
            apply = self._factors.preconditioner(equations)
            found = gmres(equations.image, apply, residual, steps, tolerance)
        result[rows] = np.nan if found is None else start + found
        return result

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
    basis, ways = [right / norm], []
    H = np.zeros((steps + 1, steps))
    for k in range(steps):
        ways.append(precondition(basis[k]))
        vector = image(ways[k])
        for _ in range(2):  # once more: what is left of others would be amplified
            for j, other in enumerate(basis):
                part = float(other @ vector)
                H[j, k] += part
                vector = vector - part * other
        H[k + 1, k] = np.linalg.norm(vector)
        if not np.isfinite(H[k + 1, k]):
            return None
        target = np.zeros(k + 2)
        target[0] = norm
        share = np.linalg.lstsq(H[: k + 2, : k + 1], target, rcond=None)[0]
        if np.linalg.norm(H[: k + 2, : k + 1] @ share - target) <= tolerance * norm:
            return np.asarray(np.einsum("k,kn->n", share, np.array(ways)))
        basis.append(vector / H[k + 1, k])
    return None
