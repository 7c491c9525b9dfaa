"""Simple polygons, and the few convex pieces into which those that are not convex are cut."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from solver.types import Array, Mask

NEAR = 1e-9
"""Distance, as a part of the size, below which points are one point, or lie on a line."""

MOST = 2000
"""Corners that a polygon may have: each side is compared with each other one."""


def turn(a: Array, b: Array, c: Array) -> Array:
    """Twice the area of triangles a, b, c, (..., 2) each, m^2; positive anticlockwise."""
    return (b[..., 0] - a[..., 0]) * (c[..., 1] - a[..., 1]) - (b[..., 1] - a[..., 1]) * (
        c[..., 0] - a[..., 0]
    )


def size_of(points: Array) -> float:
    """The longest side of the box around points (n, d), m."""
    return float(np.ptp(points, axis=0).max())


def simple_polygon(points: ArrayLike, name: str = "polygon") -> Array:
    """The corners of a simple polygon, anticlockwise, (n, 2); points on a straight side left out.

    Args:
        points: (n, 2), m, in either sense; the last one is joined to the first.
        name: What errors call it.

    Raises:
        ValueError: too few or too many points, no numbers, points that are repeated, sides that
            cross or touch, no area.
    """
    corners = real_points(points, name, 2)
    if len(corners) < 3:
        raise ValueError(f"{name}: got {len(corners)} points, allowed 3 or more")
    if len(corners) > MOST:
        raise ValueError(f"{name}: got {len(corners)} points, allowed at most {MOST}")
    near = NEAR * size_of(corners)
    _refuse_repeated(corners, near, name)
    height = float(np.linalg.svd(corners - corners.mean(axis=0), compute_uv=False)[-1])
    if height <= near:
        raise ValueError(f"{name}: got points on one line, allowed an outline with an area")
    _refuse_crossing(corners, near, name)
    return without_straight(corners if area_of(corners) > 0 else corners[::-1], near)


def real_points(points: ArrayLike, name: str, *dimensions: int) -> Array:
    """Points as an array (n, d) of finite numbers; ValueError for anything else."""
    allowed = " or ".join(f"(n, {d})" for d in dimensions)
    try:
        found = np.array(points, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"{name}: got no table of numbers, allowed points {allowed}") from None
    if found.ndim != 2 or found.shape[1] not in dimensions:
        raise ValueError(f"{name}: got an array {found.shape}, allowed points {allowed}")
    bad = np.flatnonzero(~np.isfinite(found).all(axis=1))
    if len(bad):
        raise ValueError(f"{name}: got {told(found[bad[0]])} as point {bad[0]}, allowed numbers")
    return found


def told(place: Array) -> str:
    """A place in words of a message, m."""
    return "[" + ", ".join(f"{x:.6g}" for x in place) + "]"


def area_of(corners: Array) -> float:
    """Signed area of a polygon, m^2; positive anticlockwise."""
    x, y = (corners - corners.mean(axis=0)).T
    return float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) / 2


def without_straight(corners: Array, near: float) -> Array:
    """The corners where an outline turns: none that is within `near` of the line past it."""
    return corners[turning(corners, near)]


def turning(corners: Array, near: float) -> list[int]:
    """The numbers of these corners, (n, 2) or (n, 3)."""
    kept = list(range(len(corners)))
    place = 0
    while place < len(kept) and len(kept) > 3:
        before, here, after = (kept[(place + k) % len(kept)] for k in (-1, 0, 1))
        if to_segment(corners[here], corners[before], corners[after]) <= near:
            del kept[place]
            place = max(place - 1, 0)
        else:
            place += 1
    return kept


def convex_pieces(corners: Array) -> list[Array]:
    """Convex polygons that fill a simple one, anticlockwise, without new corners.

    Triangles by ear clipping, the best shaped ear first, joined over the longest diagonals where
    the corners at both ends stay convex (Hertel and Mehlhorn, Fast triangulation of simple
    polygons, 1983): at most four times as few pieces as possible, mostly as few.

    Args:
        corners: As `simple_polygon` returns them, (n, 2).
    """
    near = NEAR * size_of(corners)
    if _all_convex(corners, near):
        return [corners]
    pieces = dict(enumerate(_ears(corners)))
    owner = {pair: number for number, piece in pieces.items() for pair in around(piece)}
    lengths = {
        (start, end): float(np.linalg.norm(corners[end] - corners[start]))
        for start, end in owner
        if start < end and (end, start) in owner
    }
    for start, end in sorted(lengths, key=lambda pair: (-lengths[pair], pair)):
        first, second = owner[start, end], owner[end, start]
        joined = _joined(pieces[first], pieces[second], start, end)
        if _all_convex(corners[joined], near):
            owner |= dict.fromkeys(around(pieces.pop(second)), first)
            pieces[first] = joined
    return [without_straight(corners[piece], near) for piece in pieces.values()]


def around(loop: Sequence[int]) -> list[tuple[int, int]]:
    """The edges of a loop, each by its two ends."""
    return list(zip(loop, [*loop[1:], loop[0]], strict=True))


def _refuse_repeated(corners: Array, near: float, name: str) -> None:
    """Two points at one place; the first is not to be repeated at the end either."""
    for k in range(len(corners) - 1):
        corner: Array = corners[k]
        same = np.flatnonzero(np.abs(corners[k + 1 :] - corner).max(axis=1) <= near)
        if len(same):
            raise ValueError(
                f"{name}: got {told(corner)} as points {k} and {k + 1 + same[0]},"
                " allowed each point once, the first not again at the end"
            )


def _refuse_crossing(corners: Array, near: float, name: str) -> None:
    """Two sides that are no neighbours and meet, or neighbours that lie on one another."""
    count = len(corners)
    ends = np.roll(corners, -1, axis=0)
    for k in range(count):
        others = np.arange(k + 2, count - (k == 0))
        if len(others):
            gaps = _gaps(corners[k], ends[k], corners[others], ends[others])
            met = others[gaps <= near]
            if len(met):
                raise ValueError(
                    f"{name}: got sides {k} and {met[0]} that cross or touch, near"
                    f" {told((corners[met[0]] + ends[met[0]]) / 2)}, allowed a simple polygon"
                )
        along, back = ends[k] - corners[k], corners[k - 1] - corners[k]
        level = np.linalg.norm(along) * np.linalg.norm(back)
        across = along[0] * back[1] - along[1] * back[0]
        if along @ back > 0 and abs(across) <= NEAR * level:
            raise ValueError(
                f"{name}: got sides {(k - 1) % count} and {k} on one another, at"
                f" {told(corners[k])}, allowed a simple polygon"
            )


def _gaps(a: Array, b: Array, c: Array, d: Array) -> Array:
    """Distances of a segment a b, (2,) each, from others c d, (n, 2) each; 0 where they cross."""
    apart = np.minimum.reduce(
        [to_segment(a, c, d), to_segment(b, c, d), to_segment(c, a, b), to_segment(d, a, b)]
    )
    sides = turn(a, b, c) * turn(a, b, d), turn(c, d, a) * turn(c, d, b)
    return np.where((sides[0] < 0) & (sides[1] < 0), 0.0, apart)


def to_segment(point: Array, start: Array, end: Array) -> Array:
    """Distances of points from segments, (..., d) each, m."""
    side = end - start
    share = np.sum((point - start) * side, axis=-1) / np.sum(side * side, axis=-1)
    foot = start + np.clip(share, 0.0, 1.0)[..., None] * side
    return np.asarray(np.linalg.norm(point - foot, axis=-1))


def _turns(corners: Array) -> Array:
    """Twice the area of the triangle at each corner, (n,), m^2; negative where it is re-entrant."""
    return turn(np.roll(corners, 1, axis=0), corners, np.roll(corners, -1, axis=0))


def _all_convex(corners: Array, near: float) -> bool:
    """True if no corner is re-entrant by more than `near`."""
    reach = np.linalg.norm(np.roll(corners, -1, axis=0) - np.roll(corners, 1, axis=0), axis=1)
    return bool((_turns(corners) >= -near * reach).all())


def _ears(corners: Array) -> list[list[int]]:
    """Triangles that fill a simple polygon without straight corners, by ear clipping."""
    left = list(range(len(corners)))
    found = []
    while len(left) > 3:
        ring = corners[left]
        before, after = np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0)
        area = _turns(ring)
        longest = np.maximum.reduce(
            [
                np.sum((p - q) ** 2, axis=1)
                for p, q in ((before, ring), (ring, after), (after, before))
            ]
        )
        quality = area / longest
        reflex = ring[area <= 0]
        order = np.argsort(-quality)
        ear = next(
            (
                k
                for k in order
                if area[k] > 0 and not _any_inside(reflex, before[k], ring[k], after[k])
            ),
            order[0],  # by round-off none: the best shaped one
        )
        found.append([left[ear - 1], left[ear], left[(ear + 1) % len(left)]])
        del left[ear]
    return [*found, left]


def _any_inside(points: Array, a: Array, b: Array, c: Array) -> bool:
    """True if a point other than the corners lies in a triangle or on its edges."""
    inside: Mask = (turn(a, b, points) >= 0) & (turn(b, c, points) >= 0) & (turn(c, a, points) >= 0)
    for corner in (a, b, c):
        inside &= (points != corner).any(axis=1)
    return bool(inside.any())


def _joined(first: list[int], second: list[int], start: int, end: int) -> list[int]:
    """Two loops as one, without the edge start -> end of the first, end -> start of the second."""
    cut, other = first.index(end), second.index(start)
    return [*first[cut:], *first[:cut], *[*second[other:], *second[:other]][1:-1]]
