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
from solver.rigid.plane.contact import write_rows
from solver.rigid.plane.model import PlaneModel, PlaneState, PlaneWork
from solver.types import Array


@compiled
def correct_velocity(
    system: PlaneModel, state: PlaneState, work: PlaneWork, dt: float, taken: float
) -> None:
    """Solve contact at velocity level and book what it takes; friction took `taken` (J) before."""
    keep_closed(work)
    count = work.counts[0]
    if count == 0:
        return
    work.increment[:] = 0.0
    write_rows(system, state.q, work.increment, work)
    rows = work.rows[: 2 * count]
    W = (rows * system.flexibility) @ rows.T
    bounds = Bounds(work.friction[:count], dt * work.cohesion[:count], np.inf)
    impulse = dt * work.force[: 2 * count]
    found = correct_impulses(2, W, rows @ state.v, impulse, bounds, taken, work.counts[2:])
    if found.found:
        state.v[:] += (found.q @ rows) * system.flexibility
        state.exchanged[3] += found.contact
        state.exchanged[1] += found.friction
        add_impulses(system, work, found.q)


@compiled
def keep_closed(work: PlaneWork) -> None:
    """Drop the open points from the list."""
    kept = 0
    for i in range(work.counts[0]):
        if work.state[i] == OPEN:
            continue
        for field in (work.points, work.face, work.state):
            field[kept] = field[i]
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
