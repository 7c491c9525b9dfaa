"""Places of points over an endless plane; compiled."""

from __future__ import annotations

from solver.law.compiled import compiled
from solver.types import Array


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
