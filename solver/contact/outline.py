"""The outline of a level face in space: its four edges, each a chain of segments between nodes."""

from __future__ import annotations

import numpy as np

from solver.contact.body_points import FacePoints
from solver.contact.projection import EdgeInterpolation
from solver.types import Array, Indices

EDGES = ((1, "low", 0, 1.0), (0, "high", 1, 1.0), (1, "high", 0, -1.0), (0, "low", 1, -1.0))
"""For each edge of a face: axis across it, end of that axis, axis along it, direction along it."""


class Outline:
    """The edges of a rectangular face, counterclockwise as seen from above.

    Attributes:
        points: The nodes on the outline.
        corners: Numbers of the nodes at which the edges begin, (4,).
    """

    def __init__(self, points: FacePoints, degree: int):
        """Take the nodes on the outline; between them it has a polynomial degree of 1 or 2."""
        self.points, self._degree = points, degree
        level = points.reference[:, :-1]
        bound = {"low": level.min(axis=0), "high": level.max(axis=0)}
        near = 1e-9 * np.ptp(level, axis=0)
        pieces: list[Indices] = []
        begins: list[float] = []
        lengths: list[float] = []
        corners: list[int] = []
        for edge, (across, end, axis, sign) in enumerate(EDGES):
            on = np.flatnonzero(np.abs(level[:, across] - bound[end][across]) < near[across])
            chain = on[np.argsort(sign * level[on, axis])]
            place = np.abs(level[chain, axis] - level[chain[0], axis])
            place /= place[-1]
            for k in range(0, len(chain) - 1, degree):
                pieces.append(chain[k : k + degree + 1])
                begins.append(edge + place[k])
                lengths.append(place[k + degree] - place[k])
            corners.append(int(chain[0]))
        self.corners: Indices = np.array(corners)
        self._ends: Indices = np.roll(self.corners, -1)
        self._pieces: Indices = np.array(pieces, dtype=np.int64)
        self._begins, self._lengths = np.array(begins), np.array(lengths)
        self._first = np.searchsorted(self._begins, np.arange(4.0))
        self._last = np.append(self._first[1:], len(pieces)) - 1

    def chords(self, position: Array) -> Array:
        """From end to end of each edge, (4, 3), for positions of the nodes."""
        return position.take(self._ends, axis=0) - position.take(self.corners, axis=0)

    def locate(self, edge: Indices, fraction: Array) -> tuple[Indices, Array]:
        """Segments and places on them at fractions of the lengths of edges, and beyond their ends.

        The fraction is that in the undeformed body.
        """
        found = np.searchsorted(self._begins, edge + np.clip(fraction, 0.0, 1.0), "right") - 1
        found = np.clip(found, self._first[edge], self._last[edge])
        return found, (edge + fraction - self._begins[found]) / self._lengths[found]

    def fraction(self, edge: Indices, segment: Indices, where: Array) -> Array:
        """Fractions of the lengths of edges, for places on segments: the inverse of `locate`."""
        return self._begins[segment] - edge + where * self._lengths[segment]

    def spots(self, segment: Indices, where: Array, position: Array) -> EdgeInterpolation:
        """The places at `where` on segments, for positions of the nodes."""
        x = where
        if self._degree == 1:
            weights = np.stack([1 - x, x], axis=1)
        else:
            weights = np.stack([(1 - x) * (1 - 2 * x), 4 * x * (1 - x), x * (2 * x - 1)], axis=1)
        return EdgeInterpolation(self._pieces[segment], weights, segment, x, position)

    def nowhere(self, position: Array) -> EdgeInterpolation:
        """No place at all."""
        empty = np.zeros(0)
        return self.spots(empty.astype(np.int64), empty, position)

    def tangents(self, segment: Indices, where: Array, position: Array) -> Array:
        """Derivatives of the place along segments, (m, 3)."""
        x = where
        if self._degree == 1:
            slopes = np.stack([-np.ones_like(x), np.ones_like(x)], axis=1)
        else:
            slopes = np.stack([4 * x - 3, 4 - 8 * x, 4 * x - 1], axis=1)
        return (slopes[:, None, :] @ position[self._pieces[segment]])[:, 0]
