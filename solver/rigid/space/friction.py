"""What contact points of rigid blocks in space remember, and their laws of friction, compiled."""

from __future__ import annotations

import math

import numpy as np

from solver.law.compiled import compiled
from solver.rigid.space.model import SpaceContacts, SpaceModel, SpaceState
from solver.rigid.space.motion import REGULAR
from solver.types import Array

SLIDES = 1e-5
"""A slip below this part of what the friction moves its point by only settles which corner of a
block holds how much; it ends neither static friction nor cohesion."""


@compiled
def touched(state: SpaceState, contacts: SpaceContacts) -> Array:
    """1 for the points that bore on the same face in the last step, else 0."""
    mask, memory = np.zeros(len(contacts.body)), state.memory
    for q in range(len(mask)):
        k, slot = contacts.pair[q], contacts.slot[q]
        if memory.face[k, slot] == contacts.face[q] and memory.force[k, slot, 0] > 0:
            mask[q] = 1.0
    return mask


@compiled
def recalled(state: SpaceState, contacts: SpaceContacts) -> Array:
    """Forces (m, 3) of the last step, N; 0 where a point was away from its face."""
    force, memory = np.zeros((len(contacts.body), 3)), state.memory
    for q in range(len(force)):
        k, slot = contacts.pair[q], contacts.slot[q]
        if memory.face[k, slot] == contacts.face[q]:
            force[q] = memory.force[k, slot]
    return force


@compiled
def coefficient(law: Array, rate: float) -> float:
    """Coefficient of friction at a rate of slip (m/s); without decay: static at 0, else dynamic."""
    static, dynamic, decay = law[0], law[1], law[2]
    if decay > 0:
        return dynamic + (static - dynamic) * math.exp(-decay * rate)
    return dynamic if rate > 0 else static


@compiled
def friction_at_start(
    model: SpaceModel, state: SpaceState, contacts: SpaceContacts
) -> tuple[Array, Array]:
    """Coefficients of friction and cohesive forces of the points, by what they did before."""
    m = len(contacts.body)
    mu, cohesion = np.empty(m), np.empty(m)
    for q in range(m):
        k, slot = contacts.pair[q], contacts.slot[q]
        law, memory = model.law[k], state.memory
        same = memory.face[k, slot] == contacts.face[q]
        mu[q] = coefficient(law, memory.rate[k, slot] if same else 0.0)
        cohesion[q] = 0.0 if memory.broken[k, slot] == 1 and law[4] == 1 else law[3]
    return mu, cohesion


@compiled
def slips(force: Array, mu: float, cohesion: float) -> bool:
    """Whether a closed point is at the limit of its friction."""
    limit = mu * force[0] + cohesion
    return force[0] > 0 and math.hypot(force[1], force[2]) >= limit * (1 - 1e-9)


@compiled
def slides(force: Array, slip: Array, softness: Array, mu: Array, cohesion: Array) -> Array:
    """1 for the points at the limit of their friction that move, by more than `SLIDES` says."""
    found = np.zeros(len(mu))
    for q in range(len(mu)):
        if slips(force[q], mu[q], cohesion[q]):
            small = softness[q, 1] * math.hypot(force[q, 1], force[q, 2]) / REGULAR * SLIDES
            found[q] = 1.0 if math.hypot(slip[q, 0], slip[q, 1]) > small else 0.0
    return found


@compiled
def follow_law(
    model: SpaceModel, contacts: SpaceContacts, sliding: Array, slip: Array, dt: float, mu: Array
) -> bool:
    """Bring the coefficients to the slip that was found; whether one changed.

    Without decay a point that held static friction and slides falls to the dynamic one, and never
    back within a step: that would chatter.

    Args:
        model: The bodies.
        contacts: m points.
        sliding: Of `slides`.
        slip: (m, 2) m.
        dt: Step, s.
        mu: Coefficients, changed in place.
    """
    changed = False
    for q in range(len(mu)):
        law, new = model.law[contacts.pair[q]], mu[q]
        if law[0] == law[1]:
            continue
        if law[2] > 0:
            new = coefficient(law, sliding[q] * math.hypot(slip[q, 0], slip[q, 1]) / dt)
        elif sliding[q] == 1:
            new = law[1]
        if abs(new - mu[q]) > 1e-12 * law[0]:
            mu[q], changed = new, True
    return changed
