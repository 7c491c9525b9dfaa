"""Jumps of the velocities of rigid blocks in the plane: after a step, and at an impact. Compiled.

A contact that stays closed has no increment, so that the velocity update of the time stepping turns
its velocity round in every step; see `solver.law.velocity`. Where blocks with a restitution land,
`solver.law.impact` is the law.
"""

from __future__ import annotations

import numpy as np

from solver.law.compiled import compiled
from solver.law.friction import Bounds
from solver.law.impact import Rebounds, impact, rebounds
from solver.law.newton import OPEN
from solver.law.velocity import correct_impulses
from solver.rigid.plane.contact import (
    TOUCHING,
    begin_friction,
    change,
    clear_points,
    compliance,
    find_points,
    push,
    write_rows,
)
from solver.rigid.plane.model import PlaneMemory, PlaneModel, PlaneState, PlaneWork
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


@compiled
def collide(system: PlaneModel, state: PlaneState, memory: PlaneMemory, work: PlaneWork) -> None:
    """Give the velocities a jump where corners that touch approach their faces, and book it."""
    find_points(system, state, memory, work, 0.0, 0.0)
    count = clear_points(system, work)
    work.counts[0] = count
    begin_friction(system, state, memory, work)
    work.increment[:] = 0.0
    write_rows(system, state.q, work.increment, work)
    velocity = np.empty(2 * count)
    for row in range(2 * count):
        velocity[row] = change(system, work, row, state.v)
    asked = _rebounds(system, state, work, velocity[::2].copy())
    if not np.any(asked.speed > 0.0):
        return
    W = compliance(system, work, system.flexibility)
    found = impact(2, W, velocity, asked, work.friction[:count], work.counts[2:])
    push(system, work, found.impulse, system.flexibility, state.v)
    state.exchanged[1] += found.friction
    state.exchanged[3] += found.contact
    add_impulses(system, work, 1.0, found.impulse)


@compiled
def _rebounds(system: PlaneModel, state: PlaneState, work: PlaneWork, velocity: Array) -> Rebounds:
    """What the touching points ask for; their places are the arms of their normals.

    The arms are those about the centre of the upper block; v_n of two bodies grows along them by
    their relative spin. `work` has the touching points and their rows at rest, `velocity` those
    before the impact, flat, m/s.
    """
    count = work.counts[0]
    restitution, pair = np.zeros(count), np.zeros(count, dtype=np.int64)
    place, slope = np.zeros((count, 1)), np.zeros((count, 1))
    for i in range(count):
        k = work.points[i]
        upper = system.upper[k]
        other = system.corner_of[k] + system.face_of[k] - upper
        pair[i] = upper * (len(system.half) + 1) + other + 1
        restitution[i] = system.restitution[upper]
        place[i, 0] = work.rows[2 * i, 3 * upper + 2]
        slope[i, 0] = state.v[3 * upper + 2] - (state.v[3 * other + 2] if other >= 0 else 0.0)
    return rebounds(restitution, pair, place, slope, velocity)
