"""Contact at velocity level, after each step (the paper's section 3.4).

A contact that stays closed has u_{n+1} = u_n there, so that the velocity update of the time
stepping turns its velocity round every step. The impulses dt f of the closed points are therefore
corrected such that

    0 <= P_n  complementary to  v_n >= 0,   |P_t| <= dt c + mu P_n, v_t = 0 inside the bound,
    P = dt f + q,

with v <- v + M^-1 G^T q. Kinetic energy can only fall.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from solver.law.friction import Bounds
from solver.law.local_problem import (
    LocalProblem,
    NoContactSolution,
    image,
    row_sum_scaling,
)
from solver.types import Array, Indices, Mask


@dataclass(frozen=True, slots=True)
class ImpulseCorrection:
    """Change of the impulses and the energy that it takes (per metre of thickness in 2-D).

    Attributes:
        q: Of the closed points in their frames, (m, d), N s.
        contact: Energy taken in the normal directions, J.
        friction: In the tangential ones, J.
    """

    q: Array
    contact: float
    friction: float


class VelocityContact:
    """Solves the contact problem of velocities at the closed points."""

    def __init__(self, local: LocalProblem):
        """Take the solver of local problems, which also counts the solves left out."""
        self._local = local
        self._last: tuple[Array, Array, Array] | None = None

    def correct(
        self, velocity: Array, W: Array, impulse: Array, bounds: Bounds
    ) -> ImpulseCorrection | None:
        """The correction after a step, or None where no point is closed or none was found.

        Args:
            velocity: Of the closed points in their frames, (m, d), m/s.
            W: G M^-1 G^T of these points, (m, d, m, d), 1/kg.
            impulse: dt f of the step, (m, d), N s.
            bounds: Of the impulses: mu and dt c.
        """
        if not len(velocity):
            return None
        regular, scaling = self._regular(W)
        size = np.sqrt((impulse[:, 1:] ** 2).sum(axis=1))
        slipping = size >= (bounds.mu * impulse[:, 0] + bounds.cohesion) * (1 - 1e-9)
        # Where the bound shrinks with P_n, giving back friction could accelerate: then points that
        # slip keep their friction, then all do.
        for hold in (np.zeros_like, np.asarray, np.ones_like):
            held = hold(slipping)
            try:
                q = self._total(regular, scaling, velocity, impulse, held, bounds) - impulse
            except NoContactSolution:
                continue
            mean = velocity + 0.5 * image(W, q)
            contact, friction = -float(q[:, 0] @ mean[:, 0]), -float(np.vdot(q[:, 1:], mean[:, 1:]))
            if contact + friction >= 0:
                return ImpulseCorrection(q, contact, friction)
        self._local.rescues["velocity solve left out"] += 1
        return None

    def _regular(self, W: Array) -> tuple[Array, Array]:
        """W made regular, and its scaling; those of the last call where W is the same array."""
        if self._last is None or W is not self._last[0]:
            regular = _regularised(W)
            self._last = W, regular, row_sum_scaling(regular)
        return self._last[1:]

    def _total(
        self,
        W: Array,
        scaling: Array | None,
        velocity: Array,
        impulse: Array,
        held: Mask,
        bounds: Bounds,
    ) -> Array:
        """P of all points; those in `held` keep their tangential part and have no such rows."""
        kept = np.zeros_like(impulse)
        kept[held, 1:] = impulse[held, 1:]
        free = velocity - image(W, impulse - kept)
        start = impulse - kept
        if held.all():
            bounds = Bounds.uniform(0.0, len(held))
        elif held.any():
            W, scaling = _without_tangential_rows(W, np.flatnonzero(held)), None
            free[held, 1:] = 0.0
        return self._local.solve(W, free, start, bounds, scaling) + kept


def _regularised(W: Array) -> Array:
    """W with a relative diagonal: Gauss points may outnumber their nodes, W is singular then."""
    size = W.shape[0] * W.shape[1]
    W = W.copy()
    W.reshape(size, size)[np.arange(size), np.arange(size)] *= 1 + 1e-8
    return W


def _without_tangential_rows(W: Array, points: Indices) -> Array:
    """W where the tangential directions of points are coupled to nothing but themselves."""
    W = W.copy()
    for i in range(1, W.shape[1]):
        own = W[points, i, points, i]
        W[points, i], W[:, :, points, i] = 0.0, 0.0
        W[points, i, points, i] = own
    return W
