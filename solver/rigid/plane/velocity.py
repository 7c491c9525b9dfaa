"""Contact at velocity level after a step of rigid blocks in the plane. Compiled.

A contact that stays closed has no increment, so that the velocity update of the time stepping turns
its velocity round in every step; see `solver.law.velocity`.
"""

from __future__ import annotations

from solver.law.compiled import compiled
from solver.law.few_points import OPEN, solve
from solver.rigid.loss import shares_of_loss
from solver.rigid.plane.contact import compliance, write_rows
from solver.rigid.plane.friction import bounds_of
from solver.rigid.plane.model import PlaneModel, PlaneState, PlaneWork
from solver.types import Array

#: Gains of kinetic energy below this part of the power of the impulses are round-off.
ROUND_OFF = 1e-14


@compiled
def correct_velocity(system: PlaneModel, state: PlaneState, work: PlaneWork, dt: float) -> None:
    """Solve contact at velocity level and book what it takes.

    The impulses P = dt f of the closed points become such that 0 <= P_n is complementary to
    v_n >= 0 and P_t lies in the cone; kinetic energy can only fall. Where giving back friction
    would accelerate, points that slip keep their friction, and else the velocity stays.
    """
    keep_closed(work)
    count = work.counts[0]
    if count == 0:
        return
    work.increment[:] = 0.0
    write_rows(system, state.q, work.increment, work)
    rows, states = work.rows[: 2 * count], work.state[:count]
    W = compliance(rows, system.flexibility)
    velocity, impulse = rows @ state.v, dt * work.force[: 2 * count]
    free = velocity - W @ impulse
    for held in (False, True):
        bounds = bounds_of(work, held)
        bounds.cohesion[:] *= dt
        total, trial = impulse.copy(), states.copy()
        if not solve(W, free, bounds, trial, total, work.counts[2:]):
            continue
        q = total - impulse
        change = (q @ rows) * system.flexibility
        mean = velocity + 0.5 * (rows @ change)
        normal = tangential = 0.0
        for i in range(count):
            normal -= q[2 * i] * mean[2 * i]
            tangential -= q[2 * i + 1] * mean[2 * i + 1]
        if normal + tangential >= -ROUND_OFF * abs(impulse @ velocity):
            state.v[:] += change
            contact, friction = shares_of_loss(normal, tangential)
            state.exchanged[3] += contact
            state.exchanged[1] += friction
            add_impulses(system, work, q)
            return


@compiled
def keep_closed(work: PlaneWork) -> None:
    """Drop the open points from the list."""
    kept = 0
    for i in range(work.counts[0]):
        if work.state[i] == OPEN:
            continue
        work.points[kept], work.face[kept], work.state[kept] = (
            work.points[i],
            work.face[i],
            work.state[i],
        )
        work.friction[kept], work.cohesion[kept] = work.friction[i], work.cohesion[i]
        work.force[2 * kept], work.force[2 * kept + 1] = work.force[2 * i], work.force[2 * i + 1]
        kept += 1
    work.counts[0] = kept


@compiled
def add_impulses(system: PlaneModel, work: PlaneWork, impulse: Array) -> None:
    """Add the impulses of the points, in space, to those that the blocks got from below."""
    for i in range(work.counts[0]):
        k = work.points[i]
        upper = system.upper[k]
        row_n, row_t = work.rows[2 * i], work.rows[2 * i + 1]
        for d in range(2):
            work.impulse[upper, d] += (
                impulse[2 * i] * row_n[3 * upper + d] + impulse[2 * i + 1] * row_t[3 * upper + d]
            )
