"""What is seen of a body of convex parts: its faces, and its edges without the seams between parts.

Where two parts touch, their faces are inside of the body, and an edge at which both are flush is no
edge of the body. At an edge the parts fill angles around it; what they leave open says what the
body is there: nothing where it is inside, a half-plane where it is flat, else an edge of it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from geometry.block import FACES, Block
from geometry.convex import (
    Convex,
    Faces,
    edges_between,
    loops_of,
    normals_of,
    polygon_faces,
)
from geometry.polygon import size_of
from solver.types import Array

TOUCHES = 1e-7
"""Distance, as a part of the size, below which a place is on a plane."""

FULL = 1e-6
"""Angle that is none, rad."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Skin:
    """Faces and edges of a body in its own frame."""

    corners: Array
    """Corners, (n, d), m."""
    faces: Faces
    """Numbers of the corners around each face; in the plane around each convex part."""
    edges: Array
    """Ends of the edges, (m, 2, d), m."""
    normals: Array
    """Outward unit normals of the two faces that meet at each edge, (m, 2, d); in the plane twice
    the one of the side."""


def skin_of(block: Block, dimension: int) -> Skin:
    """What is seen of a block: its true surface where it has one, else its parts."""
    solid = block.solid
    if solid is not None and solid.surface is None:
        return skin_of_parts(solid.parts)
    corners, faces = faces_of(block, dimension)
    if dimension == 3:
        return _of_faces(corners, faces)
    ends = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
    outwards = normals_of(corners, polygon_faces(len(corners)))
    normals = np.repeat(outwards[:, None], 2, axis=1)
    return Skin(corners=corners, faces=faces, edges=ends, normals=normals)


def faces_of(block: Block, dimension: int) -> tuple[Array, Faces]:
    """Corners, (n, d), m, and their numbers around the faces of what is seen of a block.

    Those between two parts are among them; in the plane a face is a part.
    """
    if block.solid is None:
        corners = np.array(block.corners(dimension))
        return corners, tuple(FACES) if dimension == 3 else ((0, 1, 2, 3),)
    if (surface := block.solid.surface) is not None:
        return surface.points, tuple(tuple(map(int, tri)) for tri in surface.triangles)
    return block.solid.corners, loops_of(block.solid.parts)


def skin_of_parts(parts: Sequence[Convex]) -> Skin:
    """What is seen of convex parts that touch one another."""
    corners, faces = np.concatenate([part.corners for part in parts]), loops_of(parts)
    size = size_of(corners)
    bodies = [_Body(part, size) for part in parts]
    found = [edge for number in range(len(parts)) for edge in _edges_of(bodies, number)]
    d = corners.shape[1]
    edges = np.array([ends for ends, _ in found]).reshape(-1, 2, d)
    normals = np.array([both for _, both in found]).reshape(-1, 2, d)
    return Skin(corners=corners, faces=faces, edges=edges, normals=normals)


def _of_faces(corners: Array, faces: Faces) -> Skin:
    """A closed body in space, each edge of which two faces have."""
    found = np.array(edges_between(faces))
    normals = normals_of(corners, faces)[found[:, [3, 2]]]
    return Skin(corners=corners, faces=faces, edges=corners[found[:, :2]], normals=normals)


class _Body:
    """A convex part as half-spaces."""

    def __init__(self, part: Convex, size: float):
        """Take its planes; a place is on one within a part of the size, m."""
        self.near = TOUCHES * size
        self.corners, self.normals = part.corners, part.normals
        self.levels = part.levels
        self.low, self.high = part.corners.min(axis=0), part.corners.max(axis=0)
        if part.dimension == 2:
            self.edges = [(a, b, k, k) for k, (a, b) in enumerate(part.faces)]
        else:
            self.edges = edges_between(part.faces)

    def is_near(self, ends: Array) -> bool:
        """True if the box around it reaches the one around a line."""
        low, high = ends.min(axis=0) - self.near, ends.max(axis=0) + self.near
        return bool((self.low <= high).all() and (self.high >= low).all())

    def cuts(self, ends: Array) -> Array:
        """Where a line passes its planes, as parts of its length, (k,)."""
        heights = ends @ self.normals.T - self.levels
        first, last = heights
        passes = np.abs(last - first) > self.near
        parts = first[passes] / (first - last)[passes]
        return np.asarray(parts[(parts > FULL) & (parts < 1 - FULL)])

    def around(self, place: Array) -> Array | None:
        """Normals of its planes on which a place is, (k, d), none inside; None: it is outside."""
        heights = self.normals @ place - self.levels
        if heights.max() > self.near:
            return None
        return self.normals[heights > -self.near]


def _edges_of(bodies: Sequence[_Body], number: int) -> list[tuple[Array, Array]]:
    """Edges of a part that are some of the body: ends, (2, d), and normals, (2, d)."""
    body, found = bodies[number], []
    for start, end, one, other in body.edges:
        ends, own = body.corners[[start, end]], body.normals[[one, other]]
        beside = [k for k, each in enumerate(bodies) if k != number and each.is_near(ends)]
        if not beside:
            found.append((ends, own))
            continue
        parts = np.concatenate([[0.0, 1.0], *(bodies[k].cuts(ends) for k in beside)])
        whole = ends[1] - ends[0]
        for a, b in pairwise(np.unique(parts.round(9))):
            here = ends[0] + np.array([[a], [b]]) * whole
            middle = here.mean(axis=0)
            about = {k: bodies[k].around(middle) for k in beside}
            there = {k: normals for k, normals in about.items() if normals is not None}
            # Each place once: by the first of the parts that have an edge there.
            if any(k < number and _is_edge(normals) for k, normals in there.items()):
                continue
            open_to = _opening([own, *there.values()], whole / np.linalg.norm(whole))
            if open_to is not None:
                found.append((here, open_to))
    return found


def _is_edge(normals: Array) -> bool:
    """True if planes with these normals make an edge; in the plane one is a side already."""
    if normals.shape[1] == 2:
        return len(normals) > 0
    return len(normals) > 1 and bool((np.ptp(normals, axis=0) > FULL).any())


def _opening(around: Sequence[Array], along: Array) -> Array | None:
    """Normals of the faces that bound what parts around a line leave open, (2, d).

    None where they leave nothing, or a half-space: there is no edge.

    Args:
        around: Normals of the planes of each part on which the line is, (k, d).
        along: Direction of the line, (d,); in the plane that of the side.
    """
    if len(along) == 2:
        if len(around) > 1:
            return None
        return around[0]
    across = around[0][0]
    aside = np.cross(along, across)
    planes = [np.stack([normals @ across, normals @ aside], axis=1) for normals in around]
    planes = [flat[np.linalg.norm(flat, axis=1) > 0.5] for flat in planes]
    # Only where a plane is does it change what is filled: sectors from one to the next.
    turned = np.concatenate([np.arctan2(flat[:, 1], flat[:, 0]) for flat in planes])
    begins = np.sort(np.concatenate([turned - math.pi / 2, turned + math.pi / 2]) % (2 * math.pi))
    widths = np.diff(begins, append=begins[0] + 2 * math.pi)
    begins, widths = begins[widths > FULL], widths[widths > FULL]
    middles = begins + widths / 2
    ways = np.stack([np.cos(middles), np.sin(middles)])
    is_open = ~np.any([(flat @ ways < 0).all(axis=0) for flat in planes], axis=0)
    first = np.flatnonzero(is_open & ~np.roll(is_open, 1))
    wide = float(widths[is_open].sum())
    if not len(first) or (len(first) == 1 and abs(wide - math.pi) < 1e-5):
        return None
    a = begins[first[0]]
    b = a + (wide if len(first) == 1 else 0.0)  # two bodies only touch at a line with more gaps
    turns = np.array([a + math.pi / 2, b - math.pi / 2])
    return np.asarray(np.outer(np.cos(turns), across) + np.outer(np.sin(turns), aside))
