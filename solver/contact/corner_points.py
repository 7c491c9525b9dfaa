"""Contact points of different faces that share one place: those of the corners of a body."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from solver.types import Array, Indices, Mask

SAME_PLACE = 9
"""Decimals, of the body's size, to which places that are one agree."""


class CornerPoints:
    """Groups of contact points of different faces at one place.

    At each corner only one of its points may touch at a time: that of the face which looks most
    against the carrier.
    """

    def __init__(self, places: Array, normal: Array):
        """Find the groups by the points' places over the body's size and their outward normals."""
        _, group = np.unique(np.round(places, SAME_PLACE), axis=0, return_inverse=True)
        members = [np.flatnonzero(group.ravel() == k) for k in range(group.max() + 1)]
        self._groups = [each for each in members if len(each) > 1]
        self._normal = normal
        self._member = np.array([p for each in self._groups for p in each], dtype=np.int64)
        self._group = np.repeat(np.arange(len(self._groups)), list(map(len, self._groups)))
        self._first = np.searchsorted(self._group, np.arange(len(self._groups)))

    def chosen(self, rotation: Array, towards: Array) -> Mask:
        """The points that may touch: one of each corner, and all that share no place.

        The body has turned by a rotation (d, d); `towards` is the normal of the carrier, (d,).
        """
        mask = np.ones(len(self._normal), dtype=np.bool_)
        if len(self._member):
            cosine = self._normal[self._member] @ (towards @ rotation)
            order = np.lexsort((cosine, self._group))
            mask[self._member] = False
            mask[self._member[order[self._first]]] = True
        return mask

    def closed_to_all(self, may_touch: Mask) -> Mask | None:
        """Points that may not touch, but for those at whose corner another one may; None: none."""
        outside = ~may_touch
        if len(self._member):
            closed = np.logical_and.reduceat(outside[self._member], self._first)
            outside[self._member] = closed[self._group]
        return outside if outside.any() else None

    def moves(self, before: Mask, after: Mask) -> Iterator[tuple[int, int]]:
        """Pairs (old, new) of points of a corner between which contact changes."""
        for corner in self._groups:
            old, new = _first(corner, before), _first(corner, after)
            if old is not None and new is not None and old != new:
                yield old, new


def _first(corner: Indices, mask: Mask) -> int | None:
    """The first point of a corner that is in the mask; None where none is."""
    chosen = corner[mask[corner]]
    return int(chosen[0]) if len(chosen) else None
