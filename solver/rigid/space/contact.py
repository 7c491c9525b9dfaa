"""The contact points of a step of rigid blocks in space, and their rows, compiled."""

from __future__ import annotations

import math

import numpy as np

from solver.law.compiled import compiled
from solver.rigid.space.boxes import (
    TOP,
    corners_of,
    face_axes,
    moved_along,
    no_crossings,
    normal_between,
    points_between,
    points_on_face,
)
from solver.rigid.space.model import (
    CORNERS,
    SLOTS,
    SpaceContacts,
    SpaceMemory,
    SpaceModel,
    SpaceState,
)
from solver.rigid.space.rotation import cross, rotation_of, to_space
from solver.types import Array

TOUCH_TOLERANCE = 1e-9
"""Points nearer than this, relative to the largest half length, do not land: they are there."""


@compiled
def rotations(quaternion: Array) -> Array:
    """The rotation matrices of all bodies."""
    found = np.empty((len(quaternion), 3, 3))
    for b in range(len(quaternion)):
        found[b] = rotation_of(quaternion[b])
    return found


@compiled
def _approach(model: SpaceModel, state: SpaceState, pair: int, dt: float, pull: float) -> float:
    """How far the bodies of a pair may come towards each other in a step, generously, m."""
    reach = 2 * dt * dt * pull
    for b in (model.upper[pair], model.lower[pair]):
        half, spin, speed = model.half[b], state.spin[b], state.velocity[b]
        length = math.sqrt(np.sum(half * half))
        reach += 4 * dt * (math.sqrt(np.sum(speed * speed)))
        reach += 4 * dt * (math.sqrt(np.sum(spin * spin)) * length) + 1e-6 * length
    return reach


@compiled
def _rest(memory: SpaceMemory, k: int, slot: int, face: int, gap: float) -> float:
    """Gap at which a point is held: the one that it bears at, or that it was found sunk in at.

    A point that bore in the last step has closed its gap then. What is left of it is round-off of
    places: points that hold each other would make forces of it, the larger the shorter the step. To
    push out what has sunk in would gain energy. A crossing of edges is another place in each step.
    `face` is the one that the point may touch now, with that gap, m.
    """
    if slot >= CORNERS or memory.face[k, slot] != face:
        return min(gap, 0.0)
    if memory.force[k, slot, 0] > 0:
        return gap
    return min(max(memory.rest[k, slot], gap), 0.0)


@compiled
def contacts_of(
    model: SpaceModel, state: SpaceState, frames: Array, dt: float, ground: Array
) -> SpaceContacts:
    """All points that may touch in a step, from a state at its start with these rotations."""
    n, most, m = len(model.half) - 1, SLOTS * len(model.upper), 0
    pull = math.sqrt(np.sum((model.gravity - ground) ** 2))
    whole = np.empty((most, 5), dtype=np.int64)
    arm, axes, gap = np.empty((most, 3)), np.empty((most, 3, 3)), np.empty(most)
    rest, edges = np.empty(most), no_crossings(most)
    for k in range(len(model.upper)):
        u, c, reach = model.upper[k], model.lower[k], _approach(model, state, k, dt, pull)
        below, above = TOP, 0
        if c == n:
            size = math.sqrt(np.sum(model.half[u] ** 2))
            if state.place[u, 2] - size > reach:
                continue
            places = corners_of(model.half[u])
            found = points_on_face(state, frames, model.half, u, c, TOP, places)
            crossings = no_crossings(0)
        else:
            below, above, places, found, crossings = points_between(model, state, frames, k, reach)
        for slot in range(len(places)):
            if found[slot, 0] > reach:
                continue
            lower = 8 <= slot < 16
            body, base, face = (c, u, above) if lower else (u, c, below)
            whole[m, 0], whole[m, 1], whole[m, 2], whole[m, 3] = k, slot, body, base
            whole[m, 4] = face
            arm[m], axes[m] = places[slot], face_axes(face)
            end = slot - CORNERS
            if end >= 0 and np.any(crossings.way[end] != 0):
                axes[m], edges.way[m] = crossings.axes[end], crossings.way[end]
                edges.foot[m], edges.border[m] = crossings.foot[end], crossings.border[end]
            rest[m] = _rest(state.memory, k, slot, face, found[slot, 0])
            gap[m] = found[slot, 0] - rest[m]
            m += 1
    pair, slots, bodies = whole[:m, 0].copy(), whole[:m, 1].copy(), whole[:m, 2].copy()
    bases, faces = whole[:m, 3].copy(), whole[:m, 4].copy()
    sides = edges.way[:m], edges.foot[:m], edges.border[:m]
    return SpaceContacts(
        pair, slots, bodies, bases, faces, arm[:m], axes[:m], gap[:m], rest[:m], *sides
    )


@compiled
def chosen(contacts: SpaceContacts, mask: Array) -> SpaceContacts:
    """Contacts of the points where the mask is above 0."""
    kept = np.flatnonzero(mask > 0)
    return SpaceContacts(
        contacts.pair[kept],
        contacts.slot[kept],
        contacts.body[kept],
        contacts.base[kept],
        contacts.face[kept],
        contacts.arm[kept],
        contacts.axes[kept],
        contacts.gap[kept],
        contacts.rest[kept],
        contacts.way[kept],
        contacts.foot[kept],
        contacts.border[kept],
    )


@compiled
def moved_on(contacts: SpaceContacts, frames: Array, place: Array, share: float) -> SpaceContacts:
    """The points with crossings a share of the way from where they were to where they are.

    By rotations and centres of all bodies; the share is one half for the middle of a step, if all
    the rest is that at its end.
    """
    arm, foot = contacts.arm.copy(), contacts.foot.copy()
    for q in range(len(arm)):
        way = contacts.way[q]
        if np.any(way != 0):
            i, j = contacts.body[q], contacts.base[q]
            crossing = way, foot[q], contacts.border[q], contacts.axes[q]
            turns, centres = (frames[i], frames[j]), (place[i], place[j])
            arm[q], foot[q] = moved_along(arm[q], crossing, centres, turns, share)
    return SpaceContacts(
        contacts.pair,
        contacts.slot,
        contacts.body,
        contacts.base,
        contacts.face,
        arm,
        contacts.axes,
        contacts.gap,
        contacts.rest,
        contacts.way,
        foot,
        contacts.border,
    )


@compiled
def halfway(
    contacts: SpaceContacts, state: SpaceState, frames: Array, mean: Array, shift: Array
) -> SpaceContacts:
    """The points with crossings where they are in the middle of a step.

    By state and rotations at its start, mean rotations and mean places of the bodies.
    """
    return moved_on(contacts, 2 * mean - frames, 2 * shift - state.place, 0.5)


@compiled
def rows_of(
    contacts: SpaceContacts,
    mean: Array,
    shift: Array,
) -> tuple[Array, Array, Array]:
    """Rows of the contact points on increments of centres and Cayley vectors.

    With mean rotations and mean places of a step they give the changes of gap and place exactly:

        z = R_c^T (x - x_c),   z_{n+1} - z_n = R_c,mean^T (dx - dx_c - psi_c x (x - x_c)_mean),

    and the force e on the one body and -e on the other act at one point of space; those of a
    crossing act at its places on both edges (`solver.rigid.space.boxes`). With rotations
    and places of an instant they give velocities.

    Args:
        contacts: m points, crossings half-way (`halfway`).
        mean: (n + 1, 3, 3) mean rotations.
        shift: (n + 1, 3) mean places of the bodies.

    Returns:
        Rows on centres (m, 3, 3), taken off for the body of the face; rows on the Cayley vectors of
        the point's body and of the face's body.
    """
    m = len(contacts.body)
    along, turn, back = np.empty((m, 3, 3)), np.empty((m, 3, 3)), np.empty((m, 3, 3))
    for q in range(m):
        i, j = contacts.body[q], contacts.base[q]
        arm = to_space(mean[i], contacts.arm[q])
        distance = shift[i] - shift[j] + arm
        crossing = np.any(contacts.way[q] != 0)
        if crossing:
            distance = to_space(mean[j], contacts.foot[q])
            a, b = to_space(mean[i], contacts.way[q]), to_space(mean[j], contacts.border[q])
            normal = normal_between(a, b, contacts.axes[q, 0])
        for k in range(3):
            e = contacts.axes[q, k]
            if not crossing:
                e = to_space(mean[j], e)
            elif k == 0:
                e = normal
            along[q, k], turn[q, k], back[q, k] = e, cross(arm, e), -cross(distance, e)
    return along, turn, back
