"""What contact points of rigid blocks in space remember, and their laws of friction, compiled."""

from __future__ import annotations

import math

import numpy as np

from solver.law.compiled import compiled
from solver.law.friction import (
    TOUCHING_SLOPE,
    Bounds,
    eased,
    followed,
    held,
    points_at_bound,
    points_that_slip,
    remember_open,
)
from solver.rigid.space.boxes import areas
from solver.rigid.space.model import BEARING, SpaceContacts, SpaceModel, SpaceState
from solver.rigid.space.motion import REGULAR
from solver.types import Array, Mask


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
    """Forces (m, 3) of the last step, N; 0 where a point was away from its face or just lands."""
    force, memory = np.zeros((len(contacts.body), 3)), state.memory
    for q in range(len(force)):
        k, slot = contacts.pair[q], contacts.slot[q]
        if memory.face[k, slot] == contacts.face[q] and memory.force[k, slot, 0] > BEARING:
            force[q] = memory.force[k, slot]
    return force


@compiled
def past_of(model: SpaceModel, state: SpaceState, contacts: SpaceContacts, q: int) -> Array:
    """What point q remembers of its friction; of one that is near another face, that it is open."""
    k, slot = contacts.pair[q], contacts.slot[q]
    past = state.memory.past[k, slot].copy()
    if state.memory.face[k, slot] != contacts.face[q]:
        remember_open(model.law, k, past, 0.0)
    return past


@compiled
def friction_at_start(
    model: SpaceModel, state: SpaceState, frames: Array, contacts: SpaceContacts
) -> tuple[Array, Array]:
    """Coefficients of friction and cohesive forces of the points, by what they did before."""
    mu, cohesion = np.empty(len(contacts.body)), areas(model, state, frames, contacts)
    for q in range(len(mu)):
        own, shear = held(model.law, contacts.pair[q], past_of(model, state, contacts, q))
        mu[q] = own
        cohesion[q] *= shear
    return mu, cohesion


@compiled
def at_limit(force: Array, mu: Array, cohesion: Array) -> Mask:
    """The closed points, of m, at the limit of their friction."""
    return points_at_bound(force, Bounds(mu, cohesion, TOUCHING_SLOPE))


@compiled
def sliding_of(force: Array, slip: Array, softness: Array, mu: Array, cohesion: Array) -> Mask:
    """The points that slip, (m,); D of `softness` is W's."""
    way, own = np.empty(len(mu)), np.empty(len(mu))
    for q in range(len(mu)):
        own[q] = softness[q, 1] / REGULAR
        way[q] = math.hypot(slip[q, 0], slip[q, 1])
    return points_that_slip(force, way, own, Bounds(mu, cohesion, np.inf))


@compiled
def follow_law(
    model: SpaceModel,
    state: SpaceState,
    contacts: SpaceContacts,
    sliding: Mask,
    slip: Array,
    dt: float,
    law: tuple[Array, Array],
    share: float,
) -> bool:
    """Bring friction to the slip (m, 2) that was found, m, as far as `eased`; whether it changed.

    The points that slide are those of `sliding_of`; `law` has coefficients and cohesive forces,
    which are changed in place.
    """
    (mu, cohesion), changed = law, False
    for q in range(len(mu)):
        k, past = contacts.pair[q], past_of(model, state, contacts, q)
        speed = math.hypot(slip[q, 0], slip[q, 1]) / dt if sliding[q] else 0.0
        new, coheres = followed(model.law, k, past, mu[q], speed, sliding[q])
        new = eased(model.law, k, mu[q], new, share)
        if abs(new - mu[q]) > 1e-12 * model.law.static[k]:
            mu[q], changed = new, True
        if not coheres and cohesion[q] > 0.0:
            cohesion[q], changed = 0.0, True
    return changed
