"""The forces of all contact points in one step, and the law that they obey after each free step."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from solver.contact.kernels.candidates import (
    LEFT_OPEN,
    NOTHING_NEAR,
    OTHERS_NEAR,
    UNSETTLED,
    settle,
    sinks_in,
    take_over,
)
from solver.law.compiled import runs_machine_code
from solver.law.friction import Bounds
from solver.law.local_problem import LocalProblem, NoContactSolution, new_counts
from solver.law.many_points import MANY_ROWS
from solver.stepping.balance import Balance
from solver.stepping.delassus import Delassus
from solver.stepping.friction_bounds import FrictionBounds
from solver.stepping.model import ContactModel
from solver.stepping.point_table import copied, joined
from solver.types import Array, Indices

MOST_FRICTION_ROUNDS = 50
"""How often a correction looks at the speeds that friction of these speeds leads to."""

STEADYING = 0.99
"""Part of their difference that forces of rigid points keep from step to step where no motion tells
it (two corners that push against each other): with nothing to hold them back such forces grow until
their round-off shows, so they become even step by step."""


def compile_law(d: int, *, in_rounds: bool) -> None:
    """Let what is compiled of the contact law be compiled, or read back, before time counts.

    `in_rounds`: friction follows the motion in rounds of its own.
    """
    if not runs_machine_code():
        return
    y, near, W = np.zeros((1, d)), np.array([0]), np.eye(d).reshape(1, d, 1, d)
    mask, nothing, reach = np.ones(1, dtype=np.bool_), np.zeros(1), np.ones(1)
    force, q, change = y.copy(), y.copy(), y.copy()
    of_points = reach, mask, y[:, 1:].copy(), nothing, y, nothing, nothing
    filled, bounds = (force, near.copy()), (nothing, nothing)
    how = not in_rounds, new_counts()
    settle(y, near, W, nothing, *of_points, *filled, *bounds, *how, q, change)
    if in_rounds:
        LocalProblem().solve(W, y, y, Bounds.uniform(0.5, 1))
        take_over(force, near, y, change)


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
        self._reach = model.reach
        self.force: Array = copied([memory.force for memory in memories])
        self._anchor = joined([memory.anchor for memory in memories])
        self._may_touch = joined([memory.may_touch for memory in memories])
        self.friction = FrictionBounds(points, memories, step=balance.step, glued=balance.glued)
        self.softening, held = model.softening, self.force
        if model.softening is not None and not balance.static:
            self.softening = model.softening.in_step(model.system, points, balance.load)
            held = STEADYING * self.force
        self.rest: Array | None = None
        if any(np.count_nonzero(memory.rest) for memory in memories):
            self.rest = joined([memory.rest for memory in memories])
        self.beds = points.beds(memories, balance.step)
        bed = points.no_bed if self.beds is None else self.beds.softness
        self.largest = 0.0
        self._near = np.empty(points.count, dtype=np.int64)  # filled in with near points
        of_points = self._reach.distance, self._may_touch, self._anchor, points.softness
        # What `settle` is given of all points, in its order.
        self._of_points = *of_points, held, bed, points.round_off, self.force, self._near

    def tell_slips(self, y: Array) -> None:
        """Let friction follow the slips of the free step to augmented positions y."""
        if not self.friction.steady:
            slip = y[:, 1:] - self._anchor
            self.friction.tell(slip + self._points.softness[:, None] * self.force[:, 1:])

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
        how = *self.friction.of_all(), alone, self._local.counts
        outcome, count, squares = settle(
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
        """Whether points sink in that no correction has looked at, at augmented positions y."""
        points = self._points
        return sinks_in(y, points.round_off, self._may_touch, self._reach.met)

    def _settle_in_rounds(self, operator: Delassus, q: Array, change: Array) -> float:
        """Settle a problem of many points, or one whose friction follows the motion.

        By its free values q, (m, d), m; fills in the change of forces, (m, d), N, and returns the
        sum of their squares, N2.
        """
        near, W = operator.near.number, operator.W
        force = self.force.take(near, axis=0)
        for _ in range(MOST_FRICTION_ROUNDS):
            force = self._local.solve(W, q, force, self.friction.at(near), near)
            if not self.friction.follows(near, W, q, force):
                break
        return take_over(self.force, near, force, change)
