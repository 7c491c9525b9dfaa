"""How near to its carrier a point has to be for a correction to look at it.

Each point that is looked at needs its columns of the contact compliance, which large bodies take
long to solve for. So points that were never near count only where they would sink in; those that
once were, for which the columns are there, count from some way off: the set stays the same then,
and what other points press into the carrier is there when it is.
"""

from __future__ import annotations

import numpy as np

from solver.types import Array, Indices, Mask

REACH = 0.002
"""Part of a body's size: points farther from their carrier after the free step are not pressed into
it by the others."""

FIRST_REACH = 1e-6
"""Part of a body's size from which points count that were never near before; if others sink in all
the same, the step is solved on with them."""


class Reach:
    """The gaps below which points may come into contact in a correction.

    Attributes:
        distance: The gaps, (points,), m.
        met: Points that were near in a correction before, (points,).
        holding: Whether some points count wherever they are.
    """

    def __init__(self, size: Array):
        """Begin with points that were never near, by the sizes of their bodies, (points,), m."""
        self._size, self.holding = size, False
        self.meet_again(np.zeros(len(size), dtype=np.bool_))

    def meet_again(self, met: Mask) -> None:
        """Let these points, and no others, have been near before, (points,)."""
        self.met, self.holding = met.copy(), False
        self.distance: Array = np.where(met, REACH, FIRST_REACH) * self._size

    def hold(self, gaps: Array, may_touch: Mask) -> None:
        """Let all points that touch by these gaps (m) count, wherever corrections lead them."""
        touching = may_touch & (gaps <= FIRST_REACH * self._size)
        self.holding = True
        self.distance = np.where(touching, np.inf, self.distance)

    def meet(self, near: Indices) -> None:
        """Take note that points are near, by their numbers."""
        if self.met.take(near).all():
            return
        self.met[near] = True
        self.distance[near] = np.maximum(self.distance[near], REACH * self._size[near])
