"""What contact points of rigid blocks in space remember, and their laws of friction, compiled."""

from __future__ import annotations

import math

import numpy as np

from solver.law.compiled import compiled
from solver.law.friction import (
    TOUCHING_SLOPE,
    Bounds,
    at_bound,
    coefficient,
    followed,
    law_of,
    slips,
)
from solver.rigid.space.model import SpaceContacts, SpaceModel, SpaceState
from solver.rigid.space.motion import REGULAR
from solver.types import Array


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
def friction_at_start(
    model: SpaceModel, state: SpaceState, contacts: SpaceContacts
) -> tuple[Array, Array]:
    """Coefficients of friction and cohesive forces of the points, by what they did before."""
    m = len(contacts.body)
    mu, cohesion = np.empty(m), np.empty(m)
    for q in range(m):
        k, slot = contacts.pair[q], contacts.slot[q]
        law, memory = law_of(model.law, k), state.memory
        rate = memory.rate[k, slot] if memory.face[k, slot] == contacts.face[q] else 0.0
        mu[q] = coefficient(law, rate, rate > 0)
        lost = law.cohesion_lost and memory.broken[k, slot] == 1
        cohesion[q] = 0.0 if lost else law.cohesion * model.area[k]
    return mu, cohesion


@compiled
def at_limit(force: Array, mu: Array, cohesion: Array, q: int) -> bool:
    """Whether closed point q, of m, is at the limit of its friction."""
    bounds = Bounds(mu, cohesion, TOUCHING_SLOPE)
    return at_bound(bounds, q, force[q, 0], math.hypot(force[q, 1], force[q, 2]))


@compiled
def sliding_of(force: Array, slip: Array, softness: Array, mu: Array, cohesion: Array) -> Array:
    """1 for the points at the limit of their friction that slip, (m,); D of `softness` is W's."""
    found = np.zeros(len(mu))
    for q in range(len(mu)):
        size, way = np.max(np.abs(force[q])), math.hypot(slip[q, 0], slip[q, 1])
        slid = at_limit(force, mu, cohesion, q) and slips(way, softness[q, 1] / REGULAR, size)
        found[q] = 1.0 if slid else 0.0
    return found


@compiled
def follow_law(
    model: SpaceModel, contacts: SpaceContacts, sliding: Array, slip: Array, dt: float, mu: Array
) -> bool:
    """Bring the coefficients to the slip that was found; whether one changed.

    Args:
        model: The bodies.
        contacts: m points.
        sliding: Of `sliding_of`.
        slip: (m, 2) m.
        dt: Step, s.
        mu: Coefficients, changed in place.
    """
    changed = False
    for q in range(len(mu)):
        law, speed = law_of(model.law, contacts.pair[q]), math.hypot(slip[q, 0], slip[q, 1]) / dt
        new = followed(law, mu[q], speed, sliding[q] == 1)
        if abs(new - mu[q]) > 1e-12 * law.static:
            mu[q], changed = new, True
    return changed
