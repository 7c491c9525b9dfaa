"""The active set of a step: points near contact, points beyond edges, interfaces left out.

Each point that is looked at needs its columns of the contact compliance, which large bodies take
long to solve for. So points that were never near count only where they would sink in; those that
once were, for which the columns are there, count from some way off: the set stays the same then,
and what other points press into the carrier is there when it is. Interfaces far from contact are
inactive; while bodies move by less than their clearance, they need not even be observed.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from solver.contact.carriers import Carrier
from solver.contact.kinematics import ContactKinematics, Observed
from solver.contact.memory import Memory
from solver.parallel import global_max
from solver.stepping.balance import Balance
from solver.stepping.point_table import PointTable
from solver.stepping.system import System
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


MOST_CROSSED = 8
"""Times that a point may cross an edge in the corrections of a step, at most."""


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


INACTIVE_MARGINS = 5
"""An interface farther from contact than this many times the reach of its points is left out."""

STEPS_AHEAD = 2
"""An interface is not observed if the next step leaves it far from contact even where bodies move
this many times as far in it as in the last one."""


class ActiveSet:
    """The interfaces that are active in a step, and those far from contact that it leaves out.

    Attributes:
        inactive: True for each interface that is left out.
        points: The points of inactive interfaces, (points,); None if there are none.
        overran: True if bodies moved farther in the step than interfaces that were not observed
            were clear.
    """

    def __init__(self, system: System, points: PointTable, balance: Balance, edges: CarrierEdges):
        """Leave out what is far from contact at the start of the step; nothing in equilibrium."""
        self._system, self._points, self._start = system, points, balance.start
        self._memories, self._edges = balance.contact, edges
        self._observed: dict[int, Observed] = {}  # at the end of the step
        self._clear: dict[int, float] = {}  # likewise
        self.inactive = [
            not balance.static and (memory.clear > 0.0 or self._far(number, memory))
            for number, memory in enumerate(balance.contact)
        ]
        self.points = self._inactive_points()
        self.overran = False

    def _inactive_points(self) -> Mask | None:
        """The points of inactive interfaces; None if there are none."""
        if not any(self.inactive):
            return None
        return self._points.of_interfaces(tuple(self.inactive))

    def _margin(self, number: int) -> float:
        """Distance from contact beyond which an interface is inactive, m."""
        return INACTIVE_MARGINS * MARGIN * self._points.links[number].interface.size

    def _far(self, number: int, memory: Memory) -> bool:
        """True if an interface is far from contact at the start of the step.

        Only those without tractions can be inactive: the theta term acts on open points, too.
        """
        if self._points.links[number].interface.theta or memory.force.any():
            return False
        return self._clearance(number, memory.kinematics) > self._margin(number)

    def _clearance(self, number: int, kinematics: ContactKinematics) -> float:
        """Smallest gap of an interface's points that may touch, m."""
        beyond, may = self._edges.beyond(number, kinematics), self._memories[number].may_touch
        if beyond is not None:
            may = may & ~beyond
        gaps = kinematics.place[may, 0]
        return float(gaps.min()) if len(gaps) else np.inf

    def activate(self, u: Array) -> bool:
        """Activate interfaces that are in contact at the solution u; True if there are any."""
        if self.points is None:
            return False
        moved = largest_displacements(self._system, u, self._start)
        activated = False
        for number, inactive in enumerate(self.inactive):
            if inactive and self._has_contact(number, u, moved):
                self.inactive[number], activated = False, True
        if activated:
            self.points = self._inactive_points()
        return activated

    def _has_contact(self, number: int, u: Array, moved: Sequence[float]) -> bool:
        """True if an inactive interface is in contact at u; bodies moved by at most so much, m."""
        link, memory = self._points.links[number], self._memories[number]
        moved_by = sum(moved[body] for body in (link.body, link.carrier) if body is not None)
        self._observed.pop(number, None)
        clear = memory.clear - moved_by
        if clear <= STEPS_AHEAD * moved_by:
            self.overran |= memory.clear > 0.0 and clear + self._margin(number) <= 0.0
            seen = self._observed[number] = self._points.observe(number, u, memory)
            if not memory.clear and self._clearance(number, seen[1]) < 0:
                return True
            clear = link.interface.apart(*seen) - self._margin(number)
        self._clear[number] = clear if clear > STEPS_AHEAD * moved_by else 0.0
        return False

    def seen(self, number: int) -> Observed:
        """An inactive interface when it was observed last."""
        memory = self._memories[number]
        return self._observed.get(number, memory.seen)

    def clear(self, number: int) -> float:
        """Distance by which an interface may still move before it has to be observed, m."""
        return self._clear[number] if self.inactive[number] else 0.0


def largest_displacements(system: System, now: Array, before: Array) -> list[float]:
    """At most how far a point of each body moves between owned unknowns, m; collective.

    By positions relative to the ground.
    """
    moved = [body.way(now[own] - before[own]) for body, own in system.members]
    return global_max(system.comm, moved)
