"""Contact at velocity level, after each step (the paper's section 3.4).

A contact that stays closed has u_{n+1} = u_n there, so that the velocity update of the time
stepping turns its velocity round every step. The impulses dt f of the closed points are therefore
corrected such that

    0 <= P_n  complementary to  v_n >= 0,   |P_t| <= dt c + mu P_n, v_t = 0 inside the bound,
    P = dt f + q,

with v <- v + M^-1 G^T q. Kinetic energy must not rise. Where the bound shrinks with P_n, giving
back friction could accelerate: then points that slip keep their friction, then all do, and else the
velocities stay as they are.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from solver.law.compiled import compiled
from solver.law.friction import Bounds, at_bound
from solver.law.local_problem import LocalProblem, solve
from solver.types import Array, Indices

#: Relative diagonal added to W: closed points may outnumber the unknowns, W is singular then.
REGULAR = 1e-8
#: Gains of kinetic energy below this part of the power of the impulses are round-off.
ENERGY_ROUND_OFF = 1e-14


class ImpulseCorrection(NamedTuple):
    """Change of the impulses and the energy that it takes (per metre of thickness in 2-D)."""

    found: bool
    """Whether there is one."""
    q: Array
    """Of the closed points in their frames, (d m,) or (m, d), N s."""
    contact: float
    """Energy taken in the normal directions, J."""
    friction: float
    """In the tangential ones, J."""


@compiled
def _slipping(d: int, impulse: Array, bounds: Bounds) -> Indices:
    """1 for the points whose impulse is at its bound, (m,)."""
    found = np.zeros(len(bounds.mu), np.int64)
    for i in range(len(found)):
        tangential = 0.0
        for k in range(d * i + 1, d * i + d):
            tangential = math.hypot(tangential, impulse[k])
        if at_bound(bounds, i, impulse[d * i], tangential):
            found[i] = 1
    return found


@compiled
def friction_share(tangential: float, lost: float) -> float:
    """Friction's share of the kinetic energy that impulses take, J.

    Normal and tangential impulses of a body act on each other: the work in one direction may be
    negative, though their sum is a loss. A loss through friction cannot be negative: where the
    tangential impulses give energy back, the normal ones took it before, and it is contact's.

    Args:
        tangential: Energy taken in the tangential directions, J.
        lost: Energy taken in all, J.
    """
    return min(max(tangential, 0.0), max(lost, 0.0))


@compiled
def correct_impulses(
    d: int,
    W: Array,
    velocity: Array,
    impulse: Array,
    bounds: Bounds,
    counts: Indices,
    first: int,
) -> ImpulseCorrection:
    """Correct the impulses of closed points.

    Args:
        d: Rows of a point.
        W: G M^-1 G^T of the closed points, (d m, d m), 1/kg.
        velocity: Of the points after the step, (d m,), m/s.
        impulse: dt f of the step, (d m,), N s.
        bounds: Of the impulses: mu and dt c.
        counts: Of outcomes of local problems.
        first: Where the ladder begins: 0 at the law for all points, 1 where points that slip keep
            their friction. In space its direction lags by half a step behind a slip that turns.
    """
    m, regular = len(bounds.mu), W.copy()
    for k in range(len(W)):
        regular[k, k] *= 1.0 + REGULAR
    states, slipping = np.empty(m, np.int64), _slipping(d, impulse, bounds)
    for keep in range(first, 3):
        # Points whose friction is kept have none that is unknown.
        kept, mu, cohesion = np.zeros_like(impulse), bounds.mu.copy(), bounds.cohesion.copy()
        for i in range(m):
            if keep + slipping[i] > 1:
                mu[i], cohesion[i] = 0.0, 0.0
                kept[d * i + 1 : d * i + d] = impulse[d * i + 1 : d * i + d]
        total = impulse - kept
        free = velocity - regular @ total
        left = Bounds(mu, cohesion, bounds.slope)
        if not solve(d, regular, free, left, total, states, counts):
            continue
        q = total + kept - impulse
        work = q * (velocity + 0.5 * (W @ q))
        normal, lost = -np.sum(work[::d]), -np.sum(work)
        if lost >= -ENERGY_ROUND_OFF * abs(np.sum(impulse * velocity)):
            friction = friction_share(lost - normal, lost)
            return ImpulseCorrection(True, q, lost - friction, friction)
    counts[-1] += 1
    return ImpulseCorrection(False, np.zeros_like(impulse), 0.0, 0.0)


def impulse_correction(
    local: LocalProblem, velocity: Array, W: Array, impulse: Array, bounds: Bounds
) -> ImpulseCorrection | None:
    """The correction after a step, or None where no point is closed or none was found.

    As `correct_impulses` with arrays (m, d) and W (m, d, m, d); `local` counts the
    outcomes.
    """
    m, d = impulse.shape
    if not m:
        return None
    flat = W.reshape(d * m, d * m), velocity.ravel(), impulse.ravel()
    found = correct_impulses(d, *flat, bounds, local.counts, 0)
    return found._replace(q=found.q.reshape(m, d)) if found.found else None
