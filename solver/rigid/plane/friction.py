"""Friction of contact points of rigid blocks in the plane, and how it follows their slip. Compiled.

tau = c + mu p with mu = mu_d + (mu_s - mu_d) exp(-DC v_rel). Without decay a point that is new or
stuck in the last step holds up to mu_s; one that slipped has mu_d.
"""

from __future__ import annotations

import math

import numpy as np

from solver.law.compiled import compiled
from solver.law.few_points import FORWARD, OPEN, Bounds
from solver.rigid.plane.contact import area
from solver.rigid.plane.model import PlaneMemory, PlaneModel, PlaneState, PlaneWork
from solver.types import Array

#: A point slips when it moves by more than this part of what its forces would move it by.
SLIPPING = 1e-7


@compiled
def friction_at_rate(law: Array, rate: float) -> float:
    """The coefficient mu = mu_d + (mu_s - mu_d) exp(-DC v_rel)."""
    return law[1] + (law[0] - law[1]) * math.exp(-law[2] * rate)


@compiled
def begin_friction(
    system: PlaneModel, state: PlaneState, memory: PlaneMemory, work: PlaneWork
) -> None:
    """Friction of the near points, by what they did in the last step."""
    for i in range(work.counts[0]):
        k = work.points[i]
        law = system.friction[system.upper[k]]
        slipping = memory.closed[k] == 1 and memory.slipping[k] == 1
        if law[2] > 0.0:
            work.friction[i] = friction_at_rate(law, memory.rate[k] if slipping else 0.0)
        else:
            work.friction[i] = law[1] if slipping else law[0]
        lost = law[4] > 0.0 and memory.broken[k] == 1
        cohesive = law[3] > 0.0 and not lost
        work.cohesion[i] = law[3] * area(system, work, state, i) if cohesive else 0.0


@compiled
def follow_friction(system: PlaneModel, work: PlaneWork, W: Array, dt: float) -> bool:
    """Adapt friction to the slip that was found; True where that changed anything.

    Without decay mu only falls, from mu_s to mu_d, within a step: no choice between the two can
    then repeat itself. Slip counts where it exceeds the regularization of W.
    """
    changed = False
    for i in range(work.counts[0]):
        if work.state[i] == OPEN:
            continue
        law = system.friction[system.upper[work.points[i]]]
        slip = abs(work.place[2 * i + 1])
        slips = work.state[i] >= FORWARD and slip > slip_limit(work, W, i)
        work.slips[i] = 1 if slips else 0
        friction = work.friction[i]
        if law[2] > 0.0:
            friction = friction_at_rate(law, slip / dt if slips else 0.0)
        elif slips:
            friction = law[1]
        if abs(friction - work.friction[i]) > 1e-13:
            work.friction[i] = friction
            changed = True
        if slips and law[4] > 0.0 and work.cohesion[i] > 0.0:
            work.cohesion[i] = 0.0
            changed = True
    return changed


@compiled
def slip_limit(work: PlaneWork, W: Array, i: int) -> float:
    """Smallest increment of a point that counts as slip, m."""
    t = 2 * i + 1
    return SLIPPING * W[t, t] * max(abs(work.force[2 * i]), abs(work.force[t]))


@compiled
def bounds_of(work: PlaneWork, held: bool) -> Bounds:
    """Friction of the near points for the local problem; `held`: slipping ones keep their force."""
    count = work.counts[0]
    given = np.zeros(count, np.int64)
    friction, cohesion = work.friction[:count].copy(), work.cohesion[:count].copy()
    for i in range(count):
        if friction[i] == 0.0 and cohesion[i] == 0.0:
            given[i] = 1
        elif held and work.state[i] >= FORWARD:
            given[i] = 1 if work.state[i] == FORWARD else -1
            friction[i], cohesion[i] = 0.0, abs(work.force[2 * i + 1])
    return Bounds(friction, cohesion, given)
