"""Interfaces far from contact, which a step leaves out, and many steps do not even look at."""

from __future__ import annotations

import math

import numpy as np

from solver.bodies.dense_body import DenseBody
from solver.contact.kinematics import ContactKinematics, Observed
from solver.contact.memory import Memory
from solver.parallel import global_max
from solver.stepping.balance import Balance
from solver.stepping.carrier_edges import CarrierEdges
from solver.stepping.differences import largest_change
from solver.stepping.point_table import PointTable
from solver.stepping.reach import REACH
from solver.stepping.system import Body, System
from solver.types import Array, Mask

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
    return math.sqrt(body.dimension) * largest_change(now, before)
