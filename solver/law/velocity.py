"""Contact at velocity level, after each step (the paper's section 3.4).

A contact that stays closed has u_{n+1} = u_n there, so that the velocity update of the time
stepping turns its velocity round every step. The impulses dt f of the closed points are therefore
corrected such that

    0 <= P_n  complementary to  v_n >= 0,   |P_t| <= dt c + mu P_n, v_t = 0 inside the bound,
    P = dt f + q,

with v <- v + M^-1 G^T q. Points that slipped in the step keep the direction of their friction,
against the slip of the step, and stay at their bound, which follows P_n: the velocity at the end of
the step is ahead of its slip by half a step. All others obey the law.

Where a rigid body lands in the step, the slip of the step is that of the flight before, or that of
the old pivot; an impulse is now to stop the body, whatever the length of the step, and its friction
has to oppose the slip that it leaves. There all points obey the law.

The correction may return energy only as far as friction took it in this step. Where it would return
more, points that slip keep their friction, then all do, and else the velocities stay as they are.

`solver/kernels/velocity_level.hpp` has the problems that are tried.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from solver.kernels import meshed
from solver.law.friction import Bounds
from solver.law.local_problem import LocalProblem
from solver.law.many_points import MANY_ROWS
from solver.types import Array, Indices


class ImpulseCorrection(NamedTuple):
    """Change of the impulses and the energy that it takes (per metre of thickness in 2-D)."""

    q: Array
    """Impulses of the closed points in their frames, (m, d), N s."""
    contact: float
    """Energy taken in the normal directions, J."""
    friction: float
    """Energy taken in the tangential directions, J."""


def impulse_correction(
    local: LocalProblem,
    velocity: Array,
    W: Array,
    impulse: Array,
    bounds: Bounds,
    taken: float,
    points: Indices | None = None,
    lands: bool = False,
) -> ImpulseCorrection | None:
    """The correction after a step, or None where no point is closed or none was found.

    Args:
        local: Counts the outcomes.
        velocity: Of the closed points after the step, (m, d), m/s.
        W: G M^-1 G^T of the closed points, (m, d, m, d), 1/kg.
        impulse: dt f of the step, (m, d), N s.
        bounds: Of the impulses: mu and dt c.
        taken: Energy that friction took in the step, J.
        points: Numbers by which many points are known again, (m,).
        lands: True if a rigid body landed in the step.
    """
    if not len(impulse):
        return None
    q, closed = np.empty_like(impulse), (W, velocity, impulse, *bounds)
    if impulse.size > MANY_ROWS:
        result = _correct_many(local, closed, taken, points, lands, q)
    else:
        result = meshed.correct_impulses(*closed, taken, lands, local.counts, q)
    found, contact, friction = result
    return ImpulseCorrection(q, contact, friction) if found else None


def _correct_many(
    local: LocalProblem,
    closed: tuple[Array, Array, Array, Array, Array, float],
    taken: float,
    points: Indices | None,
    lands: bool,
    q: Array,
) -> tuple[bool, float, float]:
    """As `meshed.correct_impulses`, for many points, known by their numbers; fills in q."""
    W, _, impulse, _, _, slope = closed
    mobility, free = np.empty_like(W), np.empty_like(impulse)
    left = Bounds(np.empty(len(impulse)), np.empty(len(impulse)), slope)
    for number in range(0 if lands else 1, 4):
        meshed.impulse_problem(number, *closed, mobility, free, left.mu, left.cohesion, q)
        if local.impulses(mobility, free, left, q, points):
            result = meshed.accept_impulses(number, *closed, taken, q)
            if result[0]:
                return result
    local.counts[-1] += 1
    return False, 0.0, 0.0
