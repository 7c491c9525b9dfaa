"""The local problem of hundreds and thousands of points, by the steps of `solver.law.newton`.

A dense solve in each Newton step would cost the third power of the number of points. Here W is only
applied: the equations of a step are solved by GMRES, with the factors of an earlier step's as its
preconditioner. These are kept from step to step of a run and made anew where too many points have
changed their state since. Where that happens again and again while W stays the same, as where
points begin to slip one after another, the inverse of W takes the place of factors: it serves all
states alike (`solver.law.preconditioners`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from typing import Any

import numpy as np

from solver.law.friction import TOUCHING_SLOPE, Bounds
from solver.law.newton import (
    EXACT,
    Local,
    best_step,
    equations,
    error_of,
    lengths,
    project,
    trial_of,
)
from solver.law.newton_step import StepEquations
from solver.law.preconditioners import ComplianceDiagonal, Factors, Inverse
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


class ManyPoints:
    """Solver of local problems of many points that resemble one another from step to step."""

    def __init__(self) -> None:
        """Start without factors."""
        self._factors: Factors | None = None
        self._inverse: Inverse | None = None
        self._points: Indices = np.empty(0, np.int64)
        self._last: ComplianceDiagonal | None = None
        """The W that factors were made for last."""
        self._in_vain: ComplianceDiagonal | None = None
        """The W that was inverted in vain last."""
        self.factorizations = 0
        """How many were needed so far, of equations and of W."""

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
            before[:], step = states, StepEquations.at(local, r, trial, states)
            target = self._linearised(step, force, tolerance)
            part = 1.0 if halvings == 0 else best_step(local, r, force, target, halvings)
            force = target if part == 1.0 else force + part * (target - force)
        return False

    def _linearised(self, step: StepEquations, force: Array, tolerance: float) -> Array:
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
        for known in self._preconditioners(step, most):
            apply, before = known.of(step, self._points), known.used
            found = gmres(step.image, apply, residual, most, tolerance)
            known.wasted += max(0, known.used - before - GOOD_STEPS)
            if found is not None:
                return step.forces(start + found)
            known.wasted = math.inf
            del known, apply  # before the room for others is taken
        return np.full_like(force, np.nan)

    def _preconditioners(self, step: StepEquations, most: int) -> Iterator[Factors | Inverse]:
        """What is kept and may serve the equations of a Newton step, then what is made for it.

        Made are factors; the inverse of W where there have been factors for the same W already.
        `most` is how many steps of GMRES each may take.
        """
        if self._inverse is not None and self._is_good(self._inverse, step, most):
            yield self._inverse
        elif self._factors is not None and self._is_good(self._factors, step, most):
            yield self._factors
        local, points = step.local, self._points
        again = self._last is not None and self._last.resembles(local, points)
        in_vain = self._in_vain is not None and self._in_vain.resembles(local, points)
        self._factors = self._last = None  # before the room for others is taken
        if again and not in_vain and Inverse.pays(step):
            self._inverse = None
            self.factorizations += 1
            with suppress(np.linalg.LinAlgError):
                self._inverse = Inverse(local, points)
                yield self._inverse
            self._inverse, self._in_vain = None, ComplianceDiagonal(local, points)
        self.factorizations += 1
        self._last, self._factors = ComplianceDiagonal(local, points), Factors(step, points)
        yield self._factors

    def _is_good(self, kept: Factors | Inverse, step: StepEquations, most: int) -> bool:
        """Whether what is kept may serve a Newton step, and has not cost too much before."""
        return kept.wasted <= STALE * most * kept.COST and kept.serves(step, self._points)

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
