"""How deep convex bodies are in one another, and how far one may go down to another."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from geometry.convex import Convex
from geometry.polygon import size_of
from solver.types import Array

BRUSHES = 1e-6
"""Distance, as a part of the size, by which two bodies have at least to be in one another for one
to stop the other as it goes down."""


def common_depth(first: Sequence[Convex], second: Sequence[Convex]) -> float:
    """Diameter of the largest ball in a part of both of two bodies, m; 0 if there is none."""
    return max(
        (max(2 * radius, 0.0) for radius, _ in common_balls(first, second, 0.0)), default=0.0
    )


def descent(upper: Sequence[Convex], lower: Sequence[Convex]) -> float:
    """How far a body may go down before it touches another one, m.

    Infinite if it misses that; below 0 where it is in it, or below it.

    Args:
        upper: Parts of the body that goes down.
        lower: Parts of the other one.
    """
    pairs = sorted(
        (float(one.corners[:, -1].min() - other.corners[:, -1].max()), k, j)
        for k, one in enumerate(upper)
        for j, other in enumerate(lower)
        if not _misses(one, other)
    )
    best = np.inf
    for least, k, j in pairs:
        if least >= best:
            break
        best = min(best, _descent_of_part(upper[k], lower[j]))
    return best


def _misses(one: Convex, other: Convex) -> bool:
    """True if the boxes around two parts have nothing in common seen from above."""
    low = np.maximum(one.corners.min(axis=0), other.corners.min(axis=0))
    high = np.minimum(one.corners.max(axis=0), other.corners.max(axis=0))
    return bool((high - low)[:-1].min() <= 0)


def _descent_of_part(one: Convex, other: Convex) -> float:
    """How far a convex part may go down before it touches another, m, by linear programming.

    Infinite if it misses that or brushes it; below 0 where it is in it, or below it.
    """
    size = size_of(np.concatenate([one.corners, other.corners]))
    columns = np.zeros(len(one.faces)), -other.normals[:, -1]
    for within in (BRUSHES, 0.0):
        most = _optimum((one, other), columns, 1.0, one.corners.mean(axis=0), size, within)
        if most is None:
            return np.inf
    assert most is not None
    return float(most[-1]) * size


def common_balls(
    first: Sequence[Convex], second: Sequence[Convex], least: float
) -> Iterator[tuple[float, Array]]:
    """Radius and centre of the largest ball in both of two parts, < 0 if they are apart, m.

    For each pair whose boxes overlap by more than a least distance, by linear programming.
    """
    for one in first:
        for other in second:
            low = np.maximum(one.corners.min(axis=0), other.corners.min(axis=0))
            high = np.minimum(one.corners.max(axis=0), other.corners.max(axis=0))
            if (high - low > least).all():
                size = size_of(np.concatenate([one.corners, other.corners]))
                columns, origin = (
                    [np.ones(len(each.faces)) for each in (one, other)],
                    (low + high) / 2,
                )
                best = _optimum((one, other), columns, -1.0, origin, size)
                assert best is not None  # some radius, below 0 if need be, always fits
                yield float(best[-1]) * size, origin + size * best[:-1]


def _optimum(
    shapes: Sequence[Convex],
    columns: Sequence[Array],
    goal: float,
    origin: Array,
    size: float,
    within: float = 0.0,
) -> Array | None:
    """A place in convex shapes and a number s, for which `goal` s is least, (d + 1,); None: none.

    Of each shape normals x + column s <= levels - within, over the size and about an origin, m.
    """
    from scipy.optimize import linprog  # slow to import

    rows, levels = [], []
    for shape, column in zip(shapes, columns, strict=True):
        rows.append(np.column_stack([shape.normals, column]))
        levels.append(np.einsum("ni,ni->n", shape.normals, (shape.starts - origin) / size))
    found = linprog(
        np.append(np.zeros(len(origin)), goal),
        A_ub=np.concatenate(rows),
        b_ub=np.concatenate(levels) - within,
        bounds=(None, None),
    )
    return found.x if found.success else None
