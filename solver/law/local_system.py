"""The data of a local contact problem, its laws of friction, and what all of its solvers share.

Friction enters the solvers as a line: |f_t| <= slope f_n + intercept. Coulomb's law has one line
per point; Tresca's, which some solvers freeze it to, has no slope. Cohesion makes the law jump, and
a point that its cohesion would lift has then no solution: `touching` lets cohesion grow with the
first 1e-4 of pressure instead, so that such a point keeps as much of it as does not lift it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from solver.law.discs import TOUCHING_SLOPE, Discs
from solver.law.friction import Bounds
from solver.types import Array


class NoContactSolution(Exception):
    """None of the methods settled the local problem; a smaller time step is the remedy."""


def row_sum_scaling(W: Array) -> Array:
    """R per point and direction, (m, d): one over the row sums of |W| within a direction."""
    return 1.0 / np.stack([np.abs(W[:, i, :, i]).sum(axis=1) for i in range(W.shape[1])], axis=1)


def diagonal_scaling(W: Array) -> Array:
    """R per point and direction, (m, d): one over the diagonal, alike in tangential directions."""
    number, d = np.arange(len(W)), W.shape[1]
    diagonal = W[number[:, None], np.arange(d), number[:, None], np.arange(d)]
    diagonal[:, 1:] = diagonal[:, 1:].max(axis=1, keepdims=True)
    return 1.0 / diagonal


def image(W: Array, f: Array) -> Array:
    """W f for points (m, d)."""
    return (W.reshape(f.size, f.size) @ f.ravel()).reshape(f.shape)


@dataclass(frozen=True, slots=True, eq=False)
class LocalSystem:
    """One local problem.

    Attributes:
        W: Compliance, (m, d, m, d).
        q: Free values, (m, d).
        scaling: r, (m, d): weight of y against f where states are decided.
        bounds: Of friction.
    """

    W: Array
    q: Array
    scaling: Array
    bounds: Bounds

    def scaled(self, scaling: Array) -> LocalSystem:
        """The same problem with another r, (m, d)."""
        return LocalSystem(self.W, self.q, scaling, self.bounds)

    def trial(self, f: Array) -> Array:
        """F - r y, which decides what state a point is in."""
        return f - self.scaling * (self.q + image(self.W, f))

    def flat(self, force: Array) -> tuple[Array, Array, Array]:
        """W, q and forces as machine code takes them; the forces are a copy."""
        size = force.size
        W = np.ascontiguousarray(self.W.reshape(size, size))
        return W, np.ascontiguousarray(self.q.reshape(size)), force.flatten()

    @property
    def coulomb(self) -> Discs:
        """The law as it is."""
        return Discs(self.bounds.mu, self.bounds.cohesion, np.inf)

    def touching(self, slope: float = TOUCHING_SLOPE) -> Discs:
        """The law with cohesion that grows from 0 over the first 1e-4 of pressure, 1/slope."""
        return Discs(self.bounds.mu, self.bounds.cohesion, slope)

    @property
    def discs(self) -> Discs:
        """The law for the slower solvers, which has a solution whatever the cohesion."""
        return self.touching() if self.bounds.cohesion.any() else self.coulomb


def frozen(bound: Array) -> Discs:
    """Tresca's law: fixed bounds."""
    return Discs(np.zeros_like(bound), bound, np.inf)


def lines(discs: Discs, normal: Array) -> tuple[Array, Array]:
    """Slopes and intercepts of the bounds at trial normal forces, (m,) each."""
    mu, cohesion, slope = discs
    if slope == np.inf:
        return mu, cohesion
    growing = slope * normal < cohesion
    return np.where(growing, mu + slope, mu), np.where(growing, 0.0, cohesion)


def limits(discs: Discs, normal: Array) -> Array:
    """The bound of |f_t| for normal forces; 0 where open."""
    slope, intercept = lines(discs, normal)
    return np.where(normal > 0, slope * normal + intercept, 0.0)


def project(trial: Array, discs: Discs) -> Array:
    """The admissible force next to a trial one: normal part first, then the disc (interval)."""
    f = np.maximum(trial, 0.0)
    limit = limits(discs, trial[:, 0])
    size = np.sqrt((trial[:, 1:] ** 2).sum(axis=1))
    f[:, 1:] = trial[:, 1:] * np.where(size > limit, limit / np.maximum(size, 1e-300), 1.0)[:, None]
    return f
