"""The condensed contact problem: Signorini and Coulomb at points coupled by a small dense matrix.

Unknown are the point forces f = (normal, tangential) of m points with

    y = q + W f,   0 <= f_n  complementary to  y_n >= 0,   |f_t| <= c + mu f_n,  y_t opposite to f_t
    where |f_t| is at its bound and 0 elsewhere,

and f_t = 0 where f_n = 0: cohesion needs contact. In 3-D |f_t| is the length of two components. A
Newton method settles nearly all problems; behind it stands a chain of slower methods, and `rescues`
counts what each one settled.
"""

from __future__ import annotations

from collections import Counter
from itertools import islice

import numpy as np

from solver.law.friction import Bounds
from solver.law.local_disc import DiscSolver
from solver.law.local_plane import PlaneSolver
from solver.law.local_system import (
    LocalSystem,
    NoContactSolution,
    diagonal_scaling,
    image,
    row_sum_scaling,
)
from solver.types import Array

__all__ = ["LocalProblem", "NoContactSolution", "image", "row_sum_scaling"]


class LocalProblem:
    """Solver of local problems; remembers the last states."""

    def __init__(self, dimension: int = 2, *, patience: int | None = None):
        """Set up.

        Args:
            dimension: 2 or 3.
            patience: How many of the methods behind Newton's may be tried; None for all.
        """
        self._dimension, self._patience = dimension, patience
        self.rescues: Counter[str] = Counter()
        self._plane, self._disc = PlaneSolver(), DiscSolver()
        (self._plane if dimension == 2 else self._disc).get_ready()

    def solve(
        self,
        W: Array,
        q: Array,
        start: Array,
        bounds: Bounds,
        scaling: Array | None = None,
    ) -> Array:
        """Forces (m, d) for compliance W (m, d, m, d), free values q (m, d) and a guess (m, d).

        Args:
            W: Compliance.
            q: Free values.
            start: Guess.
            bounds: Of friction; where all are zero, tangential unknowns are dropped.
            scaling: `row_sum_scaling(W)`, where it is at hand; not used with friction in 3-D.

        Raises:
            NoContactSolution: Where every method failed.
        """
        if not len(q):
            return np.zeros_like(q)
        if self._dimension == 3 and not bounds.frictionless:
            return self._settled(self._disc, LocalSystem(W, q, diagonal_scaling(W), bounds), start)
        scaling = row_sum_scaling(W) if scaling is None else scaling
        if self._dimension == 2:
            return self._settled(self._plane, LocalSystem(W, q, scaling, bounds), start)
        # Without friction the second tangential direction is as idle as the first.
        smooth = LocalSystem(W[:, :2, :, :2], q[:, :2], scaling[:, :2], bounds)
        return np.pad(self._settled(self._plane, smooth, start[:, :2]), ((0, 0), (0, 1)))

    def _settled(
        self, solver: PlaneSolver | DiscSolver, system: LocalSystem, start: Array
    ) -> Array:
        """The solution by the fast method, or by the first that finds it."""
        found = solver.fast(system, start)
        if found is not None:
            return found
        slower = solver.cohesive if system.bounds.cohesion.any() else solver.rescues
        for name, method in islice(slower.items(), self._patience):
            found = method(system, start)
            if found is not None:
                self.rescues[name] += 1
                return found
        raise NoContactSolution(f"the local contact problem of {len(start)} points did not settle")
