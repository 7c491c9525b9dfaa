"""Where an edge of one box's face crosses an edge of another's, compiled.

The normal n of two edges is at right angles to both, and the places x_u and x_l on them lie on one
line along n. With s_u and s_l the ways of these places along the edges in a step, bars for means
and d for increments over it,

    D = dx_u - dx_l                       of the material places half-way, s_u/2 and s_l/2
    a = s_u mean R_u e_u,  b = s_l mean R_l e_l
    dg = m . D,  m = (a x b)/(n . (a x b))       since D + a - b = dg n
    ds = t . D                                   slip, counted from the begin of each step

hold exactly, n and t standing still within the step: as for meshed bodies, edges being straight
here (`solver/contact/edge_crossings.py`). m needs no ways, only the directions of the mean edges.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from solver.law.compiled import compiled
from solver.law.crossing import PARALLEL_ANGLE
from solver.rigid.space.rotation import cross, to_space
from solver.types import Array

ENDS = 8
"""Two ends for each edge of the upper face, where it enters the lower one and where it leaves."""

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
