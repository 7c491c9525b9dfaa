"""Hulls of bodies: which faces of two of them look at each other, and how far they are apart."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from solver.contact.body_points import FacePoints
from solver.types import Array, Indices


class PlacedHull(NamedTuple):
    """A convex hull where its body stands.

    Attributes:
        corners: (n, d), m; none of what has no end below its only face, such as the ground.
        normals: Outward unit normals of its faces, (faces, d).
        levels: How far the faces reach along their normals, (faces,), m.
        borders: Normals and levels of the planes through the edges of a face; None: they are those
            of the other faces.
    """

    corners: Array
    normals: Array
    levels: Array
    borders: tuple[Array, Array] | None = None


class Hull:
    """The convex hull of a body, by the points at its corners and the corners around its faces.

    A body that deforms takes its corners along: the faces are planes through what is there.
    """

    def __init__(self, points: FacePoints, faces: Sequence[Sequence[int]], is_whole: bool = True):
        """Take the points, and the corners of each face, anticlockwise from outside.

        `is_whole`: the body has all of each face, which else may have edges anywhere.
        """
        self.points = points
        self._borders = None if is_whole else (np.zeros((1, points.dimension)), np.array([-np.inf]))
        most = max(map(len, faces))
        # Its last corner again and again adds nothing to the normal of a face with fewer.
        self.faces: Indices = np.array([[*f, *f[-1:] * (most - len(f))] for f in map(list, faces)])
        """Numbers of the corners around each face, (faces, k)."""
        self.size = points.size

    def placed(self, u: Array | None) -> PlacedHull:
        """The hull for the owned unknowns of its body."""
        x = self.points.observe(u).position
        rings = x[self.faces]
        if x.shape[1] == 2:
            sides = rings[:, 1] - rings[:, 0]
            normals = np.stack([sides[:, 1], -sides[:, 0]], axis=1)
        else:  # Newell's normal of a polygon that need not be flat
            normals = np.cross(rings, np.roll(rings, -1, axis=1)).sum(axis=1)
        normals = normals / np.linalg.norm(normals, axis=1)[:, None]
        levels = np.max(np.sum(rings * normals[:, None], axis=2), axis=1)
        return PlacedHull(x, normals, levels, self._borders)


class Floor:
    """The one level face of what carries blocks and has no other that they can touch."""

    size = np.inf

    def __init__(self, points: FacePoints | None, dimension: int):
        """Take points of the face; None for the ground, at level 0."""
        self.points, self._d = points, dimension

    def placed(self, u: Array | None) -> PlacedHull:
        """The face, as high as its highest point."""
        axes, nowhere = np.eye(self._d), np.empty((0, self._d))
        along, up = axes[:-1], axes[-1:]
        if self.points is None:
            return PlacedHull(nowhere, up, np.zeros(1), (nowhere, np.empty(0)))
        x = self.points.observe(u).position
        *high, level = x.max(axis=0)
        ends = np.concatenate([high, -x.min(axis=0)[:-1]])
        return PlacedHull(nowhere, up, np.array([level]), (np.concatenate([along, -along]), ends))


def gaps(one: PlacedHull, other: PlacedHull) -> Array:
    """Distances of two hulls along the normals of the faces of both, (faces,), m."""
    return np.concatenate([_gaps(one, other), _gaps(other, one)])


def _gaps(one: PlacedHull, other: PlacedHull) -> Array:
    """Distances of the other hull from the planes of the faces of the one, (faces,), m."""
    if not len(other.corners):
        return np.full(len(one.levels), -np.inf)
    return np.asarray((other.corners @ one.normals.T).min(axis=0) - one.levels)


def depth_inside(places: Array, hull: PlacedHull, face: int) -> float:
    """How far places, (n, d), m, are within the edges of a face; infinite where it has none."""
    normals, levels = hull.borders or (
        np.delete(hull.normals, face, axis=0),
        np.delete(hull.levels, face),
    )
    return float((levels - places @ normals.T).min(initial=np.inf))


def separating_face(now: Array, ahead: Array) -> int:
    """The face along whose normal two hulls are apart, or overlap least, by its number in `gaps`.

    Of several along which they are apart it is the one along which they meet last if they move on:
    from the gaps now and after a step, m.
    """
    apart = np.flatnonzero(now > 0.0)
    if len(apart) < 2:
        return int(np.argmax(now))
    closing = now[apart] - ahead[apart]
    meets = np.where(closing > 0.0, now[apart] / np.maximum(closing, 1e-300), np.inf)
    last = np.flatnonzero(meets == meets.max())
    return int(apart[last[np.argmax(now[apart[last]])]])


def opposite_face(hull: PlacedHull, normal: Array) -> int:
    """The face of a hull that looks most against a direction."""
    return int(np.argmin(hull.normals @ normal))
