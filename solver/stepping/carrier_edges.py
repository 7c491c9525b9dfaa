"""Points beyond the edges of what carries them, in the corrections of one step."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from solver.contact.carriers import Carrier
from solver.contact.kinematics import ContactKinematics
from solver.contact.memory import Memory
from solver.stepping.point_table import PointTable
from solver.types import Indices, Mask

MOST_CROSSED = 8
"""How often a point may cross an edge in the corrections of a step."""


class CarrierEdges:
    """The edges of all carriers, and the points that a step begins with beyond them.

    A point that is within the edges when the step begins stays in contact until its end: let go in
    the middle of a solve, it would lose the friction that keeps it from going.

    Attributes:
        numbers: Of the interfaces with points that begin beyond one.
    """

    def __init__(self, points: PointTable, memories: Sequence[Memory]):
        """Take what contact remembers at the start of the step."""
        self._carriers = points.carriers
        pairs = zip(points.carriers, memories, strict=True)
        self._before = [points_beyond(carrier, memory) for carrier, memory in pairs]
        self.numbers = [k for k, before in enumerate(self._before) if before is not None]

    def beyond(self, number: int, kinematics: ContactKinematics) -> Mask | None:
        """Points of an interface that began the step beyond an edge, and still are; None: none."""
        before = self._before[number]
        if before is None:
            return None
        now = self._carriers[number].beyond_edge(kinematics)
        return None if now is None else before & now


def points_beyond(carrier: Carrier, memory: Memory) -> Mask | None:
    """Points that a step begins with beyond the edge of their carrier; None: there are none."""
    beyond = None if memory.clear else carrier.beyond_edge(memory.kinematics)
    return beyond if beyond is not None and np.count_nonzero(beyond) else None


class EdgeWatch:
    """Points beyond the edges of their carriers in the corrections of one step.

    A point that goes to and fro over an edge, pushed off and falling back, stays beyond it.
    """

    def __init__(self) -> None:
        """Begin with all points within."""
        self._first: Mask | None = None
        self._last: Mask | None = None
        self._crossings: Indices | None = None

    def settled(self, beyond: Mask | None) -> Mask | None:
        """The points to be taken as beyond an edge in this correction; None for no point.

        `beyond` are those that are at the present iterate.
        """
        if self._first is None:
            self._first = self._last = beyond
            return beyond
        if self._last is not None and beyond is not None:
            if self._last.tobytes() == beyond.tobytes():
                return self._last
        if self._crossings is None:
            self._crossings = self._first.astype(np.int64)
        none = np.zeros_like(self._first)
        was, now = (none if mask is None else mask for mask in (self._last, beyond))
        self._crossings += was != now
        restless = self._crossings > MOST_CROSSED
        self._last = now | restless if restless.any() else beyond
        return self._last
