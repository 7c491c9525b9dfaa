"""Where rigid boxes touch: points on faces, crossings of edges, areas. Compiled.

On the ground: the eight corners of each block. Between a block and its carrier, of the six faces of
each the one that separates the two boxes most is taken (the face part of the separating axis test),
and with these two faces: the corners of the one body within the outline of the other's face, and
the places where their edges cross. So the flat contact of two boxes, however
turned and shifted, has all corners of the polygon in which they touch. Edges of faces that are
inclined by more than 60 degrees to each other are left out.

The normal n of two edges is at right angles to both, and the places x_u and x_l on them lie on one
line along n. With s_u and s_l the ways of these places along the edges in a step, bars for means
and d for increments over it,

    D = dx_u - dx_l                       of the material places half-way, s_u/2 and s_l/2
    a = s_u mean R_u e_u,  b = s_l mean R_l e_l
    dg = m . D,  m = (a x b)/(n . (a x b))       since D + a - b = dg n
    ds = t . D                                   slip, counted from the begin of each step

hold exactly, n and t standing still within the step: as for meshed bodies, edges being straight
here (`solver/contact/edge_crossings.py`). m needs no ways, only the directions of the mean edges.

The corners of the polygon in which two faces overlap in plan are the contact points. Each stands
for half of the triangles between the polygon's middle and its two edges there: a quarter of the
bottom for the corners of a block on the ground, and all shares together are the area.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from solver.law.compiled import compiled
from solver.law.crossing import PARALLEL_ANGLE, STEEPEST_COSINE, TURNED_AWAY_COSINE
from solver.rigid.space.model import CORNERS, ENDS, SLOTS, SpaceContacts, SpaceModel, SpaceState
from solver.rigid.space.rotation import cross, product, to_body, to_space
from solver.types import Array, Indices

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


OUTLINE = 1e-6
"""How far beyond its outline a face still carries, relative to its half widths."""


class SpaceCrossings(NamedTuple):
    """Crossings of edges, by their ends. Those that touch as points of a face have zeros here."""

    way: Array
    """(ENDS, 3) direction of the upper edge, in its body."""
    foot: Array
    """(ENDS, 3) place on the lower edge, in its body, m."""
    border: Array
    """(ENDS, 3) direction of the lower edge, in its body."""
    axes: Array
    """(ENDS, 3, 3) rows normal and two tangential, in space."""


@compiled
def no_crossings(count: int) -> SpaceCrossings:
    """Zeros for so many points."""
    flat = np.zeros((3, count, 3))
    return SpaceCrossings(flat[0], flat[1], flat[2], np.zeros((count, 3, 3)))


@compiled
def unit(vector: Array) -> Array:
    """The direction of a vector."""
    return vector * (1 / math.sqrt(np.sum(vector * vector)))


@compiled
def ends_of(a: Array, way: Array, limits: Array) -> tuple[Array, Array]:
    """Where an edge enters an outline and leaves it (Liang and Barsky 1984).

    Args:
        a: (2,) its begin in the plane of the outline, m.
        way: (2,) from there to its end.
        limits: (2,) half widths of the outline.

    Returns:
        Parts of the way; the sides of the outline there: -2 and 2 across the first axis, -3 and 3
        across the second, 0 where it begins or ends inside. An edge outside leaves before it
        enters.
    """
    ends, sides = np.array([0.0, 1.0]), np.zeros(2)
    for axis in range(2):
        for sign in (-1.0, 1.0):
            pace, room = sign * way[axis], limits[axis] * (1 + OUTLINE) - sign * a[axis]
            if pace > 0 and room / pace < ends[1]:
                ends[1], sides[1] = room / pace, sign * (axis + 2)
            elif pace < 0 and room / pace > ends[0]:
                ends[0], sides[0] = room / pace, sign * (axis + 2)
            elif pace == 0 and room < 0:
                ends[1] = -1.0
    return ends, sides


@compiled
def apart(a: Array, b: Array, distance: Array, axes: Array) -> tuple[float, float]:
    """The ways s and r for which distance + s a - r b is along the normal; 0 where parallel."""
    a1, a2 = axes[1] @ a, axes[2] @ a
    b1, b2 = axes[1] @ b, axes[2] @ b
    d1, d2 = axes[1] @ distance, axes[2] @ distance
    area = a1 * b2 - a2 * b1
    if abs(area) < 0.5 * PARALLEL_ANGLE:
        return 0.0, 0.0
    return (b1 * d2 - b2 * d1) / area, (a1 * d2 - a2 * d1) / area


@compiled
def frame_of(a: Array, b: Array, up: Array) -> tuple[float, float, Array]:
    """Sine between two edges, cosine between their normal and `up`, normal and tangents."""
    normal = cross(a, b)
    sine = math.sqrt(np.sum(normal * normal))
    axes = np.zeros((3, 3))
    if sine < PARALLEL_ANGLE:
        return sine, 1.0, axes
    rise = float(normal @ up) / sine
    axes[0] = normal / (sine if rise > 0 else -sine)
    axes[1] = b
    axes[2] = cross(axes[0], b)
    return sine, abs(rise), axes


@compiled
def normal_between(a: Array, b: Array, normal: Array) -> Array:
    """m: at right angles to two edges, and as long as its part along the normal is 1.

    The normal itself where the edges have turned until they are parallel.
    """
    across = cross(a, b)
    rise = normal @ across
    return across / rise if abs(rise) > 0.1 * PARALLEL_ANGLE else normal.copy()


@compiled
def moved_along(
    arm: Array,
    crossing: tuple[Array, Array, Array, Array],
    places: tuple[Array, Array],
    frames: tuple[Array, Array],
    share: float,
) -> tuple[Array, Array]:
    """Places on both edges after a share of the way to where they cross now, each in its body, m.

    Of the place `arm` on the upper edge, and way, foot, border and axes of one crossing; centres
    and rotations are those of the upper and the lower body.
    """
    way, foot, border, axes = crossing
    a, b = to_space(frames[0], way), to_space(frames[1], border)
    over, under = places[0] + to_space(frames[0], arm), places[1] + to_space(frames[1], foot)
    s, r = apart(a, b, over - under, axes)
    return arm + share * s * way, foot + share * r * border


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
