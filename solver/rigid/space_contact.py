"""The contact points of a step of rigid blocks in space, and their rows, compiled."""

from __future__ import annotations

import math

import numpy as np

from solver.rigid.compiled import compiled
from solver.rigid.space_boxes import (
    SLOTS,
    TOP,
    corners_of,
    face_axes,
    points_between,
    points_on_face,
)
from solver.rigid.space_model import Array, Contacts, SpaceModel, SpaceState
from solver.rigid.space_rotation import cross, rotation_of, to_space


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
def contacts_of(
    model: SpaceModel, state: SpaceState, frames: Array, dt: float, ground: Array
) -> Contacts:
    """All points that may touch in a step.

    Args:
        model: The bodies.
        state: At the start of the step.
        frames: Rotations of all bodies.
        dt: Step, s.
        ground: Acceleration of the ground, m/s2.
    """
    n, most, m = len(model.half) - 1, SLOTS * len(model.upper), 0
    pull = math.sqrt(np.sum((model.gravity - ground) ** 2))
    whole = np.empty((most, 5), dtype=np.int64)
    arm, axes, start = np.empty((most, 3)), np.empty((most, 3, 3)), np.empty((most, 3))
    for k in range(len(model.upper)):
        u, c, reach = model.upper[k], model.lower[k], _approach(model, state, k, dt, pull)
        below, above = TOP, 0
        if c == n:
            size = math.sqrt(np.sum(model.half[u] ** 2))
            if state.place[u, 2] - size > reach:
                continue
            places = corners_of(model.half[u])
            found = points_on_face(state, frames, model.half, u, c, TOP, places)
        else:
            below, above, places, found = points_between(model, state, frames, k, reach)
        for slot in range(len(places)):
            if found[slot, 0] > reach:
                continue
            lower = 8 <= slot < 16
            body, base, face = (c, u, above) if lower else (u, c, below)
            whole[m, 0], whole[m, 1], whole[m, 2], whole[m, 3] = k, slot, body, base
            whole[m, 4] = face
            arm[m], start[m], axes[m] = places[slot], found[slot], face_axes(face)
            m += 1
    pair, slots, bodies = whole[:m, 0].copy(), whole[:m, 1].copy(), whole[:m, 2].copy()
    bases, faces = whole[:m, 3].copy(), whole[:m, 4].copy()
    return Contacts(pair, slots, bodies, bases, faces, arm[:m], axes[:m], start[:m])


@compiled
def chosen(contacts: Contacts, mask: Array) -> Contacts:
    """Those of the points where the mask is above 0."""
    kept = np.flatnonzero(mask > 0)
    return Contacts(
        contacts.pair[kept],
        contacts.slot[kept],
        contacts.body[kept],
        contacts.base[kept],
        contacts.face[kept],
        contacts.arm[kept],
        contacts.axes[kept],
        contacts.start[kept],
    )


@compiled
def rows_of(
    contacts: Contacts,
    mean: Array,
    shift: Array,
) -> tuple[Array, Array, Array]:
    """Rows of the contact points on increments of centres and Cayley vectors.

    With mean rotations and mean places of a step they give the changes of gap and place exactly:

        z = R_c^T (x - x_c),   z_{n+1} - z_n = R_c,mean^T (dx - dx_c - psi_c x (x - x_c)_mean),

    and the force e on the one body and -e on the other act at one point of space. With rotations
    and places of an instant they give velocities.

    Args:
        contacts: m points.
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
        for k in range(3):
            e = to_space(mean[j], contacts.axes[q, k])
            along[q, k], turn[q, k], back[q, k] = e, cross(arm, e), -cross(distance, e)
    return along, turn, back
