"""SNES with the contact problem condensed inside its correction, for one step after another."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from solver.bodies.factorization import Inverse
from solver.bodies.memory import kept_limit
from solver.bodies.rigid_body import DenseBody
from solver.law.local_problem import LocalProblem, NoContactSolution
from solver.parallel import any_rank
from solver.scheme.generalized_alpha import TangentWeights
from solver.stepping.active_set import Reach, points_beyond
from solver.stepping.balance import Balance, StepSolution
from solver.stepping.delassus import Softening, Tangents
from solver.stepping.model import ContactModel
from solver.stepping.nonlinear import NonlinearSolver
from solver.stepping.point_table import PointTable, copied, joined
from solver.stepping.response import repeat_compliances, saved_compliances
from solver.stepping.step_contact import compile_law
from solver.stepping.step_problem import StepProblem
from solver.stepping.system import Body, Link, System, response_of
from solver.types import Array


class ContactSolve:
    """Solves balances of the same bodies and interfaces.

    One factorization for each body, step size and rho_inf is kept, with the Delassus operator of
    its last correction. Where they take more than their part of the memory, those are dropped whose
    last use is longest ago.
    """

    def __init__(
        self, system: System, links: Sequence[Link], local: LocalProblem, options: Sequence[str]
    ):
        """Set SNES up for the bodies and their interfaces."""
        points = PointTable(system, links)
        compile_law(system.dimension, in_rounds=points.decays)
        self._model = ContactModel(
            system=system,
            points=points,
            local=local,
            reach=Reach(points.size),
            softening=Softening.of(system, links, points.softness),
        )
        self._solver = NonlinearSolver(system.comm, system.size, NoContactSolution, options)
        self._tangents: dict[tuple[TangentWeights, ...], Tangents] = {}
        self._strained_at: Array | None = None
        """Displacement that the stiffness of bodies was made anew at, last."""

    def destroy(self) -> None:
        """Free what PETSc holds; collective."""
        self._solver.destroy()

    def saved(self) -> dict[str, Any]:
        """What the digits of further solves depend on, for `resume`."""
        return {
            "tangents": [
                (weights, saved_compliances(tangents.responses), tangents.operator)
                for weights, tangents in self._tangents.items()
            ],
            "met": self._model.reach.met,
            "strained_at": self._strained_at,
        }

    def resume(self, saved: dict[str, Any]) -> None:
        """Go on as another solve of the same bodies would from where it was saved; collective."""
        self._strained_at = saved["strained_at"]
        self._tangents.clear()
        for weights, compliances, operator in saved["tangents"]:
            tangents = self._tangents_for(weights)
            repeat_compliances(tangents.responses, compliances)
            tangents.operator = operator
        self._model.reach.meet_again(saved["met"])

    def solve(self, balance: Balance, guess: Array) -> StepSolution:
        """Solve a balance from a guess of the displacement and the last point forces."""
        reach = self._model.reach
        if balance.static:
            self._hold_touching(balance)
        elif reach.holding:
            reach.meet_again(reach.met)
        tangents = self._tangents_for(tuple(balance.weights))
        problem = StepProblem(self._model, tangents, balance, guess)
        tolerance = balance.tolerance(self._model.system, guess)
        u, outcome = self._solver.solve(problem, guess, tolerance)
        if not outcome.converged and self._restiffens(balance):
            return self.solve(balance, guess)
        while outcome.converged and problem.continues(u):
            before = outcome.iterations
            u, outcome = self._solver.solve(problem, u, tolerance)
            outcome = outcome._replace(iterations=outcome.iterations + before)
        if outcome.converged and problem.sleepers.overran:
            outcome = outcome._replace(converged=False, reason="bodies move too far in one step")
        contacts = problem.contacts() if outcome.converged else []
        residual = self._solver.residual
        return StepSolution(u, contacts, residual, problem.inertia, outcome, problem.held)

    def _restiffens(self, balance: Balance) -> bool:
        """Give meshed bodies the stiffness of the strained state of a step that failed, once."""
        system, start = self._model.system, balance.start
        if balance.static or not system.meshed or self._was_strained_at(start):
            return False
        self._strained_at = start
        changed = [body.restiffen(start[own]) for body, own in system.meshed]
        if any(changed):
            self._tangents.clear()
        return any(changed)

    def _hold_touching(self, balance: Balance) -> None:
        """Let all points that touch count in an equilibrium, wherever corrections lead them.

        Nothing but contact holds the bodies of a stack. If only the lowest points were known to be
        near, those above would fall far beyond anything that makes sense.
        """
        memories, points = balance.contact, self._model.points
        may_touch = copied([memory.may_touch for memory in memories])
        for own, memory, carrier in zip(points.own, memories, points.carriers, strict=True):
            beyond = points_beyond(carrier, memory)
            if beyond is not None:
                may_touch[own] &= ~beyond
        gaps = joined([memory.kinematics.place[:, 0] for memory in memories])
        self._model.reach.hold(gaps, may_touch)

    def _was_strained_at(self, start: Array) -> bool:
        """Whether the stiffness was made anew at this very displacement; collective."""
        before = self._strained_at
        another = before is None or not np.array_equal(before, start)
        return not any_rank(self._model.system.comm, another)

    def _tangents_for(self, weights: tuple[TangentWeights, ...]) -> Tangents:
        """What the bodies offer for a step size and rho_inf."""
        if weights not in self._tangents:
            self._make_room()
            system, links = self._model.system, self._model.points.links
            responses = [
                response_of(system, number, links, _factor(body, own), own)
                for number, (body, own) in enumerate(zip(system.bodies, weights, strict=True))
            ]
            self._tangents[weights] = Tangents(responses)
        found = self._tangents.pop(weights)
        self._tangents[weights] = found  # the one used last stands last
        return found

    def _make_room(self) -> None:
        """Drop the tangents used least recently, where one more would be too many; collective."""
        comm = self._model.system.comm
        for weights in list(self._tangents):
            kept = [tangents.nbytes for tangents in self._tangents.values()]
            if sum(kept) + max(kept) <= kept_limit(comm):
                return
            del self._tangents[weights]
            for body, own in zip(self._model.system.bodies, weights, strict=True):
                if not isinstance(body, DenseBody):
                    body.forget(own)


def _factor(body: Body, weights: TangentWeights) -> Inverse | Array:
    """The factorized tangent of a meshed body; the diagonal of a rigid one's."""
    if isinstance(body, DenseBody):
        return body.tangent(weights)
    return body.factorization(weights)
