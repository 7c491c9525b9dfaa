"""The nonlinear problem of a step, and its solution by SNES, one step after another.

The residual is the exact nonlinear one. The tangent of a meshed body is that of the undeformed one,
turned with the rotation R of the body (K(u) = R K_0 R^T up to terms of the size of the strain), so
that a correction costs one back substitution and one small contact problem, which couples all
bodies:

    du_f = -K^-1 r,    f = solution of the local problem with W = w_c sum over bodies G K^-1 G^T,
    du = du_f + w_c K^-1 G^T df.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from solver.bodies.memory import kept_limit
from solver.bodies.rigid_body import DenseBody
from solver.contact.kinematics import ContactIncrement, ContactKinematics, ForceWeights, Observed
from solver.contact.memory import Memory
from solver.contact.pairs import Link
from solver.law.local_problem import LocalProblem, NoContactSolution
from solver.parallel import any_rank, global_sums
from solver.scheme.generalized_alpha import TangentWeights
from solver.stepping.active_set import ContactMargin, EdgeWatch, points_beyond
from solver.stepping.attached import Attached, AttachedForces
from solver.stepping.balance import Balance, Contact, StepSolution
from solver.stepping.delassus import (
    Delassus,
    Softening,
    Tangents,
    assembled,
    of_no_points,
    own_compliance,
)
from solver.stepping.link_correction import LinkCorrection
from solver.stepping.nonlinear import NonlinearSolver
from solver.stepping.point_table import PointTable, copied, joined
from solver.stepping.response import CandidateSet, Kinematics, repeat_compliances, saved_compliances
from solver.stepping.step_contact import ContactModel, OthersNear, StepContact
from solver.stepping.system import System, response_of
from solver.types import Array, Indices, Mask

PLACED_CORRECTIONS = 2
"""Corrections of a step with new positions of the bodies: later ones hardly turn them."""


NO_POINTS: Indices = np.empty(0, dtype=np.int64)
"""Numbers of no points."""


def kinematics_of_places(d: int) -> ContactKinematics:
    """What bodies see of places at which links act: they stand in the frame of space."""
    nowhere: Array = np.empty((0, d))
    return ContactKinematics(nowhere, nowhere, np.eye(d))


class StepFailed(Exception):
    """The nonlinear solve of a step did not converge, or its solution is none of the method's."""


class InterfaceInStep(NamedTuple):
    """What of an interface stays the same from one residual of a step to the next.

    Attributes:
        link: The interface, and its bodies.
        start: Its memory that the step starts from.
        force: Its part of the point forces, which corrections write to, (points, d), N.
        weights: How they count in a residual.
    """

    link: Link
    start: Memory
    force: Array
    weights: ForceWeights


class StepProblem:
    """A balance as SNES sees it, with the point forces of the iterate.

    Attributes:
        contact: Forces of all contact points, and the law that they obey.
        held: Residual of the iterate at the unknowns that do not move, N.
        inertia: M (u - u_n - dt v_n) at the iterate, kg m; zero in equilibrium.
    """

    def __init__(self, model: ContactModel, tangents: Tangents, balance: Balance, guess: Array):
        """Start from what contact remembers and a guess of the displacement of all owned unknowns.

        `tangents` is what the bodies offer, with the Delassus operator of earlier corrections.
        """
        self._model, self._tangents, self._balance = model, tangents, balance
        self._points, self._system = model.points, model.system
        self._static, self._weight = balance.static, balance.contact_weight
        self.contact = StepContact(model, balance)
        self._edges = EdgeWatch(model.points, balance.contact)
        self._beyond: Mask | None = None
        self._interfaces = self._in_step()
        # Of each body its response, where its unknowns are, and its rotation at t_n.
        starts = model.system.slices, balance.rotations
        self._bodies = tuple(zip(tangents.responses, *starts, strict=True))
        operator = tangents.operator
        if operator is not None and model.points.turning.take(operator.contacts).any():
            tangents.operator = None
        # At the iterate: its displacement, the state of each interface, and kinematics.
        self._u = guess
        self._seen: list[Observed] = []
        self._kinematics: Kinematics = []
        self._configurations: Sequence[Any] = ()
        self._corrections = 0
        self.held: Array = np.empty(0)
        self.inertia: Array = self.held
        self._residual: Array = self.held
        self._attached = balance.attached
        self._linked = () if balance.attached is None else balance.attached.attached.linked
        self._places = sum(member.points.count for member in self._linked)
        self._of_places = [kinematics_of_places(model.system.dimension)] if self._places else []
        self.on_places: AttachedForces | None = None
        """What links and forces do at the iterate; None without any."""

    @property
    def forces(self) -> float:
        """Largest norm of the contact forces so far, or of those of links, N."""
        if self.on_places is None:
            return self.contact.largest
        links = self._weight * float(np.linalg.norm(self.on_places.links.force))
        return max(self.contact.largest, links)

    def residual(self, u: Array) -> Array:
        """Out-of-balance force at u with the current point forces, N."""
        residual, self.inertia = self._balance.smooth_residual(self._system, u)
        seen, parts = [], self._system.parts
        for link, start, force, weights in self._interfaces:
            found = link.interface.observe(*parts(u, link), start)
            # In equilibrium what is seen counts at both ends.
            increment = ContactIncrement(found if self._static else start.seen, found, force)
            link.interface.add_forces(increment, parts(residual, link), weights)
            seen.append(found)
        if self._attached is not None:
            self.on_places = on_places = self._attached.at(u)
            self._attached.add_forces(residual, on_places, -self._weight)
        fixed = self._system.fixed
        if len(fixed):
            self.held = residual.take(fixed)
            residual.put(fixed, 0.0)
        self._u, self._seen = u, seen
        self._kinematics = [*(kinematics for _, kinematics in seen), *self._of_places]
        self._residual = residual
        return residual

    def _in_step(self) -> list[InterfaceInStep]:
        """The interfaces, and what stays the same of them."""
        balance, points, found = self._balance, self._points, []
        for link, start, own in zip(points.links, balance.contact, points.own, strict=True):
            tangent = balance.weights[link.body or 0]
            weights = ForceWeights.of(tangent.contact, tangent.interface, sign=-1.0)
            found.append(InterfaceInStep(link, start, self.contact.force[own], weights))
        return found

    def acceleration(self) -> float:
        """Largest acceleration that the resultant of that force gives a body, m/s2.

        On rigid bodies all of it is resultant, moments by the metre.
        """
        system, d = self._system, self._system.dimension
        sums: list[float] = []
        for body, own in system.members:
            force = self._residual[own]
            if isinstance(body, DenseBody):  # one rank has all of it, the others nothing
                sums += math.sqrt(force @ force), *[0.0] * (d - 1)
            else:
                sums += map(float, body.resultant(force))
        sums = global_sums(system.comm, sums)
        return max(
            math.hypot(*sums[d * k : d * (k + 1)]) / body.mass
            for k, body in enumerate(system.bodies)
        )

    def correction(self, residual: Array) -> Array:
        """Free step, local contact problem, and the response to the change of the point forces."""
        self._corrections += 1
        if self._corrections <= PLACED_CORRECTIONS:
            u = self._u
            self._configurations = [response.at(u[own], was) for response, own, was in self._bodies]
        y, self._beyond = self._positions(), self._edges.beyond(self._kinematics)
        if self._places:
            y = np.concatenate([y, np.zeros((self._places, y.shape[1]))])
        free = []
        for (response, own, _), at in zip(self._bodies, self._configurations, strict=True):
            free.append(response.free(at, residual[own]))
            response.read(at, free[-1], y, self._kinematics)
        settled = self._settled_with_links if self._places else self._settled
        delassus, change = settled(y)
        found = []
        for k, (response, _, _) in enumerate(self._bodies):
            moved = response.at_rest() if change is None else self._moved_by(delassus, change, k)
            found.append(response.owned(self._configurations[k], free[k], moved))
        return joined(found)

    def _moved_by(self, operator: Delassus, force: Array, body: int) -> Array:
        """The motion of a body by forces at the points of an operator, (m, d), N."""
        response, at = self._bodies[body][0], self._configurations[body]
        how = operator.couplings[body], operator.near, force, self._weight
        return response.moved_by(at, *how)

    def _settled_with_links(self, y: Array) -> tuple[Delassus, Array]:
        """Let point forces and links obey their laws after the free step to y of points and places.

        Returns the operator and the change of forces at its points.
        """
        assert self._attached is not None and self.on_places is not None
        forces, before, count = self.contact.force, self.contact.force.copy(), self._points.count
        links = LinkCorrection(self._attached, self.on_places, y[count:])
        operator = self._operator()
        while True:
            positions = y.copy()
            answer = links.answer(operator, None)
            for number in (member.body for member in self._linked):
                response, at = self._bodies[number][0], self._configurations[number]
                moved = self._moved_by(operator, answer, number)
                response.read(at, moved, positions, self._kinematics)
            operator, change = self._settled(positions[:count], links)
            force = links.answer(operator, change)
            if links.settled():
                return operator, force
            forces[:] = before

    def _positions(self) -> Array:
        """Augmented positions of all points at the iterate, from their rest gaps.

        With what is left of beds' compression. A copy: it is written to.
        """
        y: Array = copied([seen.augmented for _, seen in self._seen])
        if self.contact.beds is not None:
            y[:, 0] += self.contact.beds.offset
        if self.contact.rest is not None:
            y[:, 0] -= self.contact.rest
        return y

    def _settled(
        self, y: Array, links: LinkCorrection | None = None
    ) -> tuple[Delassus, Array | None]:
        """Let the point forces obey the contact law after the free step to y.

        Points beyond an edge are put far from their carrier in y, whatever their gap: a foot far
        beyond an edge goes to and fro with the face. Links give way. Returns the operator of the
        points that are near, and the change of their forces, (m, d), N; None where none is near.
        """
        self._deactivate(y)
        self.contact.tell_slips(y)
        operator = self._operator()
        while True:
            alone = operator if links is None else links.condensed(operator)
            change = self.contact.settle(y, alone)
            if not isinstance(change, OthersNear):
                return operator, change
            self._model.margin.mark_seen(change.number)
            operator = self._tangents.operator = self._delassus(change.number)

    def _operator(self) -> Delassus:
        """The operator made last, with all bodies as they are at the iterate.

        That of no contact point before the first one.
        """
        operator = self._tangents.operator
        if operator is not None and operator.fits(self._tangents.responses, self._configurations):
            return operator
        near = NO_POINTS if operator is None else operator.contacts
        if not (len(near) or self._places):
            return of_no_points(self._system.dimension)
        operator = self._tangents.operator = self._delassus(near)
        return operator

    def _delassus(self, near: Indices) -> Delassus:
        """The operator at some contact points and all places, with bodies as at the iterate."""
        points, seen = self._points, self._kinematics
        number, frames = near, points.frames_at(near, seen[: len(points.links)])
        if self._places:
            number = np.concatenate([near, points.count + np.arange(self._places)])
            unturned = np.tile(np.eye(self._system.dimension), (self._places, 1, 1))
            frames = np.concatenate([frames, unturned])
        return assembled(
            self._tangents.responses,
            self._configurations,
            CandidateSet(number, frames, seen),
            contact_weight=self._weight,
            softness=points.softness,
            beds=self.contact.beds,
            softening=self.contact.softening,
        )

    def continues(self) -> bool:
        """True if u is no solution: points sink in or break loose."""
        y = self._positions()
        self._deactivate(y)
        return self.contact.sinks_in(y) or self.contact.breaks_loose(y, self._own_compliance())

    def _own_compliance(self) -> Array:
        """What the force at a point moves it by, (points,), m/N.

        Points of rigid bodies have no softness of their own, and are moved with their bodies.
        """
        softness, operator = self._points.softness, self._tangents.operator
        if self.contact.friction.steady or operator is None:
            return softness
        own, near = softness.copy(), operator.contacts
        diagonal = own_compliance(operator.W)[: len(near)]
        own[near] = np.where(own[near] > 0.0, own[near], diagonal)
        return own

    def _deactivate(self, y: Array) -> None:
        """Put points beyond an edge as far from their carrier as their body is large, in y."""
        if self._beyond is not None:
            y[self._beyond, 0] = self._points.size[self._beyond]

    def contacts(self) -> list[Contact]:
        """Every interface at the end of the step, after `continues`."""
        found, compliance = [], self._own_compliance()
        for (surface, kinematics), own in zip(self._seen, self._points.own, strict=True):
            force, bounds = self.contact.force[own], self.contact.friction.bounds.of(own)
            found.append(Contact(surface, kinematics, force, bounds, compliance[own]))
        return found


class ContactSolve:
    """Solves balances of the same bodies and interfaces.

    One factorization for each body, step size and rho_inf is kept, with the Delassus operator of
    its last correction. Where they take more than their part of the memory, those are dropped whose
    last use is longest ago.
    """

    def __init__(
        self,
        system: System,
        links: Sequence[Link],
        local: LocalProblem,
        options: Sequence[str],
        attached: Attached | None = None,
    ):
        """Set SNES up for the bodies, their interfaces, and links and forces on them."""
        linked = () if attached is None else attached.linked
        self._places = {member.body: member for member in linked}
        points = PointTable(system, links)
        self._model = ContactModel(
            system=system,
            points=points,
            local=local,
            margin=ContactMargin(points.size),
            softening=Softening.of(system, links, points.softness),
        )
        self._solver = NonlinearSolver(system.comm, system.size, NoContactSolution, options)
        self._tangents: dict[tuple[TangentWeights, ...], Tangents] = {}
        self._strained_at: Array | None = None
        """Displacement that the stiffness of bodies was made anew at, last."""

    def close(self) -> None:
        """Free what PETSc holds; collective."""
        self._solver.close()

    def saved(self) -> dict[str, Any]:
        """State that the digits of further solves depend on, for `resume`."""
        return {
            "tangents": [
                (weights, saved_compliances(tangents.responses), tangents.operator)
                for weights, tangents in self._tangents.items()
            ],
            "seen": self._model.margin.seen,
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
        self._model.margin.reset(saved["seen"])

    def solve(self, balance: Balance, guess: Array) -> StepSolution:
        """Solve a balance from a guess of the displacement and the last point forces.

        Raises:
            StepFailed: No solution was found.
        """
        margin = self._model.margin
        if balance.static:
            self._hold_touching(balance)
        elif margin.keeps_touching:
            margin.reset(margin.seen)
        tangents = self._tangents_for(tuple(balance.weights))
        problem = StepProblem(self._model, tangents, balance, guess)
        tolerance = balance.tolerance(self._model.system, guess)
        u, outcome = self._solver.solve(problem, guess, tolerance)
        if not outcome.converged and self._restiffens(balance):
            return self.solve(balance, guess)
        iterations = outcome.iterations
        while outcome.converged and problem.continues():
            u, outcome = self._solver.solve(problem, u, tolerance)
            iterations += outcome.iterations
        if not outcome.converged:
            raise StepFailed(f"SNES: {outcome.reason}, residual {outcome.residual:.2e} N")
        return StepSolution(
            u=u,
            contacts=problem.contacts(),
            residual=self._solver.residual,
            inertia=problem.inertia,
            iterations=iterations,
            held=problem.held,
            on_places=problem.on_places,
        )

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
            beyond = points_beyond(carrier, memory.kinematics)
            if beyond is not None:
                may_touch[own] &= ~beyond
        gaps = joined([memory.kinematics.place[:, 0] for memory in memories])
        self._model.margin.keep_active(gaps, may_touch)

    def _was_strained_at(self, start: Array) -> bool:
        """True if the stiffness was made anew at this very displacement; collective."""
        before = self._strained_at
        another = before is None or not np.array_equal(before, start)
        return not any_rank(self._model.system.comm, another)

    def _tangents_for(self, weights: tuple[TangentWeights, ...]) -> Tangents:
        """Responses of the bodies for a step size and rho_inf."""
        if weights not in self._tangents:
            self._make_room()
            system, links = self._model.system, self._model.points.links
            responses = [
                response_of(
                    system, number, links, body.factorization(own), own, self._places.get(number)
                )
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
                body.forget(own)
