"""Contact at velocity level after a step of rigid blocks in the plane. Compiled.

A contact that stays closed has no increment, so that the velocity update of the time stepping turns
its velocity round in every step; see `solver.law.velocity`.
"""

from __future__ import annotations

import numpy as np

from solver.law.compiled import compiled
from solver.law.friction import Bounds
from solver.law.newton import OPEN
from solver.law.velocity import correct_impulses
from solver.rigid.plane.contact import TOUCHING, write_rows
from solver.rigid.plane.coupling import change, compliance, push
from solver.rigid.plane.model import PlaneModel, PlaneState, PlaneWork
from solver.types import Array


@compiled
def correct_velocity(
    system: PlaneModel, state: PlaneState, work: PlaneWork, dt: float, taken: float
) -> None:
    """Solve contact at velocity level and book what it takes; friction took `taken` (J) before."""
    lands = hits(system, work)
    keep_closed(work)
    count = work.counts[0]
    if count == 0:
        return
    work.increment[:] = 0.0
    write_rows(system, state.q, work.increment, work)
    W, velocity = compliance(system, work, system.flexibility), work.moved[: 2 * count]
    for row in range(2 * count):
        velocity[row] = change(system, work, row, state.v)
    bounds = Bounds(work.friction[:count], dt * work.cohesion[:count], np.inf)
    impulse = dt * work.force[: 2 * count]
    found = correct_impulses(2, W, velocity, impulse, bounds, taken, work.counts[2:], lands)
    if found.found:
        push(system, work, found.q, system.flexibility, state.v)
        state.exchanged[3] += found.contact
        state.exchanged[1] += found.friction
        add_impulses(system, work, 1.0, found.q)


@compiled
def hits(system: PlaneModel, work: PlaneWork) -> bool:
    """Whether a point that was clear at the start of the solved step carries a force."""
    for i in range(work.counts[0]):
        if work.state[i] != OPEN and work.gap[i] > TOUCHING * system.size:
            return True
    return False


@compiled
def keep_closed(work: PlaneWork) -> None:
    """Drop the open points from the list."""
    kept = 0
    for i in range(work.counts[0]):
        if work.state[i] == OPEN:
            continue
        work.points[kept], work.face[kept] = work.points[i], work.face[i]
        work.state[kept] = work.state[i]
        work.friction[kept], work.cohesion[kept] = work.friction[i], work.cohesion[i]
        work.force[2 * kept], work.force[2 * kept + 1] = work.force[2 * i], work.force[2 * i + 1]
        kept += 1
    work.counts[0] = kept


@compiled
def add_impulses(system: PlaneModel, work: PlaneWork, dt: float, force: Array) -> None:
    """Add the impulses dt f of the points, in space, to those that the blocks got from below."""
    for i in range(work.counts[0]):
        k = work.points[i]
        upper = system.upper[k]
        for d in range(2):
            column = 3 * upper + d
            work.impulse[upper, d] += dt * (
                force[2 * i] * work.rows[2 * i, column]
                + force[2 * i + 1] * work.rows[2 * i + 1, column]
            )
