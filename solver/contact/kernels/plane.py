"""Places of points over a plane, and vectors in its frame; compiled."""

from __future__ import annotations

from solver.law.compiled import compiled
from solver.types import Array, Mask


@compiled
def places(
    position: Array,
    origin: Array,
    shift: Array,
    frame: Array,
    low: Array,
    high: Array,
    place: Array,
    beyond: Mask,
) -> None:
    """Fill in gaps and tangential positions (g, s) of points, and which are beyond an end.

    Args:
        position: x, (m, d), m.
        origin: A point of the plane, (d,), m.
        shift: How far the plane has moved, (d,), m.
        frame: Rows normal and tangents, (d, d).
        low: Least tangential positions on the plane, (d-1,), m; infinite where it has no end.
        high: Greatest ones.
        place: (g, s), (m, d), m.
        beyond: Points beyond an end, (m,).
    """
    place[:] = 0.0
    for p in range(len(place)):
        beyond[p] = False
        for j in range(len(frame)):
            apart = position[p, j] - (origin[j] + shift[j])
            for i in range(len(frame)):
                place[p, i] += frame[i, j] * apart
        for i in range(1, len(frame)):
            if not low[i - 1] <= place[p, i] <= high[i - 1]:
                beyond[p] = True


@compiled
def vectors_of(components: Array, frame: Array, vectors: Array) -> None:
    """Fill in vectors in space of components (m, d) along the rows of a frame, (d, d)."""
    vectors[:] = 0.0
    for p in range(len(vectors)):
        for k in range(len(frame)):
            for i in range(len(frame)):
                vectors[p, i] += components[p, k] * frame[k, i]
