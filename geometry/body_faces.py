"""The faces of a body that contact sees: those of a convex one, or of the convex hull of another.

A face of a hull may span a hollow, or lie on the body in several places, such as below its feet.
On a mesh, facets have tags by the faces to which they belong.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from geometry.block import FACES, Block
from geometry.convex import Convex, Faces, hull_of, normals_of
from geometry.polygon import size_of
from geometry.tags import FacetTag, tags_of_faces
from solver.types import Array, Indices, Mask

Loops: TypeAlias = dict[int, tuple[int, ...]]
"""Numbers of the corners around faces, by the tags of these."""

IN_PLANE = 2e-6
"""Distance, as a part of the size, below which a facet is in the plane of a face: twice that by
which corners of the face may be off it."""

ALIKE = 0.9
"""Cosine between the normals of a facet and of a face above which it may be part of it."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BodyFaces:
    """Faces of a convex body, or of the convex hull of one, in the frame of the body."""

    corners: Array
    """Corners, (n, d), m."""
    loops: Loops
    """By the tag of each face, the numbers of the corners around it, anticlockwise from outside;
    tags are those of `tags_of_faces`, or of `FacetTag`."""
    facets: dict[int, frozenset[int]]
    """Tags of the facets of the mesh that are in the plane of each face: none where it spans a
    hollow. Without a mesh the tags of the faces themselves."""
    points: dict[int, frozenset[int]]
    """Tags of the facets whose points touch with each face: those in its plane, or at its corners
    where it spans a hollow."""
    patches: dict[int, tuple[Array, ...]]
    """Corners around the places where the body has each face, (n, d), m; of a face that is whole
    those of the face. Only of bodies without a mesh; else empty."""
    is_whole: bool = True
    """True if the body has all of each face."""

    def moved(self, by: Array) -> BodyFaces:
        """The faces of the body moved by a vector (d,), m."""
        patches = {tag: tuple(ring + by for ring in some) for tag, some in self.patches.items()}
        return replace(self, corners=self.corners + by, patches=patches)

    def ring(self, tag: int) -> Array:
        """Corners around a face, (n, d), m."""
        return np.asarray(self.corners[list(self.loops[tag])])


def faces_of_block(block: Block, dimension: int) -> list[BodyFaces]:
    """Faces of the hull of a block without a mesh, or with that of a convex one, and of its parts.

    No parts of what is convex.
    """
    if block.solid is None:
        return [faces_of_box(np.array(block.corners(dimension)))]
    parts = block.solid.parts
    if len(parts) == 1:
        return [faces_of_convex(parts[0])]
    return [faces_of_hull(parts), *map(faces_of_convex, parts)]


def faces_of_box(corners: Array) -> BodyFaces:
    """Faces of a box by its corners in the order of `Block.corners`, with the tags of its mesh."""
    if corners.shape[1] == 2:
        order = FacetTag.BOTTOM, FacetTag.RIGHT, FacetTag.TOP, FacetTag.LEFT
        loops: Loops = {int(tag): (k, (k + 1) % 4) for k, tag in enumerate(order)}
    else:
        sides = FacetTag.FRONT, FacetTag.RIGHT, FacetTag.BACK, FacetTag.LEFT
        named = (FacetTag.BOTTOM, FacetTag.TOP, *sides)
        loops = {int(tag): face for tag, face in zip(named, FACES, strict=True)}
    return _whole(corners, loops)


def faces_of_convex(part: Convex) -> BodyFaces:
    """Faces of a convex body, with the tags of its mesh."""
    return _whole(part.corners, _tagged(part.corners, part.faces))


def _whole(corners: Array, loops: Loops) -> BodyFaces:
    """Faces that a body has as a whole."""
    own = {tag: frozenset({tag}) for tag in loops}
    patches: dict[int, tuple[Array, ...]] = {
        tag: (corners[list(loop)],) for tag, loop in loops.items()
    }
    return BodyFaces(corners=corners, loops=loops, facets=own, points=own, patches=patches)


def _tagged(corners: Array, faces: Faces) -> Loops:
    """Faces by their tags."""
    rises = normals_of(corners, faces)[:, -1]
    return dict(zip(tags_of_faces([float(rise) for rise in rises]), faces, strict=True))


def faces_of_hull(parts: Sequence[Convex]) -> BodyFaces:
    """Faces of the hull of a body of convex parts, without a mesh."""
    places = np.unique(np.concatenate([part.corners for part in parts]), axis=0)
    corners, faces = hull_of(places, IN_PLANE / 2)
    loops, size = _tagged(corners, faces), size_of(places)
    found: dict[int, tuple[Array, ...]] = {}
    for tag, loop in loops.items():
        normal, level = _plane(corners, loop)
        rings = [
            part.corners[list(face)]
            for part in parts
            for face, own in zip(part.faces, part.normals, strict=True)
            if own @ normal > ALIKE
            and np.abs(part.corners[list(face)] @ normal - level).max() <= IN_PLANE * size
        ]
        found[tag] = tuple(rings)
    own = {tag: frozenset({tag} if found[tag] else ()) for tag in loops}
    points = {tag: frozenset({tag}) for tag in loops}
    return BodyFaces(
        corners=corners, loops=loops, facets=own, points=points, patches=found, is_whole=False
    )


def _plane(corners: Array, loop: Sequence[int]) -> tuple[Array, float]:
    """Outward unit normal of a face, (d,), and its level along that, m."""
    (normal,) = normals_of(corners, (tuple(loop),))
    return normal, float((corners[list(loop)] @ normal).mean())


def faces_on_mesh(
    points: Array, boundary: Indices, parts: Sequence[Convex]
) -> tuple[list[BodyFaces], Indices]:
    """Faces of the hull of a meshed body, and of each of its parts; tags of its facets.

    Args:
        points: Nodes of the mesh, (n, d), m.
        boundary: Nodes of its facets, (m, k), anticlockwise seen from outside.
        parts: The convex parts of which it is made; none where they are not known.
    """
    used = points[np.unique(boundary)]
    size = size_of(used)
    corners, faces = hull_of(used, IN_PLANE / 2)
    hulls = [(corners, _tagged(corners, faces))]
    hulls += [(part.corners, _tagged(part.corners, part.faces)) for part in parts]
    places, across = points[boundary], normals_of(points, boundary)
    members: list[set[tuple[int, int]]] = [set() for _ in boundary]
    flat: set[tuple[int, int]] = set()
    for number, (own, loops) in enumerate(hulls):
        near: Mask = np.ones(len(boundary), dtype=np.bool_)
        if number:
            near = parts[number - 1].beyond(places.mean(axis=1)) <= IN_PLANE * size
        for tag, loop in loops.items():
            normal, level = _plane(own, loop)
            on = near & (across @ normal > ALIKE)
            on[on] = np.abs(places[on] @ normal - level).max(axis=1) <= IN_PLANE * size
            if on.any():
                flat.add((number, tag))
            for facet in np.flatnonzero(on):
                members[facet].add((number, tag))
    _add_at_corners(members, flat, places, hulls[0], size)
    kinds = {key: k for k, key in enumerate(sorted({tuple(sorted(m)) for m in members}), start=1)}
    tags = np.array([kinds[tuple(sorted(each))] for each in members], dtype=np.int64)
    found = []
    for number, (own, loops) in enumerate(hulls):
        at = {
            tag: frozenset(kind for key, kind in kinds.items() if (number, tag) in key)
            for tag in loops
        }
        real = {tag: at[tag] if (number, tag) in flat else frozenset[int]() for tag in loops}
        found.append(
            BodyFaces(corners=own, loops=loops, facets=real, points=at, patches={}, is_whole=False)
        )
    return found, tags


def _add_at_corners(
    members: list[set[tuple[int, int]]],
    flat: set[tuple[int, int]],
    places: Array,
    hull: tuple[Array, Loops],
    size: float,
) -> None:
    """Let facets at the corners of faces of the hull that span a hollow belong to these."""
    from scipy.spatial import cKDTree

    corners, loops = hull
    around: dict[int, list[int]] = {}
    for tag, loop in loops.items():
        if (0, tag) not in flat:
            for corner in loop:
                around.setdefault(corner, []).append(tag)
    if not around:
        return
    count, k, d = places.shape
    off, which = cKDTree(corners).query(places.reshape(-1, d))
    at = np.where(off <= IN_PLANE * size, which, -1).reshape(count, k)
    for facet, vertex in zip(*np.nonzero(at >= 0), strict=True):
        members[facet].update((0, tag) for tag in around.get(int(at[facet, vertex]), ()))
