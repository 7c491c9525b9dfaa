"""Solids: polygons and prisms, bodies of revolution, hulls, surfaces, unions of several.

Round shapes are facets: `chord_error` says how far off.
"""

from __future__ import annotations

import importlib
import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from geometry.convex import Convex, Faces, few_corners, hull_of, polygon_faces, triangles_of
from geometry.overlap import common_balls
from geometry.polygon import (
    NEAR,
    area_of,
    convex_pieces,
    real_points,
    simple_polygon,
    size_of,
    told,
    turn,
    without_straight,
)
from geometry.solid import MOST_EDGES, SINGLE, Solid, refuse_not_positive
from geometry.surface import Surface, merged
from solver.types import Array

MOST_POINTS = 5000
"""Points of a surface of which the hull has all corners; of more it has those that it needs to be
off by no more than `COARSE`."""

COARSE = 1e-4
"""How far a point of a fine surface may be off its hull, as a part of the size; twice as far, and
so on, where the hull has more corners than contacts have numbers for."""

MOST_SIDES = 1000
"""Facets that a round shape may have."""


def polygon(points: ArrayLike, density: float, thickness: float) -> Solid:
    """A polygon in the plane, cut into convex parts where it is not convex.

    Args:
        points: Its corners, (n, 2), m, in either sense, none twice; sides must not cross or touch.
        density: kg/m^3.
        thickness: m.
    """
    pieces = convex_pieces(simple_polygon(points))
    parts = tuple(
        Convex(corners=piece, faces=polygon_faces(len(piece)), density=density) for piece in pieces
    )
    return Solid(parts=parts, thickness=thickness)


def regular(count: int, width: float, density: float, thickness: float) -> Solid:
    """A regular polygon in the plane that stands on a side, (0, 0) in the middle of this side.

    Args:
        count: Its corners, 3 or more.
        width: 2 R, m: twice the distance of the centre from a corner; across opposite corners
            where `count` is even.
        density: kg/m^3.
        thickness: m.
    """
    _refuse_sides("count", count)
    refuse_not_positive("width", width)
    angles = -np.pi / 2 + np.pi / count * (2 * np.arange(count) - 1)
    ring = width / 2 * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return polygon(ring, density, thickness).standing()


def prism(outline: Solid, thickness: float) -> Solid:
    """A body in space that has a solid of the plane as its section: (x, z) becomes (x, y, z).

    Args:
        outline: The section, whose parts keep their densities.
        thickness: m; y from minus half of it to half of it.
    """
    if outline.dimension != 2:
        raise ValueError("outline: got a solid in space, allowed one in the plane")
    refuse_not_positive("thickness", thickness)
    return Solid(parts=tuple(_extruded(part, thickness) for part in outline.parts))


def turned(profile: ArrayLike, sides: int, density: float) -> Solid:
    """A solid of revolution about the vertical axis, with facets; one of them looks along +x.

    Its parts fill at each level what is within the largest radius there, cut at the levels of
    re-entrant corners, into as few parts as level cuts make. Where the profile leaves something of
    that empty (hollows, undercuts), the parts are for contact, and its mass is that of its surface.

    Args:
        profile: The outline [[r, z], ...] of one half, m, r >= 0: from the axis r = 0 to the axis,
            or that of a ring.
        sides: Facets around; corners lie on the circles of the profile, so that facets are inside
            them by `chord_error`.
        density: kg/m^3.
    """
    _refuse_sides("sides", sides)
    outline = _half_outline(profile)
    filled = _filled(outline)
    parts = []
    for piece in _frusta(filled):
        corners, faces = _revolved(piece, sides)
        parts.append(Convex(corners=corners, faces=faces, density=density))
    if area_of(filled) - area_of(outline) <= 10 * NEAR * size_of(outline) ** 2:
        return Solid(parts=tuple(parts))
    corners, loops = _rings([*outline, outline[0]], sides)
    points, triangles = merged(corners, triangles_of(loops))
    surface = Surface(points=points, triangles=triangles, name="profile")
    return Solid(parts=tuple(parts), surface=surface, density=density)


def cylinder(diameter: float, height: float, sides: int, density: float) -> Solid:
    """An upright cylinder with facets, on z = 0 about the axis x = y = 0; as `turned` makes it."""
    refuse_not_positive("diameter", diameter)
    refuse_not_positive("height", height)
    radius = diameter / 2
    half = np.array([[0, 0], [radius, 0], [radius, height], [0, height]])
    return turned(half, sides, density)


def chord_error(radius: float, sides: int) -> float:
    """How far facets lie within the circle through their corners at most, R (1 - cos(pi/n)), m."""
    refuse_not_positive("radius", radius)
    _refuse_sides("sides", sides)
    return 2 * radius * math.sin(math.pi / sides / 2) ** 2


def hull(points: ArrayLike, density: float = 1.0, thickness: float = 1.0) -> Solid:
    """The convex hull of points in the plane, (n, 2), or in space, (n, 3), m.

    Args:
        points: m.
        density: kg/m^3.
        thickness: m, in the plane.
    """
    corners, faces = hull_of(points, NEAR)
    part = Convex(corners=corners, faces=faces, density=density)
    return Solid(parts=(part,), thickness=thickness)


def of_surface(surface: Surface, density: float, parts: Literal["hull", "coacd"] = "hull") -> Solid:
    """A body with the mass properties of a surface, and convex parts for contact.

    The hull is off by 1e-6 of the size, and of a surface of many points by `COARSE`; the parts of
    CoACD 1.0.14 by some 1e-4 of the size. Corners within 1e-6 of the size above the lowest one are
    put on its level, to which files of single precision do not tell them apart.

    Args:
        surface: A closed surface.
        density: kg/m^3.
        parts: Its convex hull, see `Solid.hull_excess`; or, where it is not convex, what CoACD
            (Wei et al., ACM Trans. Graph. 41, 2022) cuts it into.

    Raises:
        ValueError: CoACD is not installed, or makes too many parts.
    """
    points = surface.points[np.unique(surface.triangles)]
    whole, coarse = _hull_part(points, density, surface.name)
    found = [whole]
    if parts == "coacd" and whole.moments.volume > (1 + SINGLE) * surface.volume:
        pieces = [_hull_part(piece, density, surface.name) for piece in _cut_by_coacd(surface)]
        found, coarse = [part for part, _ in pieces], max(off for _, off in pieces)
    return Solid(parts=tuple(found), surface=surface, density=density, coarse=coarse)


def union(solids: Sequence[Solid]) -> Solid:
    """One rigid body of several that may touch and do not overlap; each keeps its densities.

    Where one of them has a surface of its own, all must have one density: the union's surface is
    that of all together, and the convex parts, which are hulls, are free to overlap.

    Raises:
        ValueError: none at all; of the plane and of space; of two thicknesses; two that overlap.
    """
    if not solids:
        raise ValueError("union: got no solids, allowed one or more")
    dimensions = {solid.dimension for solid in solids}
    if len(dimensions) > 1:
        raise ValueError("union: got solids of the plane and of space, allowed one of both")
    thicknesses = sorted({solid.thickness for solid in solids})
    if dimensions == {2} and len(thicknesses) > 1:
        raise ValueError(f"union: got thicknesses {thicknesses} m, allowed one")
    parts = tuple(part for solid in solids for part in solid.parts)
    if any(solid.surface for solid in solids):
        return _with_one_surface(solids, parts)
    for number, solid in enumerate(solids):
        for other in solids[number + 1 :]:
            _refuse_overlap(solid, other)
    return Solid(parts=parts, thickness=solids[0].thickness)


def _refuse_sides(name: str, count: int) -> None:
    """A round shape has some facets, and a whole number of them."""
    if count != int(count) or not 3 <= count <= MOST_SIDES:
        raise ValueError(f"{name}: got {count}, allowed a whole number from 3 to {MOST_SIDES}")


def _extruded(part: Convex, thickness: float) -> Convex:
    """A polygon of the x-z plane as a prism along y."""
    x, z = part.corners.T
    half = np.full(len(x), thickness / 2)
    corners = np.concatenate([np.stack([x, -half, z], axis=1), np.stack([x, half, z], axis=1)])
    count = len(x)
    front = tuple(range(count))  # from -y one sees x to the right and z upwards
    back = tuple(count + k for k in reversed(range(count)))
    sides = tuple((end, start, start + count, end + count) for start, end in polygon_faces(count))
    return Convex(corners=corners, faces=(front, back, *sides), density=part.density)


def _half_outline(profile: ArrayLike) -> Array:
    """The points [r, z] of a profile, anticlockwise, those near the axis on it."""
    given = real_points(profile, "profile", 2)
    near = NEAR * size_of(given) if len(given) else 0.0
    given[np.abs(given[:, 0]) <= near, 0] = 0.0
    if (given[:, 0] < 0).any():
        worst = given[np.argmin(given[:, 0])]
        raise ValueError(f"profile: got the point {told(worst)}, allowed [r, z] with r >= 0")
    return simple_polygon(given, "profile")


def _filled(outline: Array) -> Array:
    """The outline with all that is within its largest radius at each level, along the axis first.

    Between two levels of its points one side of the outline is the outermost.
    """
    near = NEAR * size_of(outline)
    levels = np.unique(outline[:, 1])
    levels = levels[np.diff(levels, prepend=-np.inf) > near]
    radius = outline[:, 0]
    place = np.searchsorted(levels, outline[:, 1], side="right") - 1
    ring = [np.array([0.0, levels[0]])]
    for slab in range(len(levels) - 1):
        ends = levels[slab : slab + 2]
        best = np.zeros(2)
        for start, end in polygon_faces(len(outline)):
            low, high = (start, end) if place[start] < place[end] else (end, start)
            if place[low] <= slab < place[high]:
                part = (ends - levels[place[low]]) / (levels[place[high]] - levels[place[low]])
                across = radius[low] * (1 - part) + radius[high] * part
                best = max(best, across, key=np.sum)
        ring += [np.array([r, z]) for r, z in zip(best, ends, strict=True)]
    ring.append(np.array([0.0, levels[-1]]))
    apart = [ring[0], *(b for a, b in pairwise(ring) if np.abs(b - a).max() > near)]
    return without_straight(np.array(apart), near)


def _frusta(chain: Array) -> list[Array]:
    """Pieces of an outline that goes up, cut at the levels of its re-entrant corners."""
    near = NEAR * size_of(chain)
    before, here, after = chain[:-2], chain[1:-1], chain[2:]
    off = turn(before, here, after) / np.linalg.norm(after - before, axis=1)
    cuts = [float(chain[0, 1])]
    for level in [*here[off < -near, 1], chain[-1, 1]]:
        if level > cuts[-1] + near:
            cuts.append(float(level))
    pieces = []
    for low, high in pairwise(cuts):
        first = int(np.flatnonzero(chain[:, 1] <= low + near)[-1])
        last = int(np.flatnonzero(chain[:, 1] >= high - near)[0])
        pieces.append(chain[first : last + 1])
    return pieces


def _revolved(chain: Array, sides: int) -> tuple[Array, Faces]:
    """Corners and faces of a convex piece turned about the axis."""
    corners, faces = _rings(chain, sides)
    first, last = (sides if r > 0 else 1 for r in (chain[0, 0], chain[-1, 0]))
    ends = tuple(reversed(range(first))), tuple(range(len(corners) - last, len(corners)))
    return corners, tuple(face for face in (*ends, *faces) if len(face) > 2)


def _rings(chain: Sequence[Array] | Array, sides: int) -> tuple[Array, Faces]:
    """Corners of a chain turned about the axis, rings or tips on the axis, and faces in between."""
    angles = np.pi / sides * (2 * np.arange(sides) + 1)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    rows: list[list[int]] = []
    corners: list[Array] = []
    for r, z in chain:
        begin = sum(len(row) for row in rows)
        ring = r * circle if r > 0 else np.zeros((1, 2))
        corners.append(np.column_stack([ring, np.full(len(ring), z)]))
        rows.append(list(range(begin, begin + len(ring))))
    faces = []
    for lower, upper in pairwise(rows):
        for k in range(sides):
            below = [lower[k % len(lower)], lower[(k + 1) % sides % len(lower)]]
            above = [upper[(k + 1) % sides % len(upper)], upper[k % len(upper)]]
            faces.append(tuple(dict.fromkeys([*below, *above])))
    return np.concatenate(corners), tuple(face for face in faces if len(face) > 2)


def _hull_part(points: Array, density: float, name: str) -> tuple[Convex, float]:
    """The convex hull of points of single precision, its lowest corners on one level.

    Returns:
        The hull, and by how much points may be off it, m.
    """
    size, coarse = size_of(points), 0.0
    chosen, most = points, MOST_POINTS
    while len(chosen) > most:
        coarse, most = 2 * coarse or COARSE * size, MOST_EDGES // 3
        lowest = points[points[:, 2] <= points[:, 2].min() + SINGLE * size]
        if len(np.unique(lowest[:, :2], axis=0)) > 2:  # on which it stands
            flat = few_corners(lowest[:, :2], coarse)
            lowest = np.column_stack([flat, np.full(len(flat), points[:, 2].min())])
        chosen = np.concatenate([few_corners(points, coarse), lowest])
    corners, faces = hull_of(chosen, SINGLE, name)
    low = corners[:, 2].min()
    corners[corners[:, 2] <= low + SINGLE * size_of(corners), 2] = low
    return Convex(corners=corners, faces=faces, density=density), coarse


def _cut_by_coacd(surface: Surface) -> list[Array]:
    """Points of convex pieces of a surface by CoACD."""
    try:
        coacd: Any = importlib.import_module("coacd")
    except ImportError:
        raise ValueError(
            'got contact = "coacd", which is not installed, allowed after `pip install coacd`'
        ) from None
    coacd.set_log_level("error")
    pieces = coacd.run_coacd(coacd.Mesh(surface.points, surface.triangles), seed=0)
    return [np.asarray(points, dtype=np.float64) for points, _ in pieces]


def _with_one_surface(solids: Sequence[Solid], parts: tuple[Convex, ...]) -> Solid:
    """A union by the surfaces of all."""
    densities = sorted(
        {solid.density for solid in solids if solid.density is not None}
        | {part.density for solid in solids if solid.surface is None for part in solid.parts}
    )
    if densities[-1] > densities[0] * (1 + 1e-12):
        raise ValueError(
            f"union: got densities from {densities[0]:.6g} to {densities[-1]:.6g} kg/m3, allowed"
            " one where a solid has a surface of its own"
        )
    points: list[Array] = []
    triangles = []
    for solid in solids:
        skins = [(part.corners, triangles_of(part.faces)) for part in solid.parts]
        if solid.surface is not None:
            skins = [(solid.surface.points, solid.surface.triangles)]
        for corners, facets in skins:
            triangles.append(facets + sum(len(one) for one in points))
            points.append(corners)
    surface = Surface(
        points=np.concatenate(points), triangles=np.concatenate(triangles), name="union"
    )
    coarse = max(solid.coarse for solid in solids)
    return Solid(parts=parts, surface=surface, density=densities[0], coarse=coarse)


def _refuse_overlap(first: Solid, second: Solid) -> None:
    """ValueError where parts of two solids have a ball in common."""
    least = SINGLE * size_of(np.concatenate([first.corners, second.corners]))
    for radius, place in common_balls(first.parts, second.parts, least):
        if radius > least:
            raise ValueError(
                f"union: got solids that overlap by {2 * radius:.3g} m at {told(place)},"
                " allowed ones that touch or are apart"
            )
