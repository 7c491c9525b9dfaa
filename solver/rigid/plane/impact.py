"""Impacts of rigid blocks in the plane that have a restitution; `solver.law.impact` is the law."""

from __future__ import annotations

import numpy as np

from solver.law.compiled import compiled
from solver.law.impact import Rebounds, impact, rebounds
from solver.rigid.plane.contact import clear_points, find_points, write_rows
from solver.rigid.plane.coupling import change, compliance, push
from solver.rigid.plane.friction import begin_friction
from solver.rigid.plane.model import PlaneMemory, PlaneModel, PlaneState, PlaneWork
from solver.rigid.plane.velocity import add_impulses
from solver.types import Array


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
