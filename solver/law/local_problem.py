"""The local contact problem: Signorini and Coulomb at points coupled by a small dense matrix.

`solver/kernels/dense_problem.hpp` states the problem. Newton's method settles nearly all of them;
behind it stands the proximal point algorithm, and how often it was needed is counted.
"""

from __future__ import annotations

from collections import Counter

import numpy as np

from solver.kernels import meshed
from solver.law.friction import Bounds
from solver.law.many_points import MANY_ROWS, ManyPoints
from solver.types import Array, Indices

#: What can become of a local problem, as counted.
OUTCOMES = ("Newton", "proximal", "velocity solve left out")
#: Rows of a problem of many points up to which the methods for few of them are tried, too.
FALLBACK_ROWS = 600


class NoContactSolution(Exception):
    """The local problem did not settle; a smaller time step is the remedy."""


def new_counts() -> Indices:
    """Room to count outcomes."""
    return np.zeros(len(OUTCOMES), dtype=np.int64)


def named(counts: Indices) -> Counter[str]:
    """Counts of what was needed besides Newton's method, by name."""
    return Counter({name: int(n) for name, n in zip(OUTCOMES[1:], counts[1:], strict=True) if n})


def image(W: Array, f: Array) -> Array:
    """W f for points (m, d)."""
    return (W.reshape(f.size, f.size) @ f.ravel()).reshape(f.shape)


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
    def fallbacks(self) -> Counter[str]:
        """Numbers of problems that needed more than Newton's method, by name of the outcome."""
        return named(self.counts)

    def solve(
        self, W: Array, q: Array, start: Array, bounds: Bounds, points: Indices | None = None
    ) -> Array:
        """Forces (m, d) for compliance W (m, d, m, d), free values q (m, d) and a guess (m, d).

        By their numbers, (m,), many points are known again in the next problem.

        Raises:
            NoContactSolution: Where neither method settled it.
        """
        m, force = len(start), np.ascontiguousarray(start).copy()
        whole, free = np.ascontiguousarray(W), np.ascontiguousarray(q)
        if force.size > MANY_ROWS:
            settled = self._settle(self._many, whole, free, bounds, force, points)
        else:
            settled = not m or meshed.solve_points(whole, free, *bounds, force, self.counts)
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
        return f.size <= FALLBACK_ROWS and meshed.solve_points(W, q, *bounds, f, self.counts)
