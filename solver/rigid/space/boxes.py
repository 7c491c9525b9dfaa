"""Which points of rigid boxes may touch which faces, compiled.

On the ground: the eight corners of each block. Between a block and its carrier, of the six faces of
each the one that separates the two boxes most is taken (the face part of the separating axis test),
and with these two faces: the corners of the one body within the outline of the other's face, and
the places where their edges cross (`edge_crossings`). So the flat contact of two boxes, however
turned and shifted, has all corners of the polygon in which they touch. Edges of faces that are
inclined by more than 60 degrees to each other are left out.
"""

from __future__ import annotations

import math

import numpy as np

from solver.law.compiled import compiled
from solver.law.crossing import PARALLEL_ANGLE, STEEPEST_COSINE, TURNED_AWAY_COSINE
from solver.rigid.space.edge_crossings import (
    ENDS,
    OUTLINE,
    SpaceCrossings,
    ends_of,
    frame_of,
    moved_along,
    no_crossings,
    unit,
)
from solver.rigid.space.model import SpaceModel, SpaceState
from solver.rigid.space.rotation import product, to_body, to_space
from solver.types import Array, Indices

CORNERS = 16
"""Places for contact points of a pair: first 8 corners of the upper body and 8 of the lower one,"""

SLOTS = CORNERS + ENDS
"""then the ends of the upper face's edges where they cross those of the lower one."""

TOP = 5
"""Number of the top face: 2 * axis + (0 for the negative side, 1 for the positive)."""


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

    By the half lengths of both, and centre and rotation of the other one as seen from the box.
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
def face_corners(face: int) -> Indices:
    """The four corners of a face, in a round."""
    table = np.array(
        [[0, 3, 7, 4], [1, 2, 6, 5], [0, 1, 5, 4], [3, 2, 6, 7], [0, 1, 2, 3], [4, 5, 6, 7]]
    )
    return table[face]


@compiled
def _crossings(
    over: Array,
    ring: Array,
    faces: tuple[Array, Array],
    frames: tuple[Array, Array],
    centres: tuple[Array, Array],
    points: tuple[Array, Array],
) -> SpaceCrossings:
    """Ends of the edges of a face within the outline of another.

    Ends that are corners of the one or the other face are left out.

    Args:
        over: (4, 3) the corners of the upper face over the lower one: gap, place along it.
        ring: (4, 3) the same corners in their own body.
        faces: Axes of the lower face, half lengths of its box along them.
        frames: Rotations of the upper and the lower body.
        centres: Their centres.
        points: Filled in: (ENDS, 3) the ends in the upper body, and their gap and place.
    """
    axes, limits = faces[0], faces[1][1:]
    places, found, crossings = points[0], points[1], no_crossings(ENDS)
    up = to_space(frames[1], axes[0])
    for k in range(4):
        along = over[(k + 1) % 4] - over[k]
        ends, sides = ends_of(over[k, 1:], along[1:], limits)
        for number, t, side in ((2 * k, ends[0], sides[0]), (2 * k + 1, ends[1], sides[1])):
            if side == 0 or not (ends[0] < ends[1] and OUTLINE < t < 1 - OUTLINE):
                continue
            end, across = over[k] + t * along, int(abs(side)) - 1
            other = 3 - across
            if abs(end[other]) > limits[other - 1] - OUTLINE * np.max(limits):
                continue
            edge = ring[(k + 1) % 4] - ring[k]
            place, border = ring[k] + t * edge, axes[other]
            way = unit(edge)
            a, b = to_space(frames[0], way), to_space(frames[1], border)
            sine, rise, frame = frame_of(a, b, up)
            if sine < PARALLEL_ANGLE:
                places[number], found[number] = place, end
                continue
            if rise < STEEPEST_COSINE:
                continue
            end[0], end[across] = faces[1][0], math.copysign(limits[across - 1], side)
            foot = to_body(axes, end)
            crossing = way, foot, border, frame
            place, foot = moved_along(place, crossing, centres, frames, 1.0)
            beyond = abs(axes[other] @ foot) > limits[other - 1] * (1 + OUTLINE)
            part = ((place - ring[k]) @ way) / math.sqrt(np.sum(edge * edge))
            if beyond or part < -OUTLINE or part > 1 + OUTLINE:
                continue
            distance = centres[0] - centres[1] + to_space(frames[0], place)
            distance -= to_space(frames[1], foot)
            places[number], found[number, 0], found[number, 1:] = place, frame[0] @ distance, 0.0
            crossings.way[number], crossings.foot[number] = way, foot
            crossings.border[number], crossings.axes[number] = border, frame
    return crossings


@compiled
def _merge(state: SpaceState, frames: Array, u: int, c: int, places: Array, found: Array) -> None:
    """Take out the carrier's corners that lie where a corner of the block touches."""
    for i in range(8, CORNERS):
        x = state.place[c] + to_space(frames[c], places[i])
        for j in range(8):
            gap = state.place[u] + to_space(frames[u], places[j]) - x
            near = 1e-5 * (abs(places[i, 0]) + abs(places[i, 1]) + abs(places[i, 2]))
            if found[j, 0] < np.inf and np.max(np.abs(gap)) < near:
                found[i, 0] = np.inf


@compiled
def points_between(
    model: SpaceModel, state: SpaceState, frames: Array, pair: int, reach: float
) -> tuple[int, int, Array, Array, SpaceCrossings]:
    """The points of a block and its carrier: the two faces, places in their bodies, and gaps.

    Returns:
        Face of the carrier, face of the block, places (SLOTS, 3), (SLOTS, 3) gap and place along,
        the crossings among the last ENDS of them.
    """
    u, c, half = model.upper[pair], model.lower[pair], model.half
    places, found = np.zeros((SLOTS, 3)), np.full((SLOTS, 3), np.inf)
    turn = product(frames[c].T, frames[u])
    shift = state.place[u] - state.place[c]
    below, apart = separating_face(half[c], half[u], to_body(frames[c], shift), turn)
    above, beyond = separating_face(half[u], half[c], to_body(frames[u], -shift), turn.T)
    none = no_crossings(ENDS)
    if max(apart, beyond) > reach:
        return below, above, places, found, none
    places[:8], places[8:16] = corners_of(half[u]), corners_of(half[c])
    found[:8] = points_on_face(state, frames, half, u, c, below, places[:8])
    found[8:16] = points_on_face(state, frames, half, c, u, above, places[8:16])
    axes, facing = face_axes(below), to_space(frames[u], face_axes(above)[0])
    if facing @ to_space(frames[c], axes[0]) > -TURNED_AWAY_COSINE:
        return below, above, places, found, none
    limits = half[c, np.array([below // 2, (below // 2 + 1) % 3, (below // 2 + 2) % 3])]
    ring, over = places[face_corners(above)], np.empty((4, 3))
    for k in range(4):
        over[k] = to_space(axes, to_body(frames[c], shift + to_space(frames[u], ring[k])))
        over[k, 0] -= limits[0]
    turns, centres = (frames[u], frames[c]), (state.place[u], state.place[c])
    points = places[CORNERS:], found[CORNERS:]
    crossings = _crossings(over, ring, (axes, limits), turns, centres, points)
    _merge(state, frames, u, c, places, found)
    return below, above, places, found, crossings
