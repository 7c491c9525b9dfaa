"""Places of points over an endless plane, and vectors in its frame; compiled."""

from __future__ import annotations

from solver.law.compiled import compiled
from solver.types import Array, Mask


@compiled
def places(position: Array, origin: Array, shift: Array, frame: Array, place: Array) -> None:
    """Fill in gaps and tangential positions (g, s) of points, (m, d), m.

    Args:
        position: x, (m, d), m.
        origin: A point of the plane, (d,), m.
        shift: How far the plane has moved, (d,), m.
        frame: Rows normal and tangents, (d, d).
        place: (g, s), (m, d), m.
    """
    place[:] = 0.0
    for p in range(len(place)):
        for j in range(len(frame)):
            apart = position[p, j] - (origin[j] + shift[j])
            for i in range(len(frame)):
                place[p, i] += frame[i, j] * apart


@compiled
def vectors_of(components: Array, frame: Array, vectors: Array) -> None:
    """Fill in vectors in space of components (m, d) along the rows of a frame, (d, d)."""
    vectors[:] = 0.0
    for p in range(len(vectors)):
        for k in range(len(frame)):
            for i in range(len(frame)):
                vectors[p, i] += components[p, k] * frame[k, i]


@compiled
def places_within(
    position: Array,
    origin: Array,
    frame: Array,
    low: Array,
    high: Array,
    place: Array,
    beyond: Mask,
) -> None:
    """As `places`, on a plane that stands still, and which points are beyond its ends.

    The ends are the least and the greatest tangential positions on it, (d-1,), m.
    """
    place[:] = 0.0
    for p in range(len(place)):
        beyond[p] = False
        for i in range(len(frame)):
            for j in range(len(frame)):
                place[p, i] += frame[i, j] * (position[p, j] - origin[j])
            if i > 0 and not low[i - 1] <= place[p, i] <= high[i - 1]:
                beyond[p] = True
