"""Closed surfaces of triangles, which say what a body of any shape weighs."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from geometry.moments import Moments, changed, moments_of
from geometry.polygon import real_points, size_of, told
from solver.types import Array, Indices

MOST = 1_000_000
"""Facets that a surface may have."""

SKIN = 1e-6
"""Depth, as a part of the size, below which two shells touch and do not overlap."""

SAME = 1e-9
"""Distance, as a part of the size, below which two points are one."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Surface:
    """A closed surface of triangles, anticlockwise seen from outside.

    It may have several shells: beside one another, or a cavity within a shell. Facets that
    are all turned round enclose a negative volume and are turned, each outermost shell with what it
    holds. That a shell does not pass through itself is not looked at.

    Raises:
        ValueError: of what encloses no volume: edges that are open, facets some of which are turned
            round, shells that overlap, no facets or more than 10^6, points that are no numbers.
    """

    points: Array
    """Points, (n, 3), m. Not to be written to."""
    triangles: Indices
    """Numbers of points, (m, 3)."""
    name: str = "surface"
    """What errors call it, such as the path of its file."""
    moments: Moments = field(init=False)
    """Volume, centre and second moments of what it encloses."""

    def __post_init__(self) -> None:
        """Refuse what is not closed, turn what is inside out, and integrate."""
        points = real_points(self.points, self.name, 3)
        triangles = np.array(self.triangles, dtype=np.int64)
        if triangles.size == 0:
            raise ValueError(f"{self.name}: got no facets, allowed a closed surface")
        if triangles.ndim != 2 or triangles.shape[1] != 3:
            raise ValueError(f"{self.name}: got facets {triangles.shape}, allowed (m, 3)")
        refuse_too_many(len(triangles), self.name)
        if triangles.min() < 0 or triangles.max() >= len(points):
            raise ValueError(
                f"{self.name}: got facets with points {triangles.min()} to {triangles.max()},"
                f" allowed 0 to {len(points) - 1}"
            )
        _refuse_open(points, triangles, self.name)
        triangles = _outward(points, triangles, self.name)
        moments = moments_of(points, triangles)
        size = size_of(points[np.unique(triangles)])
        if not moments.volume > 1e-12 * size**3:
            raise ValueError(
                f"{self.name}: got the volume {moments.volume:.3g} m3, allowed a body with one"
            )
        points.setflags(write=False)
        triangles.setflags(write=False)
        for name, value in (("points", points), ("triangles", triangles), ("moments", moments)):
            object.__setattr__(self, name, value)

    @property
    def volume(self) -> float:
        """What it encloses, m^3."""
        return self.moments.volume

    @property
    def bodies(self) -> int:
        """How many bodies it bounds: its shells but for cavities."""
        label, count = _shells(len(self.points), self.triangles)
        shells = (self.triangles[label == k] for k in range(count))
        return sum(moments_of(self.points, shell).volume > 0 for shell in shells)

    @property
    def area(self) -> float:
        """Area of the facets, m^2."""
        a, b, c = (self.points[self.triangles[:, k]] for k in range(3))
        return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)

    def is_near(self, place: Array, reach: float) -> bool:
        """True if a place (3,) is within, or a way of `reach` (m) along an axis leads there."""
        ways = reach * np.concatenate([np.zeros((1, 3)), np.eye(3), -np.eye(3)])
        corners = self.points[self.triangles]
        return any(_times_round(corners - place - way) > 0.5 for way in ways)

    def moved(self, by: ArrayLike) -> Surface:
        """This surface moved by a vector (3,), m."""
        step = np.asarray(by, dtype=np.float64)
        return changed(self, points=self.points + step, moments=self.moments.moved(step))

    def rotated(self, rotation: Array) -> Surface:
        """This surface turned about the origin by a rotation matrix (3, 3)."""
        points = self.points @ rotation.T
        return changed(self, points=points, moments=self.moments.rotated(rotation))


def refuse_too_many(count: int, name: str) -> None:
    """ValueError for more facets than a surface may have."""
    if count > MOST:
        raise ValueError(
            f"{name}: got {count} facets, allowed at most {MOST}; make it coarser first"
        )


def merged(points: Array, triangles: Indices) -> tuple[Array, Indices]:
    """Points that are one place as one, and facets without those that have lost a corner by it.

    Exact duplicates first, then those within `SAME` of the size; points of no facet are left out.
    """
    points, place = _distinct(points)
    triangles = place[triangles]
    points, triangles = _close_ones(points, triangles)
    a, b, c = triangles.T
    triangles = triangles[(a != b) & (b != c) & (c != a)]
    used, place = np.unique(triangles, return_inverse=True)
    return points[used], place.reshape(-1, 3).astype(np.int64)


def _distinct(points: Array) -> tuple[Array, Indices]:
    """Points without repetition, sorted, and the number of each one there.

    As `numpy.unique` along an axis, which takes five times as long.
    """
    points = points + 0.0  # no -0.0
    order = np.lexsort(points.T[::-1])
    sorted_points = points[order]
    is_new = np.append(True, (sorted_points[1:] != sorted_points[:-1]).any(axis=1))
    place = np.empty(len(points), dtype=np.int64)
    place[order] = np.cumsum(is_new) - 1
    return sorted_points[is_new], place


def _close_ones(points: Array, triangles: Indices) -> tuple[Array, Indices]:
    """Points within `SAME` of the size of one another joined, in chains where they are one."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    if len(points) < 2:
        return points, triangles
    pairs = cKDTree(points).query_pairs(SAME * size_of(points), output_type="ndarray")
    if not len(pairs):
        return points, triangles
    links = coo_array((np.ones(len(pairs)), pairs.T), shape=(len(points), len(points)))
    _, label = connected_components(links, directed=False)
    _, first, place = np.unique(label, return_index=True, return_inverse=True)
    return points[first], place.reshape(-1)[triangles]


def _refuse_open(points: Array, triangles: Indices, name: str) -> None:
    """Each edge has as many facets on its one side as on its other; else open, or turned round."""
    starts = triangles.reshape(-1)
    ends = triangles[:, [1, 2, 0]].reshape(-1)
    if (starts == ends).any():
        facet = int(np.flatnonzero(starts == ends)[0]) // 3
        raise ValueError(f"{name}: got facet {facet} with a point twice, allowed triangles")
    count = len(points)
    keys, place, uses = np.unique(
        np.minimum(starts, ends) * count + np.maximum(starts, ends),
        return_inverse=True,
        return_counts=True,
    )
    sense = np.bincount(place.reshape(-1), weights=np.where(starts < ends, 1, -1))
    middles = (points[keys // count] + points[keys % count]) / 2
    unpaired = uses % 2 == 1
    if unpaired.any():
        raise ValueError(
            f"{name}: got {int(unpaired.sum())} open edges, one at"
            f" {told(middles[np.argmax(unpaired)])}, allowed a closed surface"
        )
    wrong = sense != 0
    if wrong.any():
        raise ValueError(
            f"{name}: got facets turned round beside {int(wrong.sum())} edges, one at"
            f" {told(middles[np.argmax(wrong)])}, allowed all anticlockwise seen from outside"
        )


def _outward(points: Array, triangles: Indices, name: str) -> Indices:
    """Facets with the body on their inner side: shells that are inside out are turned round."""
    label, count = _shells(len(points), triangles)
    shells = [triangles[label == k] for k in range(count)]
    sign = np.array([np.sign(moments_of(points, shell).volume) for shell in shells])
    if count == 1:
        return triangles if sign[0] >= 0 else triangles[:, [0, 2, 1]]
    around = _holders(points, shells, name)
    turned = triangles.copy()
    for k in range(count):
        # Of the shells around this one, each holds the next: as many as there are say how deep.
        outermost = min((*around[k], k), key=lambda n: len(around[n]))
        as_is = sign[k] * sign[outermost] * (-1) ** len(around[k])
        if as_is < 0:
            raise ValueError(
                f"{name}: got a shell within another, at {told(points[shells[k][0, 0]])}, that"
                " overlaps it, allowed shells apart, or cavities with facets turned inwards"
            )
        if sign[outermost] < 0:
            mine = label == k
            turned[mine] = turned[mine][:, [0, 2, 1]]
    return turned


def _shells(count: int, triangles: Indices) -> tuple[Indices, int]:
    """Number of the shell of each facet, and how many there are: facets that share points."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    starts, ends = triangles[:, [0, 1]].reshape(-1), triangles[:, [1, 2]].reshape(-1)
    links = coo_array((np.ones(len(starts)), (starts, ends)), shape=(count, count))
    _, label = connected_components(links, directed=False)
    _, of_facet = np.unique(label[triangles[:, 0]], return_inverse=True)
    return of_facet.reshape(-1).astype(np.int64), int(of_facet.max()) + 1


def _holders(points: Array, shells: list[Indices], name: str) -> list[set[int]]:
    """Numbers of the shells around each one; ValueError where two of them cross."""
    low = np.array([points[shell].min(axis=(0, 1)) for shell in shells])
    high = np.array([points[shell].max(axis=(0, 1)) for shell in shells])
    around: list[set[int]] = [set() for _ in shells]
    for k in range(len(shells)):
        near = np.flatnonzero(((low <= high[k]) & (high >= low[k])).all(axis=1))
        for other in near[near > k]:
            if _cross(points, shells[k], shells[other]):
                common = np.stack(
                    [np.maximum(low[k], low[other]), np.minimum(high[k], high[other])]
                )
                raise ValueError(
                    f"{name}: got two shells that overlap, near {told(common.mean(axis=0))},"
                    " allowed shells apart; unite them first"
                )
            if _holds(points, shells[k], shells[other]):
                around[other].add(k)
            elif _holds(points, shells[other], shells[k]):
                around[k].add(int(other))
    return around


def _cross(points: Array, first: Indices, second: Indices) -> bool:
    """True if a shell passes through another one by more than the skin, by VTK's trees of boxes."""
    from vtkmodules.vtkCommonMath import vtkMatrix4x4
    from vtkmodules.vtkFiltersModeling import vtkCollisionDetectionFilter

    used = points[np.concatenate([first, second]).reshape(-1)]
    skin = SKIN * size_of(used)
    search = vtkCollisionDetectionFilter()
    search.SetInputData(0, poly_data(_inset(points, first, skin), first))
    search.SetInputData(1, poly_data(_inset(points, second, skin), second))
    for place in (0, 1):
        search.SetMatrix(place, vtkMatrix4x4())
    search.SetBoxTolerance(0.0)
    search.SetCellTolerance(0.0)
    search.SetCollisionModeToFirstContact()
    search.Update()
    return bool(search.GetNumberOfContacts() > 0)


def _inset(points: Array, triangles: Indices, depth: float) -> Array:
    """Points with those of a shell moved into it by a depth, m."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    normals = np.zeros_like(points)
    for k in range(3):
        np.add.at(normals, triangles[:, k], across)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    sign = np.sign(moments_of(points, triangles).volume)
    return np.asarray(points - sign * depth * normals / np.where(lengths > 0, lengths, 1.0))


def _holds(points: Array, outer: Indices, inner: Indices) -> bool:
    """True if a shell that does not cross another is within it, by the most decided of some points.

    The solid angle under which the outer one is seen: van Oosterom and Strackee, IEEE Trans.
    Biomed. Eng. 30, 1983.
    """
    numbers = np.unique(inner)
    # A little within the inner one: on the outer one itself, where they touch, anything comes out.
    inset = _inset(points, inner, SKIN * size_of(points[numbers]))
    some = inset[numbers[:: max(1, len(numbers) // 16)]]
    turns = np.array([_times_round(points[outer] - place) for place in some])
    best = turns[np.argmin(np.abs(turns - np.round(turns)))]
    return bool(round(abs(float(best))) == 1)


def _times_round(corners: Array) -> float:
    """How often triangles (m, 3, 3) go round the origin: 1 if it is within, 0 if without."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    ab, bc, ca = (np.einsum("ni,ni->n", *pair) for pair in ((a, b), (b, c), (c, a)))
    below = la * lb * lc + ab * lc + bc * la + ca * lb
    return float(np.arctan2(np.einsum("ni,ni->n", a, np.cross(b, c)), below).sum()) / (2 * np.pi)


def poly_data(points: Array, triangles: Indices) -> Any:
    """A surface as VTK has it, `pyvista.PolyData`."""
    import pyvista

    cells = np.column_stack([np.full(len(triangles), 3), triangles]).reshape(-1)
    return pyvista.PolyData(np.ascontiguousarray(points, dtype=np.float64), cells)
