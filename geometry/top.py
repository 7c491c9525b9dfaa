"""The top of a block, which carries others: what of its outline looks upwards, not too steeply.

Of a box that is its upper face. Of a shape it is the faces of its convex hull that look up within
60 degrees of its upright axis: that of a dome, of a roof, of a stair, which holds what lies on it,
reaches down to their lowest corner. The top of a body that rolls is level, whatever its turn is:
others stand on what is uppermost then.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from geometry.block import Block
from geometry.convex import hull_of, normals_of
from geometry.polygon import NEAR
from solver.types import Array, Mask

STEEPEST_TOP = 0.5
"""Cosine of the lean of a top beyond which it carries nothing, 60 degrees."""


@dataclass(frozen=True, slots=True, eq=False)
class Top:
    """A top in the frame in which its block stands: its outline seen from above, and its level."""

    normals: Array
    """Horizontal normals of its sides, outwards, (sides, d - 1)."""
    reach: Array
    """Distance of each side from the origin along its normal, (sides,), m."""
    level: float
    """Height of its lowest corner, m."""

    @classmethod
    @lru_cache(maxsize=256)
    def rectangle(cls, half: tuple[float, ...], level: float) -> Top:
        """A rectangle about the origin, by half its d - 1 lengths, m."""
        sides = np.eye(len(half))
        return cls(np.concatenate([sides, -sides]), np.array(half * 2), level)

    def is_off(self, places: Array) -> Mask:
        """True where places (n, d), m, are beside it, or below its level; (n,)."""
        beside = (places[:, :-1] @ self.normals.T > self.reach).any(axis=1)
        return np.asarray(beside | (places[:, -1] < self.level))


def top_over_centre(block: Block, dimension: int) -> float:
    """Height of the top of a block over its centre of mass, m."""
    return top_of(block, dimension).level - block.centre_height


@lru_cache(maxsize=256)
def top_of(block: Block, dimension: int) -> Top:
    """The top of a block, about the middle of its bottom."""
    if block.solid is None:
        return Top.rectangle(block.half_lengths(dimension)[:-1], block.height)
    corners, faces = hull_of(block.solid.corners, NEAR)
    upwards = normals_of(corners, faces)[:, -1] > STEEPEST_TOP + NEAR
    numbers = {k for face, up in zip(faces, upwards, strict=True) if up for k in face}
    high = corners[:, -1] >= corners[:, -1].max() - NEAR * block.solid.size
    chosen = corners[sorted(numbers | set(map(int, np.flatnonzero(high))))]
    level, seen = float(chosen[:, -1].min()), chosen[:, :-1]
    if dimension == 3 and np.linalg.matrix_rank(seen - seen[0], tol=NEAR * block.solid.size) == 2:
        ring, edges = hull_of(seen, NEAR)
        normals = normals_of(ring, edges)
        starts = ring[[edge[0] for edge in edges]]
        return Top(normals, np.einsum("ni,ni->n", normals, starts), level)
    # In the plane, and of a ridge or a tip in space, the rectangle around it.
    sides = np.concatenate([np.eye(dimension - 1), -np.eye(dimension - 1)])
    return Top(sides, (seen @ sides.T).max(axis=0), level)
