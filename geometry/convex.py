"""Convex polygons and polyhedra of uniform density, and the convex hull of points."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from geometry.moments import Moments, changed, moments_of
from geometry.polygon import around, real_points, size_of, told, turning
from solver.types import Array, Indices

FLAT = 1e-5
"""How far, as a part of the size, a corner may be off the plane of its face or above another."""

Faces = tuple[tuple[int, ...], ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Convex:
    """A convex polygon (d = 2) or polyhedron (d = 3) of uniform density.

    Raises:
        ValueError: of what is no such shape: corners that are no numbers, faces that do not close
            it, are not flat, are seen clockwise from outside, or do not make it convex.
    """

    corners: Array
    """Corners, (n, d), m; those of a polygon anticlockwise. Not to be written to."""
    faces: Faces
    """Numbers of the corners around each face, anticlockwise seen from outside, each pair of faces
    in different planes; of a polygon its edges (0, 1), (1, 2), ..."""
    density: float
    """rho, kg/m^3, > 0."""
    moments: Moments = field(init=False)
    """Volume, centre and second moments without the density; of a polygon those of its area."""

    def __post_init__(self) -> None:
        """Refuse what is not convex, and integrate."""
        refuse_density(self.density, "Convex.density")
        corners = real_points(self.corners, "Convex.corners", 2, 3)
        faces = tuple(tuple(int(k) for k in face) for face in self.faces)
        size = size_of(corners)
        if not size > 0:
            raise ValueError("Convex.corners: got one place, allowed corners of a convex shape")
        _check(corners, faces, size)
        facets = np.array(faces) if corners.shape[1] == 2 else triangles_of(faces)
        moments = moments_of(corners, facets)
        if not moments.volume > 0:
            raise ValueError(
                f"Convex: got the volume {moments.volume:.3g}, allowed > 0, faces outwards"
            )
        corners.setflags(write=False)
        for name, value in (("corners", corners), ("faces", faces), ("moments", moments)):
            object.__setattr__(self, name, value)

    @property
    def dimension(self) -> int:
        """2 in the plane, 3 in space."""
        return self.corners.shape[1]

    @property
    def normals(self) -> Array:
        """Outward unit normals of the faces, (faces, d)."""
        return normals_of(self.corners, self.faces)

    @property
    def starts(self) -> Array:
        """A corner of each face, (faces, d), m."""
        return np.asarray(self.corners[[face[0] for face in self.faces]])

    @property
    def levels(self) -> Array:
        """Distances of the planes of the faces from the origin along their normals, (faces,), m."""
        return np.asarray(np.einsum("ni,ni->n", self.starts, self.normals))

    @property
    def lowest_face(self) -> int:
        """Number of the face that looks most downwards, of equal ones the first."""
        return int(np.argmin(np.round(self.normals[:, -1], 9)))

    @property
    def shortest_edge(self) -> float:
        """Length of the shortest edge, m."""
        rings = [self.corners[list(face)] for face in self.faces]
        edges = [np.linalg.norm(ring - np.roll(ring, 1, axis=0), axis=1).min() for ring in rings]
        return float(min(edges))

    def area(self, face: int) -> float:
        """Area of a face, m^2; the length of a polygon's side, m."""
        ring = self.corners[list(self.faces[face])]
        if self.dimension == 2:
            return float(np.linalg.norm(ring[1] - ring[0]))
        spokes = ring - ring[0]
        return float(np.linalg.norm(np.cross(spokes, np.roll(spokes, -1, axis=0)).sum(axis=0)) / 2)

    def beyond(self, places: Array) -> Array:
        """How far places (n, d) are beyond the faces, of all faces the most, m; below 0 inside."""
        return np.asarray((places @ self.normals.T - self.levels).max(axis=1))

    def moved(self, by: ArrayLike) -> Convex:
        """This shape moved by a vector (d,), m."""
        step = np.asarray(by, dtype=np.float64)
        return changed(self, corners=self.corners + step, moments=self.moments.moved(step))

    def rotated(self, rotation: Array) -> Convex:
        """This shape turned about the origin by a rotation matrix (d, d)."""
        corners = self.corners @ rotation.T
        return changed(self, corners=corners, moments=self.moments.rotated(rotation))

    def with_density(self, density: float) -> Convex:
        """This shape with another density, kg/m^3."""
        refuse_density(density, "Convex.density")
        return changed(self, density=density)


def refuse_density(density: float | None, name: str) -> None:
    """ValueError for what is no density."""
    if density is None or not (math.isfinite(density) and density > 0):
        raise ValueError(f"{name}: got {density}, allowed a number > 0, kg/m3")


def polygon_faces(count: int) -> Faces:
    """The faces of a polygon with so many corners: its edges."""
    return tuple(around(range(count)))


def edges_between(faces: Faces) -> list[tuple[int, int, int, int]]:
    """The edges of a closed body in space: their ends, and the numbers of the faces beside them."""
    owner: dict[tuple[int, int], int] = {}
    found = []
    for number, face in enumerate(faces):
        for start, end in around(face):
            if (other := owner.pop((end, start), None)) is None:
                owner[start, end] = number
            else:
                found.append((start, end, number, other))
    return found


def loops_of(parts: Sequence[Convex]) -> Faces:
    """The faces of parts by the numbers of all corners, part after part; in the plane the parts."""
    found, first = list[tuple[int, ...]](), 0
    for part in parts:
        count = len(part.corners)
        loops = part.faces if part.dimension == 3 else (tuple(range(count)),)
        found += [tuple(first + k for k in loop) for loop in loops]
        first += count
    return tuple(found)


def triangles_of(faces: Sequence[Sequence[int] | Indices]) -> Indices:
    """The faces of a polyhedron as triangles, fans about their first corners, (m, 3)."""
    fans = [(face[0], face[k - 1], face[k]) for face in faces for k in range(2, len(face))]
    return np.array(fans, dtype=np.int64).reshape(-1, 3)


def normals_of(corners: Array, faces: Sequence[Sequence[int]] | Indices) -> Array:
    """Outward unit normals of faces by Newell's formula, (faces, d)."""
    normals = np.zeros((len(faces), corners.shape[1]))
    for numbers, loops in _by_length(faces):
        rings = corners[loops]
        if corners.shape[1] == 2:
            ways = rings[:, 1] - rings[:, 0]
            normals[numbers] = np.stack([ways[:, 1], -ways[:, 0]], axis=1)
        else:
            rings = rings - rings[:, :1]
            normals[numbers] = np.cross(rings, np.roll(rings, -1, axis=1)).sum(axis=1)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.asarray(normals / np.where(lengths > 0, lengths, 1.0))


def _by_length(faces: Sequence[Sequence[int]] | Indices) -> Iterator[tuple[Indices, Indices]]:
    """Faces with as many corners together: their numbers, (m,), and their corners, (m, k)."""
    if isinstance(faces, np.ndarray):
        yield np.arange(len(faces)), faces
        return
    lengths = np.array([len(face) for face in faces])
    for length in np.unique(lengths):
        numbers = np.flatnonzero(lengths == length)
        yield numbers, np.array([faces[k] for k in numbers], dtype=np.int64)


def hull_of(points: ArrayLike, tolerance: float, name: str = "hull") -> tuple[Array, Faces]:
    """Corners and faces of the convex hull of points, by Qhull.

    In space a face is what lies within `tolerance` of the plane of its largest triangle; points in
    the midst of a face, or of a straight edge, are no corners.

    Args:
        points: (n, d), m.
        tolerance: As a part of the size; 1e-6 for numbers of single precision, such as in STL.
        name: What errors call it.

    Raises:
        ValueError: points that are no numbers, or on one line or in one plane.
    """
    from scipy.spatial import ConvexHull, QhullError  # slow to import

    given = real_points(points, name, 2, 3)
    dimension = given.shape[1]
    size = size_of(given) if len(given) else 0.0
    flat = "one line" if dimension == 2 else "one plane"
    trouble = ValueError(f"{name}: got {len(given)} points, all in {flat}, allowed others as well")
    if len(given) <= dimension or not size > 0:
        raise trouble
    origin = (given.max(axis=0) + given.min(axis=0)) / 2
    scaled = (given - origin) / size
    if np.linalg.svd(scaled, compute_uv=False)[-1] <= 1e-9 * math.sqrt(len(given)):
        raise trouble
    try:
        found = ConvexHull(scaled)
    except QhullError:
        raise trouble from None
    if dimension == 2:
        ring = [int(k) for k in found.vertices]
        numbers = [ring[k] for k in turning(scaled[ring], tolerance)]
        return given[numbers], polygon_faces(len(numbers))
    triangles = np.array(found.simplices, dtype=np.int64)
    a, b, c = (scaled[triangles[:, k]] for k in range(3))
    inward = np.einsum("ni,ni->n", np.cross(b - a, c - a), found.equations[:, :3]) < 0
    triangles[inward] = triangles[inward][:, [0, 2, 1]]
    faces = _merged(scaled, triangles, tolerance)
    numbers = sorted({k for face in faces for k in face})
    place = {number: k for k, number in enumerate(numbers)}
    return given[numbers], tuple(tuple(place[k] for k in face) for face in faces)


def few_corners(points: Array, tolerance: float) -> Array:
    """Some of many points, (n, d), m: no other one is farther than a distance (m) off their hull.

    Qhull (Barber, Dobkin and Huhdanpaa, ACM Trans. Math. Softw. 22, 1996) takes the farthest point
    over each facet in turn, and ends where all are as near as that (its option W).
    """
    from scipy.spatial import ConvexHull, QhullError  # slow to import

    size = size_of(points)
    try:
        found = ConvexHull(
            (points - points.mean(axis=0)) / size, qhull_options=f"Qt W{tolerance / size:.3e}"
        )
    except (QhullError, ValueError):  # all in one plane, or the like: `hull_of` says so
        return points
    return points[np.sort(found.vertices)]


def _merged(points: Array, triangles: Indices, tolerance: float) -> list[list[int]]:
    """Loops around the flat faces of a convex hull of triangles, without corners on straight edges.

    The largest triangle that is left begins a face; the face grows over edges to triangles whose
    corners are all within the tolerance of its plane. So a sliver, whose own normal is round-off,
    goes to the face beside it.
    """
    corners = [[int(k) for k in tri] for tri in triangles]
    across = {
        (tri[k], tri[(k + 1) % 3]): number for number, tri in enumerate(corners) for k in range(3)
    }
    a, b, c = (points[triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    areas = np.linalg.norm(normals, axis=1)
    taken = np.full(len(triangles), -1)
    loops: list[list[int]] = []
    for seed in map(int, np.argsort(-areas, kind="stable")):
        if taken[seed] >= 0:
            continue
        normal = normals[seed] / areas[seed] if areas[seed] > 0 else np.zeros(3)
        number, region, waiting = len(loops), [seed], [seed]
        taken[seed] = number
        while waiting:
            tri = corners[waiting.pop()]
            for k in range(3):
                beside = across[tri[(k + 1) % 3], tri[k]]
                if taken[beside] >= 0:
                    continue
                off = (points[triangles[beside]] - points[triangles[seed][0]]) @ normal
                # Not over the edge of a body so thin that its other side is as near.
                if (
                    np.abs(off).max() <= tolerance
                    and normals[beside] @ normal >= -areas[beside] / 2
                ):
                    taken[beside] = number
                    region.append(beside)
                    waiting.append(beside)
        loop = _outline(triangles[region])
        if loop is None:  # not one ring: the triangles stay as they are
            taken[region[1:]] = -2
            loops.append(corners[seed])
            for other in region[1:]:
                taken[other] = len(loops)
                loops.append(corners[other])
        else:
            loops.append(loop)
    straight = _without_straight_edges(points, loops)
    if min(len(loop) for loop in straight) > 2:
        return _begun_well(points, straight)
    return corners


def _outline(triangles: Indices) -> list[int] | None:
    """The one loop around a region of triangles; None if it is not one, or passes a point twice."""
    edges = {(int(tri[k]), int(tri[(k + 1) % 3])) for tri in triangles for k in range(3)}
    following = {start: end for start, end in edges if (end, start) not in edges}
    rim = sum((end, start) not in edges for start, end in edges)
    start = min(following)
    loop, here = [start], following[start]
    while here != start and len(loop) <= rim:
        loop.append(here)
        here = following[here]
    return loop if len(loop) == rim == len(following) else None


def _without_straight_edges(points: Array, loops: list[list[int]]) -> list[list[int]]:
    """Loops without corners that only two faces have: there nothing but a straight edge passes."""
    faces_at: dict[int, int] = {}
    for loop in loops:
        for corner in loop:
            faces_at[corner] = faces_at.get(corner, 0) + 1
    return [[corner for corner in loop if faces_at[corner] > 2] for loop in loops]


def _begun_well(points: Array, loops: list[list[int]]) -> list[list[int]]:
    """Loops of corners, each begun where its first three corners give its plane best."""
    found: list[list[int]] = [[]] * len(loops)
    for numbers, corners in _by_length(loops):
        rings = points[corners]
        first, second = (np.roll(rings, -k, axis=1) - rings for k in (1, 2))
        areas = np.round(np.linalg.norm(np.cross(first, second), axis=2), 9)
        for number, best in zip(numbers, np.argmax(areas, axis=1), strict=True):
            found[number] = [*loops[number][best:], *loops[number][:best]]
    return found


def _check(corners: Array, faces: Faces, size: float) -> None:
    """Faces that are flat, close the body, and bend inwards where two meet.

    Convex at each edge, and closed like a ball, is convex (Tietze and Nakajima).
    """
    if corners.shape[1] == 2:
        closed = len(corners) > 2 and faces == polygon_faces(len(corners))
        beside = around(range(len(faces)))
    else:
        edges = edges_between(faces)
        closed = 2 * len(edges) == sum(map(len, faces))
        closed = closed and len(corners) - len(edges) + len(faces) == 2  # Euler
        beside = [(one, other) for *_, one, other in edges]
    if not closed:
        raise ValueError("Convex.faces: got an open surface, allowed a closed body, anticlockwise")
    normals = normals_of(corners, faces)
    levels = np.einsum("ni,ni->n", corners[[face[0] for face in faces]], normals)
    own = [(k, k) for k in range(len(faces))]
    pairs = [*own, *beside, *((other, one) for one, other in beside)]
    lower = np.concatenate([faces[other] for _, other in pairs])
    upper = np.repeat([one for one, _ in pairs], [len(faces[other]) for _, other in pairs])
    heights = np.einsum("ni,ni->n", corners[lower], normals[upper]) - levels[upper]
    flat = sum(map(len, faces))
    heights[:flat] = np.abs(heights[:flat])
    worst = int(np.argmax(heights))
    if heights[worst] > FLAT * size or not normals.any(axis=1).all():
        raise ValueError(
            f"Convex.corners: got {told(corners[lower[worst]])}, {heights[worst]:.3g} m off the"
            " plane of a face, allowed a convex body, faces flat and anticlockwise from outside"
        )
