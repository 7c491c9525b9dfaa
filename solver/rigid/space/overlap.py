"""The area in which faces of rigid boxes overlap, and each contact point's share of it; compiled.

The corners of the polygon in which two faces overlap in plan are the contact points. Each stands
for half of the triangles between the polygon's middle and its two edges there: a quarter of the
bottom for the corners of a block on the ground, and all shares together are the area.
"""

from __future__ import annotations

import numpy as np

from solver.law.compiled import compiled
from solver.rigid.space.boxes import TOP, corners_of, face_axes, face_corners
from solver.rigid.space.model import SpaceContacts, SpaceModel, SpaceState
from solver.rigid.space.rotation import to_body, to_space
from solver.types import Array

SAME_CORNER = 1e-2
"""Part of the larger half length within which a contact point is a corner of the polygon."""


@compiled
def facing_face(frame: Array, direction: Array) -> int:
    """The face of a box, rotated by `frame`, whose normal is most along a direction."""
    along = to_body(frame, direction)
    axis = int(np.argmax(np.abs(along)))
    return 2 * axis + (1 if along[axis] > 0 else 0)


@compiled
def clipped(polygon: Array, limits: Array) -> Array:
    """The part of a convex polygon (n, 2) within +- limits (2,); empty where there is none."""
    for axis in range(2):
        for sign in (-1.0, 1.0):
            n, m = len(polygon), 0
            kept = np.empty((2 * n + 2, 2))
            for k in range(n):
                a, b = polygon[k], polygon[(k + 1) % n]
                room, after = limits[axis] - sign * a[axis], limits[axis] - sign * b[axis]
                if room >= 0:
                    kept[m] = a
                    m += 1
                if (room > 0 > after) or (room < 0 < after):
                    kept[m] = a + room / (room - after) * (b - a)
                    m += 1
            polygon = kept[:m].copy()
    return polygon


@compiled
def corner_shares(polygon: Array) -> Array:
    """The area that each corner of a convex polygon (n, 2) stands for, (n,)."""
    n, shares = len(polygon), np.zeros(len(polygon))
    middle = np.zeros(2)
    for k in range(n):
        middle += polygon[k] / n
    for k in range(n):
        a, b = polygon[k] - middle, polygon[(k + 1) % n] - middle
        half = 0.25 * abs(a[0] * b[1] - a[1] * b[0])
        shares[k] += half
        shares[(k + 1) % n] += half
    return shares


@compiled
def _between(
    model: SpaceModel,
    state: SpaceState,
    frames: Array,
    contacts: SpaceContacts,
    first: int,
    area: Array,
) -> None:
    """Fill in the shares of all points of the pair of point `first`."""
    k = contacts.pair[first]
    u, c = model.upper[k], model.lower[k]
    up = to_space(frames[contacts.base[first]], face_axes(contacts.face[first])[0])
    if contacts.base[first] == u:
        up = -up
    below, above = facing_face(frames[c], up), facing_face(frames[u], -up)
    axes, ring = face_axes(below), corners_of(model.half[u])[face_corners(above)]
    plan = np.empty((4, 2))
    for i in range(4):
        place = state.place[u] - state.place[c] + to_space(frames[u], ring[i])
        plan[i] = to_space(axes, to_body(frames[c], place))[1:]
    axis = below // 2
    limits = np.array([model.half[c, (axis + 1) % 3], model.half[c, (axis + 2) % 3]])
    polygon = clipped(plan, limits)
    shares, near = corner_shares(polygon), (SAME_CORNER * np.max(limits)) ** 2
    for v in range(len(polygon)):
        nearest, least = -1, near
        for q in range(first, len(area)):
            if contacts.pair[q] == k:
                i = contacts.body[q]
                place = state.place[i] - state.place[c] + to_space(frames[i], contacts.arm[q])
                away = to_space(axes, to_body(frames[c], place))[1:] - polygon[v]
                if away @ away < least:
                    nearest, least = q, away @ away
        if nearest >= 0:
            area[nearest] += shares[v]


@compiled
def areas(model: SpaceModel, state: SpaceState, frames: Array, contacts: SpaceContacts) -> Array:
    """The area that cohesion acts on at each contact point, (m,), m2; 0 where there is none."""
    area, ground = np.zeros(len(contacts.pair)), len(model.half) - 1
    for q in range(len(area)):
        k = contacts.pair[q]
        if model.law.cohesion[k] == 0.0:
            continue
        if model.lower[k] == ground:
            u = model.upper[k]
            down = facing_face(frames[u], -face_axes(TOP)[0]) // 2
            area[q] = model.half[u, (down + 1) % 3] * model.half[u, (down + 2) % 3]
        elif q == 0 or contacts.pair[q - 1] != k:
            _between(model, state, frames, contacts, q, area)
    return area
