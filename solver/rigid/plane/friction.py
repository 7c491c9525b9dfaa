"""Friction of contact points of rigid blocks in the plane, and how it follows their slip. Compiled.

`solver.law.friction` has the law. Without decay a point that is new or stuck in the last step holds
up to mu_s; one that slipped has mu_d.
"""

from __future__ import annotations

import numpy as np

from solver.law.compiled import compiled
from solver.law.friction import Bounds, eased, followed, held, slips
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
        mu, cohesion = held(system.friction, system.upper[k], memory.past[k])
        work.friction[i] = mu
        work.cohesion[i] = cohesion * area(system, work, state, i) if cohesion > 0.0 else 0.0


@compiled
def follow_friction(
    system: PlaneModel, memory: PlaneMemory, work: PlaneWork, W: Array, dt: float, share: float
) -> bool:
    """Adapt friction to the slip that was found, as far as `eased`; True where anything changed."""
    changed = False
    for i in range(work.counts[0]):
        if work.state[i] == OPEN:
            continue
        k, slip, t = work.points[i], abs(work.place[2 * i + 1]), 2 * i + 1
        force = max(abs(work.force[2 * i]), abs(work.force[t]))
        slid = work.state[i] != STICK and slips(slip, W[t, t], force)
        work.slips[i] = 1 if slid else 0
        speed = slip / dt if slid else 0.0
        friction, coheres = followed(
            system.friction, system.upper[k], memory.past[k], work.friction[i], speed, slid
        )
        friction = eased(system.friction, system.upper[k], work.friction[i], friction, share)
        if abs(friction - work.friction[i]) > 1e-13:
            work.friction[i] = friction
            changed = True
        if not coheres and work.cohesion[i] > 0.0:
            work.cohesion[i] = 0.0
            changed = True
    return changed


@compiled
def bounds_of(work: PlaneWork) -> Bounds:
    """Friction of the near points for the local problem."""
    count = work.counts[0]
    return Bounds(work.friction[:count], work.cohesion[:count], np.inf)
