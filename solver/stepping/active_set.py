"""The active set of a step: points near contact, and points beyond edges.

Each point that is looked at needs its columns of the contact compliance, which large bodies take
long to solve for. So points that were never near count only where they would sink in; those that
once were, for which the columns are there, count from some way off: the set stays the same then,
and what other points press into the carrier is there when it is.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from solver.contact.carriers import Carrier
from solver.contact.kinematics import ContactKinematics
from solver.contact.memory import Memory
from solver.stepping.point_table import PointTable
from solver.types import Array, Indices, Mask

MARGIN = 0.002
"""Part of a body's size: points farther from their carrier after the free step are not pressed into
it by the others."""

FIRST_MARGIN = 1e-6
"""Part of a body's size from which points count that were never near before; if others sink in all
the same, the step is solved on with them."""


class ContactMargin:
    """The gaps below which points may come into contact in a correction.

    Attributes:
        distance: The gaps, (points,), m.
        seen: Points that were near in a correction before, (points,).
        keeps_touching: True if all points that touched at the start count wherever they are.
    """

    def __init__(self, size: Array):
        """Begin with points that were never near, by the sizes of their bodies, (points,), m."""
        self._size, self.keeps_touching = size, False
        self.reset(np.zeros(len(size), dtype=np.bool_))

    def reset(self, seen: Mask) -> None:
        """Take these points, and no others, for points that were near before, (points,)."""
        self.seen, self.keeps_touching = seen.copy(), False
        self.distance: Array = np.where(seen, MARGIN, FIRST_MARGIN) * self._size

    def keep_active(self, gaps: Array, may_touch: Mask) -> None:
        """Let all points that touch by these gaps (m) count, wherever corrections lead them."""
        touching = may_touch & (gaps <= FIRST_MARGIN * self._size)
        self.keeps_touching = True
        self.distance = np.where(touching, np.inf, self.distance)

    def mark_seen(self, near: Indices) -> None:
        """Mark points, by their numbers, as points that have been near."""
        if self.seen.take(near).all():
            return
        self.seen[near] = True
        self.distance[near] = np.maximum(self.distance[near], MARGIN * self._size[near])


def points_beyond(carrier: Carrier, kinematics: ContactKinematics) -> Mask | None:
    """Points beyond the edge of their carrier; None: there are none."""
    beyond = carrier.beyond_edge(kinematics)
    return beyond if beyond is not None and np.count_nonzero(beyond) else None


MOST_CROSSED = 8
"""Times that a point may cross an edge in the corrections of a step, at most."""


class EdgeWatch:
    """Points that a step begins with beyond the edges of their carriers, in its corrections.

    A point that is within the edges when the step begins stays in contact until its end: let go in
    the middle of a solve, it would lose the friction that keeps it from going. One that goes to and
    fro over an edge, pushed off and falling back, stays beyond it.
    """

    def __init__(self, points: PointTable, memories: Sequence[Memory]):
        """Take what contact remembers at the start of the step."""
        self._points = points
        pairs = zip(points.carriers, memories, strict=True)
        self._before = [points_beyond(carrier, memory.kinematics) for carrier, memory in pairs]
        self._last: Mask | None = None
        self._crossings: Indices = np.zeros(points.count, dtype=np.int64)

    def beyond(self, kinematics: Sequence[ContactKinematics]) -> Mask | None:
        """The points to be taken as beyond an edge in a correction; None for no point."""
        points, beyond = self._points, None
        for number, before in enumerate(self._before):
            if before is None:
                continue
            now = points_beyond(points.carriers[number], kinematics[number])
            if now is not None and np.count_nonzero(now & before):
                if beyond is None:
                    beyond = np.zeros(points.count, dtype=np.bool_)
                beyond[points.own[number]] = now & before
        return self.settled(beyond)

    def settled(self, beyond: Mask | None) -> Mask | None:
        """The points to be taken as beyond an edge, by those that are at the present iterate."""
        last = self._last
        if beyond is None and last is None:
            return None
        if last is not None and beyond is not None and last.tobytes() == beyond.tobytes():
            return last
        none = np.zeros(len(self._crossings), dtype=np.bool_)
        was, now = (none if mask is None else mask for mask in (last, beyond))
        self._crossings += was != now
        restless = self._crossings > MOST_CROSSED
        self._last = now | restless if restless.any() else beyond
        return self._last
