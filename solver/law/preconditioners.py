"""What nearly solves the equations of a Newton step: factors or an inverse of an earlier one.

Both know points by their numbers, so that they serve problems of other points, too.
"""

from __future__ import annotations

from functools import partial
from typing import Any, NamedTuple

import numpy as np

from solver.law.compiled import compiled
from solver.law.friction import line
from solver.law.newton import SLIP, Local, equations, sliding
from solver.law.newton_step import StepEquations
from solver.types import Array, Indices

SIMILAR = 0.01
"""Relative change of the diagonal of W below which an inverse of it is still a good one."""


class Factors:
    """LU factors of the equations of a Newton step, for those of later ones.

    Attributes:
        used: How often they were applied.
        wasted: Applications beyond those that good factors need, which the owner counts; infinite
            once GMRES has failed with them.
    """

    COST = 1.0
    """What they take to be made, over LU factors of all equations."""

    def __init__(self, step: StepEquations, points: Indices):
        """Factorize the matrix of the equations of a Newton step, by numbers of the points."""
        from scipy.linalg import lu_factor

        self.rows, self.used, self.wasted = _numbered(step, points), 0, 0.0
        matrix, _ = equations(*step)
        # The transposed one, which lies as LAPACK has it, is overwritten without a copy.
        self._lu = lu_factor(matrix.T, overwrite_a=True, check_finite=False)

    def serves(self, step: StepEquations, points: Indices) -> bool:
        """Whether they are to be tried for other equations: for any."""
        return True

    def of(self, step: StepEquations, points: Indices) -> Any:
        """What nearly solves other equations; point by point where the factors know none."""
        from scipy.linalg import lu_solve

        _, here, there = np.intersect1d(
            _numbered(step, points), self.rows, assume_unique=True, return_indices=True
        )
        diagonal = step.diagonal()

        def apply(right: Array) -> Array:
            self.used += 1
            result, whole = right / diagonal, np.zeros(len(self.rows))
            whole[there] = right[here]
            result[here] = lu_solve(self._lu, whole, trans=1, check_finite=False)[there]
            return result

        return apply


def _numbered(step: StepEquations, points: Indices) -> Indices:
    """The unknowns by numbers of their points, which are the same in other problems, too."""
    point, way = np.divmod(step.rows, step.local.d)
    return np.asarray(points[point] * step.local.d + way)


class ComplianceDiagonal:
    """The diagonal of W by numbers of the points: whether another W is much the same."""

    def __init__(self, local: Local, points: Indices):
        """Take the diagonal of a problem of points with these numbers, which rise."""
        self.points = points
        # A copy: a view would keep all of W.
        self._diagonal = local.W.diagonal().copy().reshape(len(points), local.d)

    def places(self, points: Indices) -> Indices:
        """Where points of these numbers stand here; -1: nowhere."""
        place = np.minimum(np.searchsorted(self.points, points), len(self.points) - 1)
        place[self.points[place] != points] = -1
        return place

    def resembles(self, local: Local, points: Indices) -> bool:
        """Whether the W of another problem is much the same, and all its points are known."""
        place = self.places(points)
        if (place < 0).any() or local.d != self._diagonal.shape[1]:
            return False
        before = self._diagonal[place]
        change = np.abs(local.W.diagonal().reshape(before.shape) - before)
        return bool((change <= SIMILAR * before).all())


class Inverse:
    """The inverse P of W, which solves for any states of the points.

    Positions y = W f are known along the normals of closed points, and where a point sticks.
    Elsewhere the law gives the force: none at an open point, and friction by the normal force at
    one that slips. With f = P y only the positions of these rows are to be solved for: few
    equations where few points slip or are open.

    Attributes:
        used: How often it was applied.
        wasted: As that of `Factors`.
    """

    COST = 3.0
    """What it takes to be made, over LU factors of all equations."""

    FREE_PART = 0.6
    """Part of all rows up to which it serves: those of points that slip or are open have equations
    of their own, which are factorized in each Newton step. Where all points of a block in space
    slip it is 2/3: factors then serve from step to step, and a block of 576 points that slides
    takes 0.8 of the time that it takes with the inverse."""

    def __init__(self, local: Local, points: Indices):
        """Invert W of a problem whose points have these numbers."""
        from scipy.linalg import inv

        self.used, self.wasted, self._made_of = 0, 0.0, ComplianceDiagonal(local, points)
        self._P: Array = inv(local.W, check_finite=False)

    @classmethod
    def pays(cls, step: StepEquations) -> bool:
        """Whether one would serve the states of a step if it were made for it."""
        return len(step.trial) - np.count_nonzero(step.holds()) <= cls.FREE_PART * len(step.trial)

    def serves(self, step: StepEquations, points: Indices) -> bool:
        """Whether it is close to the inverse of the W of a step, and solves for few unknowns."""
        free = len(self._P) - np.count_nonzero(step.holds())
        few = bool(free <= self.FREE_PART * len(self._P))
        return few and self._made_of.resembles(step.local, points)

    def of(self, step: StepEquations, points: Indices) -> Any:
        """What nearly solves the equations of a Newton step, all of whose points are known."""
        d, P, place = step.local.d, self._P, self._made_of.places(points)
        point, way = np.divmod(step.rows, d)
        row, holds, scale = d * place[point] + way, step.holds(), step.scales()
        unknown = np.ones(len(P), dtype=np.bool_)
        unknown[row[holds]] = False
        free = unknown.nonzero()[0]
        slips = _Slips.of(step, d * place, free)
        solve = slips.solver(P[free[:, None], free], P[slips.normals[:, None], free])
        moved = np.searchsorted(free, row[~holds])

        def apply(right: Array) -> Array:
            self.used += 1
            y = np.zeros(len(P))
            y[row[holds]] = right[holds] / scale[holds]
            force = P @ y
            if len(free):
                given = -slips.of_law(force[free], force[slips.normals])
                given[moved] += right[~holds]
                y[free] = solve(given)
                force = P @ y
            return np.asarray(force[row])

        return apply


class _Slips(NamedTuple):
    """The law of points that slip, in the rows of an inverse in which positions are unknown.

    Attributes:
        step: Equations of a Newton step.
        normals: Row of the normal force of each of its points in the inverse, (m,).
        first: Place of the first tangential force of each among the unknown rows, (m,); -1 for a
            point that does not slip, or without friction.
    """

    step: StepEquations
    normals: Indices
    first: Indices

    @classmethod
    def of(cls, step: StepEquations, normals: Indices, free: Indices) -> _Slips:
        """Find tangential forces among the unknown rows, which rise."""
        first, bounds = np.full(len(normals), -1), step.local.bounds
        slips = (np.abs(step.states) >= SLIP) & ((bounds.mu > 0.0) | (bounds.cohesion > 0.0))
        if step.local.d > 1:
            first[slips] = np.searchsorted(free, normals[slips] + 1)
        return cls(step, normals, first)

    def of_law(self, force: Array, normal: Array) -> Array:
        """What the law makes of forces in the unknown rows and of normal forces of all points."""
        left = force[:, None].copy()
        step = self.step
        slip_rows(step.local, step.trial, step.states, self.first, left, normal[:, None].copy())
        return left[:, 0]

    def solver(self, system: Array, normals: Array) -> Any:
        """Solver for the positions of the unknown rows; None where there are none.

        `system` has the rows and columns of the inverse at the unknown rows and is used up,
        `normals` its rows of normal forces.
        """
        from scipy.linalg import lu_factor, lu_solve

        if not len(system):
            return None
        step = self.step
        slip_rows(step.local, step.trial, step.states, self.first, system, normals)
        slip_diagonal(step.local, step.r, step.trial, self.first, system)
        # The transposed one, which lies as LAPACK has it, is overwritten without a copy.
        factors = lu_factor(system.T, overwrite_a=True, check_finite=False)
        return partial(lu_solve, factors, trans=1, check_finite=False)


@compiled
def slip_rows(
    local: Local,
    trial: Array,
    states: Indices,
    first: Indices,
    values: Array,
    normals: Array,
) -> None:
    """Turn rows of tangential forces of points that slip into those of their law (M52).

    In the plane that is f_t - s e f_n with the bound l = s f_n + c and e = 1 or -1. In space, with
    e = tau/|tau| and I - e e^T = b b^T, it is (I - (l/|tau|) b b^T) f_t - s e f_n.

    Args:
        local: The problem.
        trial: f - r y, at which the law is linearised, (d m,).
        states: Of its points, (m,).
        first: Row of the first tangential force of each point in `values`, (m,).
        values: Rows that give tangential forces, (u, n).
        normals: Those that give the normal force of each point, (m, n).
    """
    for i in range(len(states)):
        a = first[i]
        if a < 0:
            continue
        if local.d == 2:
            slope, _ = line(local.bounds, i, trial[2 * i])
            values[a] -= (slope if states[i] > 0 else -slope) * normals[i]
            continue
        along, aside, share, slope, _ = sliding(local.bounds, trial, i)
        across = share * (along * values[a + 1] - aside * values[a])
        values[a] += aside * across - (slope * along) * normals[i]
        values[a + 1] -= along * across + (slope * aside) * normals[i]


@compiled
def slip_diagonal(local: Local, r: Array, trial: Array, first: Indices, matrix: Array) -> None:
    """Add r (l/|tau|) b b^T, by which positions turn friction in space, to rows of `slip_rows`."""
    for i in range(len(first)):
        a = first[i]
        if local.d < 3 or a < 0:
            continue
        along, aside, share, _, _ = sliding(local.bounds, trial, i)
        weight = share * r[i, 1]
        matrix[a, a] += weight * aside * aside
        matrix[a, a + 1] -= weight * aside * along
        matrix[a + 1, a] -= weight * along * aside
        matrix[a + 1, a + 1] += weight * along * along
