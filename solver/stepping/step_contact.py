"""The forces of all contact points in one step, and the law that they obey after each free step."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from solver.contact.memory import Memory
from solver.kernels import meshed
from solver.law.friction import Bounds, slipping_points
from solver.law.local_problem import LocalProblem, NoContactSolution, image
from solver.law.many_points import MANY_ROWS
from solver.stepping.active_set import ContactMargin
from solver.stepping.balance import Balance
from solver.stepping.delassus import Delassus, Softening
from solver.stepping.point_table import PointTable, copied, joined, joined_bounds
from solver.stepping.system import System
from solver.types import Array, Indices


@dataclass(frozen=True, slots=True)
class ContactModel:
    """Bodies, contact points and tangents, the same for all steps while no face joins."""

    system: System
    """All bodies."""
    points: PointTable
    """All contact points."""
    local: LocalProblem
    """Solver of local problems."""
    margin: ContactMargin
    """Margin within which points are candidates for contact."""
    softening: Softening | None
    """Softening of rigid points; None where there are none."""


STICKING_MU = 1e6
"""Coefficient of friction that holds anything."""

SAME_FRICTION = 1e-9
"""Part of the largest coefficient of friction within which friction fits the slip it allows."""


class FrictionBounds:
    """Bounds of friction in one step.

    Attributes:
        bounds: Those of all points, by the last slip.
        steady: True if friction depends on neither speed nor the past: it is constant.
    """

    def __init__(self, points: PointTable, memories: Sequence[Memory], *, step: float, glued: bool):
        """Start from what contact remembers at t_n.

        The step, s, is infinite in equilibrium; `glued`: closed points hold any friction.
        """
        self._points, self._step = points, step
        steady = Bounds.uniform(STICKING_MU, points.count) if glued else points.bounds
        self.steady, self._decays = steady is not None, points.decays and not glued
        if steady is not None:
            self.bounds = steady
            return
        self._pasts = [memory.past for memory in memories]
        laws = [link.interface.law for link in points.links]
        # Only where a law needs it.
        self._slips = [
            np.zeros(0, dtype=bool) if law.constant else memory.slipped
            for law, memory in zip(laws, memories, strict=True)
        ]
        self._speed: Array = np.zeros(points.count)
        pairs = zip(points.links, self._pasts, strict=True)
        self.bounds = joined_bounds([link.interface.bounds(past) for link, past in pairs])
        # The coefficients follow the speed of this step, not that of the last one.
        self.bounds = self._at_speed(self._speed)

    def tell(self, slip: Array) -> None:
        """Take the bounds that go with slips of all points in the step, (points, d-1), m."""
        self._speed = self._speed_of(slip)
        self.bounds = self._at_speed(self._speed)

    def follows(self, near: Indices, W: Array, q: Array, force: Array) -> bool:
        """Take the bounds that go with the slip q + W f; whether they are others than before.

        W is the compliance of the near points, (m, d, m, d), m/N, q their free values, (m, d), m,
        and f the solution with the bounds so far, (m, d), N.
        """
        if not self._decays:
            return False
        solved_with = self.bounds
        self._speed = self._speed.copy()
        self._speed[near] = self._speed_of((q + image(W, force))[:, 1:])
        self.bounds = self._at_speed(self._speed)
        before = solved_with.mu
        if np.abs(self.bounds.mu - before).max() > SAME_FRICTION * before.max():
            return True
        # Points that slip are at the bounds that their forces were solved with, to the last digit.
        self.bounds = solved_with
        return False

    def break_loose(self, force: Array, slip: Array, compliance: Array) -> bool:
        """Let points that slip at their static friction slip from now on; whether there are any.

        They go from mu_s to mu_d only. By forces of all points, (points, d), N, which are then
        those of the wrong friction, their slips, (points, d-1), m, and what the force at a point
        moves it by, (points,), m/N.
        """
        any_loose = False
        for k, (link, own) in enumerate(zip(self._points.links, self._points.own, strict=True)):
            if link.interface.law.jumps:
                at = force[own], slip[own], compliance[own], self.bounds.of(own)
                loose = slipping_points(*at) & ~self._slips[k]
                self._slips[k] |= loose
                any_loose |= bool(loose.any())
        if any_loose:
            self.bounds = self._at_speed(np.zeros_like(self._speed))
        return any_loose

    def _speed_of(self, slip: Array) -> Array:
        """Speed (m/s) of slips in a step, (m, d-1)."""
        return np.sqrt(np.sum(slip**2, axis=1)) / self._step

    def _at_speed(self, speed: Array) -> Bounds:
        """Bounds by the speed of slip of all points, m/s."""
        points, mu = self._points, self.bounds.mu
        parts = zip(points.links, points.own, self._pasts, self._slips, strict=True)
        return joined_bounds(
            [
                link.interface.bounds_followed(past, mu[own], speed[own], slips)
                for link, own, past, slips in parts
            ]
        )


MOST_FRICTION_ROUNDS = 50
"""Times that friction may follow the speeds that it leads to in a correction, at most."""

STEADYING = 0.99
"""Part of their difference that forces of rigid points keep from step to step where no motion tells
it (two corners that push against each other): with nothing to hold them back such forces grow until
their round-off shows, so they become even step by step."""


NOTHING_NEAR, OTHERS_NEAR, LEFT_OPEN, UNSETTLED, SETTLED = range(5)
"""What can become of a correction's contact problem, as `meshed.settle` says: no point is near;
others are than those whose compliance there is; its free values are there, and it is left to the
caller; no method settled it; it is solved."""


class OthersNear(NamedTuple):
    """Points that are near where they are not those of an operator.

    Attributes:
        number: Their numbers, rising.
    """

    number: Indices


class StepContact:
    """Forces of all contact points in one step.

    Attributes:
        force: Point forces f of the present iterate, (points, d), N.
        friction: Bounds of friction.
        beds: How the beds below all points give way; None where there are none.
        rest: Gaps from which points are not pushed out, (points,), m; None where all are 0.
        softening: How rigid points give way; None where there are none. It acts on what forces
            differ by from those at the start; in equilibrium, from those before each correction.
        largest: Largest norm of the contact forces so far, N.
    """

    def __init__(self, model: ContactModel, balance: Balance):
        """Start from what contact remembers."""
        points, memories = model.points, balance.contact
        self._points, self._local, self._weight = points, model.local, balance.contact_weight
        self._margin = model.margin
        self.force: Array = copied([memory.force for memory in memories])
        self._anchor = joined([memory.anchor for memory in memories])
        self._may_touch = joined([memory.may_touch for memory in memories])
        self.friction = FrictionBounds(points, memories, step=balance.step, glued=balance.glued)
        self.softening, held = model.softening, self.force
        if model.softening is not None and not balance.static:
            self.softening = model.softening.in_step(model.system, points, balance.load)
            held = STEADYING * self.force
        self.rest = points.rest(memories)
        self.beds = points.beds(memories, balance.step)
        bed = points.no_bed if self.beds is None else self.beds.softness
        self.largest = 0.0
        self._near = np.empty(points.count, dtype=np.int64)  # filled in with near points
        of_points = self._margin.distance, self._may_touch, self._anchor, points.softness
        # What `settle` is given of all points, in its order.
        self._of_points = *of_points, held, bed, points.round_off, self.force, self._near

    def tell_slips(self, y: Array) -> None:
        """Let friction follow the slips of the free step to augmented positions y."""
        if not self.friction.steady:
            self.friction.tell(self._slips(y))

    def breaks_loose(self, y: Array, compliance: Array) -> bool:
        """Let points slip that do at augmented positions y; whether any did not before.

        By what the force at a point moves it by, (points,), m/N.
        """
        if self.friction.steady:
            return False
        return self.friction.break_loose(self.force, self._slips(y), compliance)

    def _slips(self, y: Array) -> Array:
        """Slips of all points at augmented positions y, (points, d-1), m."""
        return y[:, 1:] - self._anchor + self._points.softness[:, None] * self.force[:, 1:]

    def settle(self, y: Array, operator: Delassus) -> Array | OthersNear | None:
        """Let the forces obey the contact law after the free step to augmented positions y.

        Returns how much those of the operator's points changed, (m, d), N; where others are near,
        these, and None where no point is: nothing changed then.

        Raises:
            NoContactSolution: The local problem was settled by no method.
        """
        W, near = operator.W, operator.near.number
        shape = W.shape[:2]
        change, q = np.empty(shape), np.empty(shape)
        alone = not self._points.decays and q.size <= MANY_ROWS
        mu, cohesion, _ = self.friction.bounds
        how = mu, cohesion, alone, self._local.counts
        outcome, count, squares = meshed.settle(
            y, near, W, operator.softening, *self._of_points, *how, q, change
        )
        if outcome == OTHERS_NEAR:
            return OthersNear(self._near[:count].copy())
        if outcome == NOTHING_NEAR:
            return None
        if outcome == UNSETTLED:
            raise NoContactSolution(f"the local contact problem of {count} points did not settle")
        if outcome == LEFT_OPEN:
            squares = self._settle_in_rounds(operator, q, change)
        self.largest = max(self.largest, self._weight * math.sqrt(squares))
        return change

    def sinks_in(self, y: Array) -> bool:
        """True if points that were never near sink in at augmented positions y."""
        points = self._points
        return meshed.sinks_in(y, points.round_off, self._may_touch, self._margin.seen)

    def _settle_in_rounds(self, operator: Delassus, q: Array, change: Array) -> float:
        """Settle a problem of many points, or one whose friction follows the motion.

        By its free values q, (m, d), m; fills in the change of forces, (m, d), N, and returns the
        sum of their squares, N2.
        """
        near, W = operator.near.number, operator.W
        force = self.force.take(near, axis=0)
        for _ in range(MOST_FRICTION_ROUNDS):
            force = self._local.solve(W, q, force, self.friction.bounds.of(near), near)
            if not self.friction.follows(near, W, q, force):
                break
        return meshed.take_over(self.force, near, force, change)
