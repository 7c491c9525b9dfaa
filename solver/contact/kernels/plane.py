"""Places of points over a plane, and vectors in its frame; compiled."""

from __future__ import annotations

from solver.law.compiled import compiled
from solver.types import Array, Mask


@compiled
def places(position: Array, plane: Array, place: Array, beyond: Mask) -> None:
    """Fill in gaps and tangential positions (g, s) of points, and which are beyond an end.

    Args:
        position: x, (m, d), m.
        plane: Where the plane lies, (4 + d, d): its rows are a point of it, how far it has moved,
            least and greatest (g, s) on it, of which only s count, m, and the rows of its frame,
            normal and tangents.
        place: (g, s), (m, d), m.
        beyond: Points beyond an end, (m,); (0,) where there is none.
    """
    origin, shift, low, high, frame = plane[0], plane[1], plane[2], plane[3], plane[4:]
    place[:] = 0.0
    for p in range(len(place)):
        for j in range(len(frame)):
            apart = position[p, j] - (origin[j] + shift[j])
            for i in range(len(frame)):
                place[p, i] += frame[i, j] * apart
        if len(beyond) > 0:
            beyond[p] = False
            for i in range(1, len(frame)):
                if not low[i] <= place[p, i] <= high[i]:
                    beyond[p] = True


@compiled
def vectors_of(components: Array, frame: Array, vectors: Array) -> None:
    """Fill in vectors in space of components (m, d) along the rows of a frame, (d, d)."""
    vectors[:] = 0.0
    for p in range(len(vectors)):
        for k in range(len(frame)):
            for i in range(len(frame)):
                vectors[p, i] += components[p, k] * frame[k, i]
