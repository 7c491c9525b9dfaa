"""The condensed contact problem: Signorini and Coulomb at points coupled by a small dense matrix.

Unknown are the point forces f = (normal, tangential) of m points with

    y = q + W f,   0 <= f_n  complementary to  y_n >= 0,   |f_t| <= mu f_n,  y_t opposite to f_t.

A semismooth Newton method decides the states by f - r y, with r one over the ROW SUM of |W|: the
points of a stiff body share its rigid modes, so that W is nearly of rank one and 1/diag(W) too
large by about the number of points. Where it cycles a chain of slower methods follows; `rescues`
counts what each one settled.
"""

from __future__ import annotations

from collections import Counter
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dgesv

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

ENUMERATED_POINTS = 5


class NoContactSolution(Exception):
    """None of the methods settled the local problem; a smaller time step is the remedy."""


def row_sum_scaling(W: Array) -> Array:
    """R per point and direction, (m, 2): one over the row sums of |W| within a direction."""
    return 1.0 / np.stack([np.abs(W[:, i, :, i]).sum(axis=1) for i in range(2)], axis=1)


def image(W: Array, f: Array) -> Array:
    """W f for points (m, 2)."""
    return (W.reshape(f.size, f.size) @ f.ravel()).reshape(f.shape)


class States:
    """Closed or open, sticking or slipping (and which way), for each point."""

    __slots__ = ("closed", "direction", "stick")

    def __init__(self, closed: Mask, stick: Mask, direction: Array):
        """Keep the masks; `direction`: sign of the friction force of slipping points, else 0."""
        self.closed, self.stick, self.direction = closed, stick, direction

    def key(self) -> bytes:
        """Equal for equal states."""
        return self.closed.tobytes() + self.stick.tobytes() + self.direction.tobytes()


class LocalProblem:
    """Solver of the local problem for a friction coefficient; remembers the last states."""

    def __init__(self, friction: float, patience: int = 4):
        """Set up.

        Args:
            friction: Coulomb's mu; 0 drops the tangential unknowns.
            patience: How many of the methods behind Newton's may be tried.
        """
        self.friction, self._patience = friction, patience
        self.rescues: Counter[str] = Counter()
        self._last: States | None = None

    def solve(self, W: Array, q: Array, start: Array, scaling: Array | None = None) -> Array:
        """Forces (m, 2) for compliance W (m, 2, m, 2), free values q (m, 2) and a guess (m, 2).

        Args:
            W: Compliance.
            q: Free values.
            start: Guess.
            scaling: `row_sum_scaling(W)`, where it is at hand.

        Raises:
            NoContactSolution: Where every method failed.
        """
        scaling = row_sum_scaling(W) if scaling is None else scaling
        found = self._newton(W, q, start, scaling, self._remembered(len(q)))
        if found is None:
            for rescue in (self._tresca, self._projected, self._gauss_seidel, self._enumeration)[
                : self._patience
            ]:
                found = rescue(W, q, start, scaling)
                if found is not None:
                    self.rescues[rescue.__name__.strip("_")] += 1
                    break
            else:
                raise NoContactSolution(
                    f"the local contact problem of {len(q)} points did not settle"
                )
        return found

    def _remembered(self, count: int) -> States | None:
        """The last states, if they belong to as many points."""
        last = self._last
        return last if last is not None and len(last.closed) == count else None

    def _decide(self, f: Array, y: Array, scaling: Array, bound: Array | None) -> States:
        """States by the sign and size of f - r y; `bound` replaces mu f_n in Tresca problems."""
        trial = f - scaling * y
        closed = trial[:, 0] > 0
        if not self.friction:
            return States(closed, np.zeros_like(closed), np.zeros(len(f)))
        limit = self.friction * trial[:, 0] if bound is None else bound
        stick = closed & (np.abs(trial[:, 1]) <= limit)
        return States(closed, stick, np.where(closed & ~stick, np.sign(trial[:, 1]), 0.0))

    def _forces(self, W: Array, q: Array, states: States, bound: Array | None) -> Array | None:
        """Forces of given states: y_n = 0 where closed, y_t = 0 where stuck; None if singular."""
        f = np.zeros_like(q)
        closed, stick = np.flatnonzero(states.closed), np.flatnonzero(states.stick)
        if not len(closed):
            return f
        # Flat numbers: normal 2 i, tangential 2 i + 1.
        unknown = np.concatenate([2 * closed, 2 * stick + 1])
        flat, free, forces = W.reshape(q.size, q.size), q.ravel(), f.ravel()
        matrix, right = flat[unknown[:, None], unknown], -free[unknown]
        slipping = np.flatnonzero(states.direction[closed])
        if len(slipping):
            tangential = 2 * closed[slipping] + 1
            direction = states.direction[closed[slipping]]
            coupling = flat[unknown[:, None], tangential]
            if bound is None:
                matrix[:, slipping] += self.friction * direction * coupling
            else:
                right -= coupling @ (direction * bound[closed[slipping]])
        _, _, x, info = dgesv(matrix, right, 1, 1)
        if info:
            return None
        forces[unknown] = x
        if len(slipping):
            size = self.friction * x[slipping] if bound is None else bound[closed[slipping]]
            forces[tangential] = direction * size
        return f

    def _newton(
        self,
        W: Array,
        q: Array,
        f: Array,
        scaling: Array,
        states: States | None = None,
        bound: Array | None = None,
    ) -> Array | None:
        """Active-set iteration until the states repeat themselves; None where they cycle."""
        seen = set()
        if states is None:
            states = self._decide(f, q + image(W, f), scaling, bound)
        while True:
            key = states.key()
            if key in seen:
                return None
            seen.add(key)
            found = self._forces(W, q, states, bound)
            if found is None:
                return None
            following = self._decide(found, q + image(W, found), scaling, bound)
            if following.key() == key:
                if bound is None:
                    self._last = following
                return found
            states = following

    def _tresca(self, W: Array, q: Array, start: Array, scaling: Array) -> Array | None:
        """Fixed point over problems with frozen friction bounds, each polished by Newton."""
        if not self.friction:
            return None  # nothing to freeze: the same problem again
        f, bound = start, self.friction * np.maximum(start[:, 0], 0.0)
        for k in range(200):
            frozen = self._newton(W, q, f, scaling, None, bound)
            if frozen is None:
                bound = 0.5 * bound
                continue
            f, target = frozen, self.friction * np.maximum(frozen[:, 0], 0.0)
            found = self._newton(W, q, f, scaling)
            if found is not None:
                return found
            bound = target if k < 20 else 0.5 * (bound + target)
        return None

    def _projected(self, W: Array, q: Array, start: Array, scaling: Array) -> Array | None:
        """Projected iteration with one step length, Newton every ten rounds."""
        f = start.copy()
        flat = W.reshape(q.size, q.size)
        length = 1.0 / np.linalg.norm(flat, 2)
        for k in range(1000):
            trial = f - length * (q + image(W, f))
            f[:, 0] = np.maximum(trial[:, 0], 0.0)
            limit = self.friction * f[:, 0]
            f[:, 1] = np.clip(trial[:, 1], -limit, limit)
            if k % 10 == 9:
                found = self._newton(W, q, f, scaling)
                if found is not None:
                    return found
        return None

    def _gauss_seidel(self, W: Array, q: Array, start: Array, scaling: Array) -> Array | None:
        """Nonsmooth Gauss-Seidel, each point solved exactly.

        It ends when it stands still or Newton can polish it.
        """
        f = start.copy()
        for sweep in range(1, 2001):
            before = f.copy()
            for i in range(len(q)):
                own = W[i, :, i, :]
                free = q[i] + np.tensordot(W[i], f, 2) - own @ f[i]
                f[i] = self._one_point(own, free)
            if np.abs(f - before).max() <= 1e-13 * np.abs(f).max():
                return f
            if sweep % 20 == 0:
                found = self._newton(W, q, f, scaling)
                if found is not None:
                    return found
        return None

    def _enumeration(self, W: Array, q: Array, start: Array, scaling: Array) -> Array | None:
        """Try every state of every point, for as few points as that is bearable."""
        if len(q) > ENUMERATED_POINTS:
            return None
        for choice in product(range(4), repeat=len(q)):
            state = np.array(choice)
            states = States(state > 0, state == 1, np.select([state == 2, state == 3], [1.0, -1.0]))
            found = self._forces(W, q, states, None)
            if found is None:
                continue
            if self._decide(found, q + image(W, found), scaling, None).key() == states.key():
                return found
        return None

    def _one_point(self, W: Array, q: Array) -> Array:
        """The force at a single point: open, sticking, or slipping either way."""
        if q[0] >= 0:
            return np.zeros(2)
        mu = self.friction
        if mu:
            force: Array = np.asarray(-np.linalg.solve(W, q), dtype=np.float64)
            if force[0] > 0 and abs(force[1]) <= mu * force[0]:
                return force
        for sign in (1.0, -1.0):
            normal = -q[0] / (W[0, 0] + sign * mu * W[0, 1])
            slip = q[1] + (W[1, 0] + sign * mu * W[1, 1]) * normal
            if normal > 0 and sign * slip <= 0:
                return np.array([normal, sign * mu * normal])
        return np.array([-q[0] / W[0, 0], 0.0])
