"""Which points of rigid boxes may touch which faces, compiled.

On the ground: the eight corners of each block. Between a block and its carrier, of the six faces of
each the one that separates the two boxes most is taken (the face part of the separating axis test),
and with these two faces: the corners of the one body within the outline of the other's face, and
where the two outlines cross, the crossing, as a point of the upper body. So the flat contact of two
boxes, however turned and shifted, has all corners of the polygon in which they touch. Contact of
two edges alone, both faces inclined by more than 60 degrees to each other, is left out, and so is
the normal that two inclined edges have of their own: it is that of the lower body's face.
"""

from __future__ import annotations

import numpy as np

from solver.rigid.compiled import compiled
from solver.rigid.space_model import Array, Numbers, SpaceModel, SpaceState
from solver.rigid.space_rotation import product, to_body, to_space

SLOTS = 24
"""Places for contact points of a pair: 8 corners of the upper body, 8 of the lower, 8 ends of
the upper face's edges where they cross those of the lower one."""

TOP = 5
"""Number of the top face: 2 * axis + (0 for the negative side, 1 for the positive)."""

OUTLINE = 1e-6
"""How far beyond its outline a face still carries, relative to its half widths."""


@compiled
def corner(half: Array, number: int) -> Array:
    """A corner of a box; the bottom ones are 0 to 3, counterclockwise from (-, -) seen from above.

    Those of the top are 4 to 7, above them.
    """
    r = half.copy()
    r[0] *= 1.0 if number % 4 in (1, 2) else -1.0
    r[1] *= 1.0 if number % 4 >= 2 else -1.0
    r[2] *= 1.0 if number >= 4 else -1.0
    return r


@compiled
def face_axes(face: int) -> Array:
    """Rows normal, first and second tangent of a face of a box, right-handed; (z, x, y) on top."""
    axis, sign = face // 2, 1.0 if face % 2 else -1.0
    rows = np.zeros((3, 3))
    rows[0, axis], rows[1, (axis + 1) % 3], rows[2, (axis + 2) % 3] = sign, 1.0, sign
    return rows


@compiled
def separating_face(half: Array, other: Array, centre: Array, turn: Array) -> tuple[int, float]:
    """The face of a box that separates it most from another one, and by how much, m.

    Args:
        half: Half lengths of the box.
        other: Those of the other one.
        centre: Centre of the other one in the body of the box.
        turn: Rotation of the other one as seen from the box.
    """
    face, largest = TOP, -np.inf
    for axis in (2, 0, 1):
        reach = half[axis]
        for k in range(3):
            reach += abs(turn[axis, k]) * other[k]
        separation = abs(centre[axis]) - reach
        if separation > largest:
            face, largest = 2 * axis + (1 if centre[axis] > 0 else 0), separation
    return face, largest


@compiled
def corners_of(half: Array) -> Array:
    """All corners of a box, (8, 3)."""
    places = np.empty((8, 3))
    for k in range(8):
        places[k] = corner(half, k)
    return places


@compiled
def points_on_face(
    state: SpaceState,
    frames: Array,
    half: Array,
    body: int,
    base: int,
    face: int,
    places: Array,
) -> Array:
    """Gap and place along a face of `base` of points given in `body`; outside its outline: inf."""
    axes, size = face_axes(face), len(places)
    found = np.empty((size, 3))
    shift = state.place[body] - state.place[base]
    for i in range(size):
        z = to_body(frames[base], shift + to_space(frames[body], places[i]))
        found[i] = to_space(axes, z)
        found[i, 0] -= half[base, face // 2]
        for k in (1, 2):
            limit = half[base, (face // 2 + k) % 3] * (1 + OUTLINE)
            if limit > 0 and abs(found[i, k]) > limit:
                found[i, 0] = np.inf
    return found


@compiled
def _face_corners(face: int) -> Numbers:
    """The four corners of a face, in a round."""
    table = np.array(
        [[0, 3, 7, 4], [1, 2, 6, 5], [0, 1, 5, 4], [3, 2, 6, 7], [0, 1, 2, 3], [4, 5, 6, 7]]
    )
    return table[face]


@compiled
def _crossings(over: Array, limits: Array, ring: Array, places: Array, found: Array) -> None:
    """Ends of the edges of a face within the outline of another (Liang and Barsky 1984).

    Ends that are corners of the one or the other face are left out.

    Args:
        over: (4, 3) the corners of the face over the other one: gap, place along it.
        limits: (2,) half widths of the outline.
        ring: (4, 3) the same corners in their own body.
        places: (8, 3) filled in: the ends in the body of the edges,
        found: (8, 3) and over the other face.
    """
    for k in range(4):
        a, way = over[k, 1:], over[(k + 1) % 4, 1:] - over[k, 1:]
        enters, leaves = 0.0, 1.0
        for axis in range(2):
            for sign in (-1.0, 1.0):
                pace, room = sign * way[axis], limits[axis] * (1 + OUTLINE) - sign * a[axis]
                if pace > 0:
                    leaves = min(leaves, room / pace)
                elif pace < 0:
                    enters = max(enters, room / pace)
                elif room < 0:
                    leaves = -1.0
        for number, t in ((2 * k, enters), (2 * k + 1, leaves)):
            beyond = np.abs(a + t * way) - limits
            if not (enters < leaves and OUTLINE < t < 1 - OUTLINE):
                continue
            if np.min(beyond) < -OUTLINE * np.max(limits):
                places[number] = (1 - t) * ring[k] + t * ring[(k + 1) % 4]
                found[number] = (1 - t) * over[k] + t * over[(k + 1) % 4]


@compiled
def _merge(state: SpaceState, frames: Array, u: int, c: int, places: Array, found: Array) -> None:
    """Take out the carrier's corners that lie where a corner of the block touches."""
    for i in range(8, 16):
        x = state.place[c] + to_space(frames[c], places[i])
        for j in range(8):
            gap = state.place[u] + to_space(frames[u], places[j]) - x
            near = 1e-5 * (abs(places[i, 0]) + abs(places[i, 1]) + abs(places[i, 2]))
            if found[j, 0] < np.inf and np.max(np.abs(gap)) < near:
                found[i, 0] = np.inf


@compiled
def points_between(
    model: SpaceModel, state: SpaceState, frames: Array, pair: int, reach: float
) -> tuple[int, int, Array, Array]:
    """The points of a block and its carrier: the two faces, places in their bodies, and gaps.

    Returns:
        Face of the carrier, face of the block, places (SLOTS, 3), (SLOTS, 3) gap and place along.
    """
    u, c, half = model.upper[pair], model.lower[pair], model.half
    places, found = np.zeros((SLOTS, 3)), np.full((SLOTS, 3), np.inf)
    turn = product(frames[c].T, frames[u])
    shift = state.place[u] - state.place[c]
    below, apart = separating_face(half[c], half[u], to_body(frames[c], shift), turn)
    above, beyond = separating_face(half[u], half[c], to_body(frames[u], -shift), turn.T)
    if max(apart, beyond) > reach:
        return below, above, places, found
    places[:8], places[8:16] = corners_of(half[u]), corners_of(half[c])
    found[:8] = points_on_face(state, frames, half, u, c, below, places[:8])
    found[8:16] = points_on_face(state, frames, half, c, u, above, places[8:16])
    facing = to_space(frames[u], face_axes(above)[0]) @ to_space(frames[c], face_axes(below)[0])
    if facing > -0.5:
        return below, above, places, found
    ring, over = places[_face_corners(above)], np.empty((4, 3))
    for k in range(4):
        over[k] = to_space(
            face_axes(below), to_body(frames[c], shift + to_space(frames[u], ring[k]))
        )
        over[k, 0] -= half[c, below // 2]
    limits = half[c, np.array([(below // 2 + 1) % 3, (below // 2 + 2) % 3])]
    _crossings(over, limits, ring, places[16:], found[16:])
    _merge(state, frames, u, c, places, found)
    return below, above, places, found
