"""Contact at velocity level, after each step (the paper's section 3.4).

A contact that stays closed has u_{n+1} = u_n there, so that the velocity update of the time
stepping turns its velocity round every step. The impulses dt f of the closed points are therefore
corrected such that

    0 <= P_n  complementary to  v_n >= 0,   |P_t| <= mu P_n, v_t = 0 inside the cone,   P = dt f +
    q,

with v <- v + M^-1 G^T q. Kinetic energy can only fall.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from solver.contact.compliance import Compliance
from solver.contact.local_problem import LocalProblem, NoContactSolution, image

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class VelocityCorrection:
    """Change of the velocity (owned unknowns) and the energy it takes (J/m)."""

    change: Array
    contact: float
    friction: float


def regularised(W: Array) -> Array:
    """W with a relative diagonal: Gauss points may outnumber their nodes, W is singular then."""
    number = np.arange(len(W))
    for k in range(2):
        W[number, k, number, k] *= 1 + 1e-8
    return W


class VelocityContact:
    """Solves the contact problem of velocities at the closed points."""

    def __init__(self, compliance: Compliance, frame: Array, local: LocalProblem):
        """Take what stays the same.

        Args:
            compliance: G M^-1 G^T of the body; the mass commutes with rotations, so it is constant
                in space.
            frame: Rows normal and tangential of the plane, (2, 2).
            local: Solver of the local problem.
        """
        self._compliance, self._frame, self._local = compliance, frame, local
        self._closed: NDArray[np.int64] = np.empty(0, dtype=np.int64)
        self._W: Array = np.empty((0, 2, 0, 2))

    def correct(self, velocity: Array, force: Array, dt: float) -> VelocityCorrection | None:
        """The correction after a step, or None where no point is closed or no solution was found.

        Args:
            velocity: Of all contact points in space, (points, 2), m/s.
            force: Point forces f of the step, (points, 2), N/m.
            dt: Step, s.
        """
        closed = np.flatnonzero(force[:, 0] > 0)
        if not len(closed):
            return None
        if not np.array_equal(closed, self._closed):
            self._closed, self._W = (
                closed,
                regularised(self._compliance.in_frame(closed, self._frame)),
            )
        W, local = self._W, self._local
        before = velocity[closed] @ self._frame.T
        impulse = dt * force[closed]
        slipping = np.abs(impulse[:, 1]) >= local.friction * impulse[:, 0] * (1 - 1e-9)
        # Where the cone shrinks with P_n, giving back friction could accelerate: then the normal
        # rows alone.
        for held in (slipping, np.ones(len(closed), dtype=bool)):
            try:
                q = _total_impulse(W, before, impulse, held, local) - impulse
            except NoContactSolution:
                continue
            mean = before + 0.5 * image(W, q)
            normal, tangential = -float(q[:, 0] @ mean[:, 0]), -float(q[:, 1] @ mean[:, 1])
            if normal + tangential >= 0:
                response = self._compliance.of(closed)[1]
                return VelocityCorrection(response @ (q @ self._frame).ravel(), normal, tangential)
        local.rescues["velocity solve left out"] += 1
        return None


def _total_impulse(
    W: Array, before: Array, impulse: Array, held: NDArray[np.bool_], local: LocalProblem
) -> Array:
    """P of all points; those in `held` keep their tangential part and have no tangential row."""
    free = before - image(W, impulse)
    if local.friction:
        kept = np.flatnonzero(held)
        if not len(kept):
            return local.solve(W, free, impulse)
        free = free + W[:, :, kept, 1] @ impulse[kept, 1]
        W = W.copy()
        own = W[kept, 1, kept, 1]
        W[kept, 1], W[:, :, kept, 1] = 0.0, 0.0
        W[kept, 1, kept, 1] = own
        free[kept, 1] = 0.0
        total = local.solve(W, free, impulse * (1.0, 0.0))
        total[kept, 1] = impulse[kept, 1]
        return total
    return local.solve(W, free, impulse)
