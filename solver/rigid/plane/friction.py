"""Friction of contact points of rigid blocks in the plane, and how it follows their slip. Compiled.

`solver.law.friction` has the law. Without decay a point that is new or stuck in the last step holds
up to mu_s; one that slipped has mu_d.
"""

from __future__ import annotations

import numpy as np

from solver.law.compiled import compiled
from solver.law.friction import Bounds, coefficient, followed, law_of, slips
from solver.law.newton import OPEN, STICK
from solver.rigid.plane.contact import area
from solver.rigid.plane.model import PlaneMemory, PlaneModel, PlaneState, PlaneWork
from solver.types import Array


@compiled
def begin_friction(
    system: PlaneModel, state: PlaneState, memory: PlaneMemory, work: PlaneWork
) -> None:
    """Friction of the near points, by what they did in the last step."""
    for i in range(work.counts[0]):
        k = work.points[i]
        law = law_of(system.friction, system.upper[k])
        slipping = memory.closed[k] == 1 and memory.slipping[k] == 1
        work.friction[i] = coefficient(law, memory.rate[k] if slipping else 0.0, slipping)
        lost = law.cohesion_lost and memory.broken[k] == 1
        cohesive = law.cohesion > 0.0 and not lost
        work.cohesion[i] = law.cohesion * area(system, work, state, i) if cohesive else 0.0


@compiled
def follow_friction(system: PlaneModel, work: PlaneWork, W: Array, dt: float) -> bool:
    """Adapt friction to the slip that was found; True where that changed anything."""
    changed = False
    for i in range(work.counts[0]):
        if work.state[i] == OPEN:
            continue
        law = law_of(system.friction, system.upper[work.points[i]])
        slip, t = abs(work.place[2 * i + 1]), 2 * i + 1
        force = max(abs(work.force[2 * i]), abs(work.force[t]))
        slid = work.state[i] != STICK and slips(slip, W[t, t], force)
        work.slips[i] = 1 if slid else 0
        friction = followed(law, work.friction[i], slip / dt, slid)
        if abs(friction - work.friction[i]) > 1e-13:
            work.friction[i] = friction
            changed = True
        if slid and law.cohesion_lost and work.cohesion[i] > 0.0:
            work.cohesion[i] = 0.0
            changed = True
    return changed


@compiled
def bounds_of(work: PlaneWork) -> Bounds:
    """Friction of the near points for the local problem."""
    count = work.counts[0]
    return Bounds(work.friction[:count], work.cohesion[:count], np.inf)
