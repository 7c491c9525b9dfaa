"""The local contact problem: Signorini and Coulomb at points coupled by a small dense matrix.

`solver.law.newton` states the problem. Newton's method settles nearly all of them; behind it stand
slower methods, and the names of those that settled a problem are counted.
"""

from __future__ import annotations

from collections import Counter

import numpy as np

from solver.law.compiled import compiled
from solver.law.friction import TOUCHING_SLOPE, Bounds, is_frictionless
from solver.law.many_points import MANY_ROWS, ManyPoints
from solver.law.newton import Local, lengths, newton
from solver.law.one_point import settle_one_point
from solver.law.rescues import RESCUES, rescue
from solver.types import Array, Indices

#: What can become of a local problem, as counted.
OUTCOMES = ("Newton", "touching", *RESCUES, "velocity solve left out")
#: Linear solves of Newton's method, and two more for each point.
ROUNDS = 20
#: Rows of a problem of many points up to which these methods are tried, too.
RESCUED_ROWS = 600


class NoContactSolution(Exception):
    """The local problem was settled by no method; a smaller time step is the remedy."""


def new_counts() -> Indices:
    """Room to count outcomes."""
    return np.zeros(len(OUTCOMES), dtype=np.int64)


def named(counts: Indices) -> Counter[str]:
    """What was needed besides Newton's method, by name."""
    return Counter({name: int(n) for name, n in zip(OUTCOMES[1:], counts[1:], strict=True) if n})


def image(W: Array, f: Array) -> Array:
    """W f for points (m, d)."""
    return (W.reshape(f.size, f.size) @ f.ravel()).reshape(f.shape)


@compiled
def solve(
    d: int,
    W: Array,
    q: Array,
    bounds: Bounds,
    f: Array,
    states: Indices,
    counts: Indices,
) -> bool:
    """Solve a local problem; False where no method settled it.

    Args:
        d: Rows of a point: 3 in space, 2 in the plane.
        W: Compliance, (d m, d m), m/N.
        q: Free values, (d m,), m.
        bounds: Of friction; where none of the points has any, tangential rows are dropped.
        f: Guess and answer, (d m,), N.
        states: Left as those of the answer, `OPEN`, `STICK` or else slip, (m,).
        counts: Of outcomes, see `OUTCOMES`.
    """
    if is_frictionless(bounds):
        normal = f[::d].copy()
        local = Local(1, W[::d, ::d].copy(), q[::d].copy(), bounds)
        settled = _settle(local, normal, states, counts)
        f[:] = 0.0
        f[::d] = normal
        return settled
    return _settle(Local(d, W, q, bounds), f, states, counts)


@compiled
def solve_points(
    W: Array, q: Array, mu: Array, cohesion: Array, slope: float, f: Array, counts: Indices
) -> bool:
    """As `solve`, with W (m, d, m, d), q and f (m, d), and the fields of the bounds one by one."""
    (m, d), bounds = q.shape, Bounds(mu, cohesion, slope)
    states = np.empty(m, np.int64)
    flat = W.reshape(d * m, d * m)
    return solve(d, flat, q.reshape(d * m), bounds, f.reshape(d * m), states, counts)


@compiled
def _settle(local: Local, f: Array, states: Indices, counts: Indices) -> bool:
    """Newton's method, then the slower ones.

    All cohesion at once may lift its own point, and then there is no solution: behind the first
    try it is built up over the first pressure instead.
    """
    if len(states) == 1 and local.bounds.cohesion[0] == 0.0 and settle_one_point(local, f, states):
        counts[0] += 1
        return True
    r, rounds = lengths(local.d, local.W, True), ROUNDS + 2 * len(states)
    if newton(local, r, f, states, rounds, 0):
        counts[0] += 1
        return True
    if np.any(local.bounds.cohesion > 0.0):
        touching = Bounds(local.bounds.mu, local.bounds.cohesion, TOUCHING_SLOPE)
        local = Local(local.d, local.W, local.q, touching)
        if newton(local, r, f, states, rounds, 0):
            counts[1] += 1
            return True
    for method in range(len(RESCUES)):
        if rescue(method, local, f, states):
            counts[2 + method] += 1
            return True
    return False


class LocalProblem:
    """Solver of local problems of points with d rows each, as arrays (m, d)."""

    def __init__(self) -> None:
        """Begin without having solved any."""
        self.counts = new_counts()
        self.forget()

    def forget(self) -> None:
        """Keep nothing from problem to problem, so that the next one does not depend on them."""
        self._many, self._impulses = ManyPoints(), ManyPoints()

    @property
    def rescues(self) -> Counter[str]:
        """How many problems needed what besides Newton's method."""
        return named(self.counts)

    def solve(
        self, W: Array, q: Array, start: Array, bounds: Bounds, points: Indices | None = None
    ) -> Array:
        """Forces (m, d) for compliance W (m, d, m, d), free values q (m, d) and a guess (m, d).

        By their numbers, (m,), many points are known again in the next problem.

        Raises:
            NoContactSolution: Where every method failed.
        """
        m, force = len(start), np.ascontiguousarray(start).copy()
        whole, free = np.ascontiguousarray(W), np.ascontiguousarray(q)
        if force.size > MANY_ROWS:
            settled = self._settle(self._many, whole, free, bounds, force, points)
        else:
            settled = not m or solve_points(whole, free, *bounds, force, self.counts)
        if not settled:
            raise NoContactSolution(f"the local contact problem of {m} points did not settle")
        return force

    def impulses(
        self, W: Array, q: Array, bounds: Bounds, p: Array, points: Indices | None
    ) -> bool:
        """Solve for the impulses of many points, (m, d); p is the guess and becomes the answer."""
        return self._settle(self._impulses, W, q, bounds, p, points)

    def _settle(
        self,
        many: ManyPoints,
        W: Array,
        q: Array,
        bounds: Bounds,
        f: Array,
        points: Indices | None,
    ) -> bool:
        """By the solver of many points, then by the methods for few of them."""
        flat = W.reshape(f.size, f.size), q.reshape(-1)
        if many.solve(f.shape[1], *flat, bounds, f.reshape(-1), points):
            return True
        return f.size <= RESCUED_ROWS and solve_points(W, q, *bounds, f, self.counts)
