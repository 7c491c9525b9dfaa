"""What a step looks at: points near their carriers, or beyond an edge; interfaces far away.

Each point that is looked at needs its columns of the contact compliance, which large bodies take
long to solve for. So points that were never near count only where they would sink in; those that
once were, for which the columns are there, count from some way off: the set stays the same then,
and what other points press into the carrier is there when it is. Interfaces far from contact are
left out of a step, and many steps do not even look at them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from solver.bodies.rigid_body import DenseBody
from solver.contact.carriers import Carrier
from solver.contact.kinematics import ContactKinematics, Observed
from solver.contact.memory import Memory
from solver.parallel import global_max
from solver.stepping.balance import Balance
from solver.stepping.point_table import PointTable
from solver.stepping.system import Body, System
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


ASLEEP_REACHES = 5
"""An interface farther from contact than this many times the reach of its points is left out."""

STEPS_AHEAD = 2
"""Nobody looks at an interface that the next step leaves far from contact even if bodies move this
many times as far in it as in the last one."""


class Sleepers:
    """The interfaces that a step leaves out.

    Attributes:
        asleep: Whether each interface is one of them.
        points: Their points, (points,); None where there are none.
        overran: Whether bodies moved so far in the step that it says nothing of interfaces nobody
            looked at.
    """

    def __init__(self, system: System, points: PointTable, balance: Balance, edges: CarrierEdges):
        """Leave out what is far from contact at the start of the step; nothing in equilibrium."""
        self._system, self._points, self._start = system, points, balance.start
        self._memories, self._edges = balance.contact, edges
        self._looked: dict[int, Observed] = {}  # at the end of the step
        self._clear: dict[int, float] = {}  # likewise
        self.asleep = [
            not balance.static and (memory.clear > 0.0 or self._far(number, memory))
            for number, memory in enumerate(balance.contact)
        ]
        self.points = self._of_sleeping()
        self.overran = False

    def _of_sleeping(self) -> Mask | None:
        """The points of interfaces that sleep; None where there are none."""
        if not any(self.asleep):
            return None
        return self._points.of_interfaces(tuple(self.asleep))

    def _reach(self, number: int) -> float:
        """How far from contact an interface has to be to be left out, m."""
        return ASLEEP_REACHES * REACH * self._points.links[number].interface.size

    def _far(self, number: int, memory: Memory) -> bool:
        """Whether an interface is far from contact at the start of the step.

        Only those without tractions can sleep: the theta term acts on open points, too.
        """
        if self._points.links[number].interface.theta or memory.force.any():
            return False
        return self._clearance(number, memory.kinematics) > self._reach(number)

    def _clearance(self, number: int, kinematics: ContactKinematics) -> float:
        """Smallest gap of an interface's points that may touch, m."""
        beyond, may = self._edges.beyond(number, kinematics), self._memories[number].may_touch
        if beyond is not None:
            may = may & ~beyond
        gaps = kinematics.place[may, 0]
        return float(gaps.min()) if len(gaps) else np.inf

    def wake(self, u: Array) -> bool:
        """Whether interfaces have come into contact at the solution u after all."""
        if self.points is None:
            return False
        ways = ways_of(self._system, u, self._start)
        woken = False
        for number, asleep in enumerate(self.asleep):
            if asleep and self._wakes(number, u, ways):
                self.asleep[number], woken = False, True
        if woken:
            self.points = self._of_sleeping()
        return woken

    def _wakes(self, number: int, u: Array, ways: list[float]) -> bool:
        """Whether an interface has come into contact at u, where bodies moved so far, m."""
        link, before = self._points.links[number], self._memories[number].clear
        way = sum(ways[body] for body in (link.body, link.carrier) if body is not None)
        self._looked.pop(number, None)
        clear = before - way
        if clear <= STEPS_AHEAD * way:
            self.overran |= before > 0.0 and clear + self._reach(number) <= 0.0
            seen = self._looked[number] = self._points.observe(number, u)
            if not before and self._clearance(number, seen[1]) < 0:
                return True
            clear = link.interface.apart(*seen) - self._reach(number)
        self._clear[number] = clear if clear > STEPS_AHEAD * way else 0.0
        return False

    def seen(self, number: int) -> Observed:
        """A sleeping interface at the end of the step, or where anybody looked at it last."""
        memory = self._memories[number]
        return self._looked.get(number, memory.seen)

    def clear(self, number: int) -> float:
        """How far an interface may still move before anybody has to look at it, m."""
        return self._clear[number] if self.asleep[number] else 0.0


def ways_of(system: System, now: Array, before: Array) -> list[float]:
    """At most how far a point of each body moves between owned unknowns, m; collective.

    By positions relative to the ground.
    """
    ways = [_way(body, now[own], before[own]) for body, own in system.members]
    return global_max(system.comm, ways)


def _way(body: Body, now: Array, before: Array) -> float:
    """At most how far a point moves that this rank knows of, m."""
    if isinstance(body, DenseBody):
        return body.way(now - before)
    return math.sqrt(body.dimension) * float(np.abs(now - before).max(initial=0.0))
