"""The nonlinear problem of one step, solved with one factorization per body, step size and rho_inf.

The residual is the exact nonlinear one. The tangent of a meshed body is that of the undeformed one,
turned with the body's rotation R (K(u) = R K_0 R^T up to terms of the size of the strain), so that
a correction costs one back substitution and one small contact problem, which couples all bodies:

    du_f = -K^-1 r,    f = solution of the local problem with W = w_c sum over bodies G K^-1 G^T,
    du = du_f + w_c K^-1 G^T df.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from solver.bodies.dense_body import DenseBody
from solver.bodies.factorization import Factorization
from solver.contact.body_points import SurfaceState
from solver.contact.interface import Memory
from solver.contact.nitsche_points import same
from solver.contact.projection import ContactKinematics
from solver.law.local_problem import LocalProblem, NoContactSolution, image
from solver.parallel import global_sum
from solver.scheme.generalized_alpha import TangentWeights
from solver.stepping.contact_points import AllPoints, Contact
from solver.stepping.nonlinear import NewtonOutcome, NonlinearSolver
from solver.stepping.response import CandidateSet, Response
from solver.stepping.system import Body, Link, System, response_of
from solver.types import Array, Indices

TOLERANCE = 1e-9
"""Of the residual over the loads."""

FOLLOWED = 50
"""How often a correction looks at the speeds that friction of these speeds leads to."""

PLACED = 2
"""Corrections of a step that look where bodies are: later ones turn them no more to speak of."""

SOFTENING = 1e-9
"""Relative diagonal of W for points between rigid bodies: makes their forces unique."""

LIGHT = 1e-12
"""The same where one of the two is meshed. Its elasticity tells how forces are shared, but is as
small as that beside the motion of a light body as a whole; with more, corrections would creep."""

EVENING = 0.99
"""Forces of rigid points of which no motion tells (two corners that push against each other) become
even step by step: with nothing to hold them back they grow until their round-off shows."""

FINE = 1e4
"""The weight of a rigid body over what round-off of the places of its points on another one means
for their forces, at least."""

NONE: Array = np.zeros(0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Balance:
    """What is solved for u: internal forces + mass M (u - start - way) + constant = contact.

    Attributes:
        contact: Memory of each interface that the step starts from.
        weights: Of the tangent of each body.
        constant: Loads, inertia of the old state (owned unknowns), N.
        load: The loads alone; a residual is small or large in relation to them.
        start: u_n, m.
        way: dt v_n, m; None in equilibrium, where the mass term only steadies the tangent.
        rotations: Of all bodies at t_n, (d, d) each; None in equilibrium.
        step: dt, s, for the speed of slip; infinite in equilibrium.
        glued: Whether closed points hold any friction.
    """

    contact: Sequence[Memory]
    weights: Sequence[TangentWeights]
    constant: Array
    load: Array
    start: Array
    way: Array | None
    rotations: Sequence[Array | None]
    step: float = np.inf
    glued: bool = False


@dataclass(frozen=True, slots=True)
class StepSolution:
    """Displacement, interfaces and point forces that balance, and how SNES came to them.

    `residual` is what is left of the out-of-balance force.
    """

    u: Array
    contacts: Sequence[Contact]
    residual: Array
    outcome: NewtonOutcome


class ContactSolve:
    """SNES with the contact problem condensed inside its correction."""

    def __init__(
        self, system: System, links: Sequence[Link], local: LocalProblem, options: Sequence[str]
    ):
        """Set SNES up for the bodies and their interfaces."""
        self.system, self.local = system, local
        self._points = AllPoints(system, links)
        functions = self._residual, self._correct, NoContactSolution
        self._solver = NonlinearSolver(system.comm, system.size, *functions, options)
        self._responses: dict[tuple[TangentWeights, ...], list[Response]] = {}
        self._response: list[Response] = []
        self._coupled: list[Response] = []
        self._turns = any(link.interface.carrier.turns for link in links)
        softening = [np.full(link.interface.count, _softening(system, link)) for link in links]
        self._softening = np.where(self._points.softness > 0, 0.0, np.concatenate(softening))
        self._pairs = [
            (link, own)
            for link, own in zip(links, self._points.own, strict=True)
            if system.rigid(link)
        ]
        self._softened = bool(self._softening.any())
        self._held = self._least = NONE
        self._near: Indices = np.empty(0, dtype=np.int64)
        self._corrections = 0
        self._strained: Array | None = None

    def destroy(self) -> None:
        """Free what PETSc holds; collective."""
        self._solver.destroy()

    def solve(self, balance: Balance, guess: Array) -> StepSolution:
        """Solve a balance from a guess of the displacement and the last point forces."""
        self._balance, points = balance, self._points
        static = balance.way is None
        points.begin(balance.contact, guess, step=balance.step, static=static, glued=balance.glued)
        if self._softened:
            self._held = NONE if static else EVENING * points.force
            self._least = NONE if static else self._least_softness(balance.load)
        self._response = self._responses_for(tuple(balance.weights))
        for response, rotation in zip(self._response, balance.rotations, strict=True):
            response.begin(rotation)
        # W of points on planes that stand or only move along is the same as long as the bodies are.
        self._stale = self._turns
        self._corrections = 0
        u, outcome = self._solver.solve(guess, self._tolerance(guess))
        if not outcome.converged and self._restiffens(balance):
            return self.solve(balance, guess)
        while outcome.converged and (points.wake(u) or points.break_loose()):
            before = outcome.iterations
            u, outcome = self._solver.solve(u, self._tolerance(guess))
            outcome = replace(outcome, iterations=outcome.iterations + before)
        seen = points.contacts(u) if outcome.converged else []
        return StepSolution(u, seen, self._solver.residual, outcome)

    def _restiffens(self, balance: Balance) -> bool:
        """Give meshed bodies the stiffness of the strained state of a step that failed, once."""
        meshed = [
            (body, own)
            for body, own in zip(self.system.bodies, self.system.slices, strict=True)
            if not isinstance(body, DenseBody)
        ]
        if balance.way is None or self._strained is balance.start or not meshed:
            return False
        self._strained = balance.start
        changed = [body.restiffen(balance.start[own]) for body, own in meshed]
        if any(changed):
            self._responses.clear()
        return any(changed)

    def _responses_for(self, weights: tuple[TangentWeights, ...]) -> list[Response]:
        """What the bodies offer for a step size."""
        if weights not in self._responses:
            bodies = zip(self.system.bodies, weights, strict=True)
            self._responses[weights] = [
                response_of(self.system, k, self._points.links, _factor(body, own), own)
                for k, (body, own) in enumerate(bodies)
            ]
        return self._responses[weights]

    def _least_softness(self, load: Array) -> Array:
        """Of the points between rigid bodies: round-off of places is to mean little force."""
        least = np.zeros(len(self._softening))
        for link, own in self._pairs:
            weights = [
                float(np.linalg.norm(body.replicate(load[self.system.slices[number]])))
                for number, body in enumerate(self.system.bodies)
                if number in (link.body, link.carrier) and isinstance(body, DenseBody)
            ]
            lightest = min((weight for weight in weights if weight > 0), default=math.inf)
            round_off = float(np.finfo(float).eps) * link.interface.size
            least[own] = FINE * round_off / lightest
        return least

    def _tolerance(self, u: Array) -> float:
        """Residual that counts as zero: a fraction of the forces, or round-off of the stresses."""
        balance, system = self._balance, self.system
        load, constant = balance.load, balance.constant
        round_off = sum(
            body.round_off(u[own], weights)
            for body, own, weights in zip(
                system.bodies, system.slices, balance.weights, strict=True
            )
        )
        squares = global_sum(system.comm, np.array([load @ load, constant @ constant, round_off]))
        weight, inertia, least = (math.sqrt(value) for value in squares)
        return max(TOLERANCE * (weight or inertia), least)

    def _residual(self, u: Array) -> Array:
        """Out-of-balance force at u with the current point forces."""
        balance, system = self._balance, self.system
        self._u, static = u, balance.way is None
        residual = balance.constant.copy()
        # Not from u_n + dt v_n: far from the origin that sum loses the digits of the difference.
        travel = None if balance.way is None else u - balance.start - balance.way
        for body, own, weights in zip(system.bodies, system.slices, balance.weights, strict=True):
            part = residual[own]
            internal = body.internal_force(u[own], static=static)
            if internal is not None:
                part += internal
            if travel is not None:
                inertia = body.inertia(travel[own])
                inertia *= weights.mass
                part += inertia
            self._add_spring(body, weights, part, u[own], None if travel is None else travel[own])
        points = self._points
        points.seen = []
        for number, memory in enumerate(balance.contact):
            if points.asleep[number]:
                points.seen.append((memory.surface, memory.seat))
            else:
                points.seen.append(points.look(number, u))
                self._push(number, residual)
        residual[system.fixed] = 0.0
        return residual

    @staticmethod
    def _add_spring(
        body: Body, weights: TangentWeights, part: Array, u: Array, travel: Array | None
    ) -> None:
        """Add the averaged force of a spring and dashpot to the ground, where there is one."""
        spring = body.spring(u)
        if spring is None:
            return
        part += weights.interface * spring
        dashpot = None if travel is None else body.spring(travel)
        if dashpot is not None:
            part += (weights.spring - weights.interface) * dashpot

    def _push(self, number: int, residual: Array) -> None:
        """Subtract the forces of an interface on both its bodies."""
        points, balance = self._points, self._balance
        link, memory, seen = points.links[number], balance.contact[number], points.seen[number]
        if balance.way is None:
            memory = replace(memory, surface=seen[0], seat=seen[1])
        weights = balance.weights[link.body or 0]
        add_contact_forces(
            *(self.system, link, memory, seen, points.force[points.own[number]], residual),
            traction_weight=weights.interface,
            contact_weight=weights.contact,
            sign=-1.0,
        )

    def _correct(self, residual: Array) -> Array:
        """Free step, local contact problem, and the response to the change of the point forces."""
        system, points = self.system, self._points
        seats = [seat for _, seat in points.seen]
        y = points.augmented()
        free = []
        self._corrections += 1
        for response, own in zip(self._response, system.slices, strict=True):
            if self._corrections <= PLACED and response.at(self._u[own]):
                self._stale = True
            free.append(response.free(residual[own]))
            response.read(y, points.frames, seats)
        near = points.near(y)
        if len(near):
            force = points.force[near]
            W = self._delassus(near, seats)
            near = self._near  # the same numbers, known by the same array
            # W holds the interface's own softness too, which is no part of y.
            q = y[near] - image(W, force) + force * points.softness[near, None]
            if len(self._held):
                # That of rigid points acts on what forces differ by from those of the last step.
                q += self._soft[:, None] * (force - self._held[near])
            q[:, 1:] -= points.anchor[near]
            if not force.any():  # nothing tells that a gap of round-off is small
                q[np.abs(q[:, 0]) < points.round_off[near], 0] = 0.0
            new = self._solve_with_friction(W, q, force, y)
            points.force[near] = new
            for k, response in enumerate(self._response):
                change = response.respond(self._place, new - force, self._contact_weight)
                if change is not None:
                    free[k] = free[k] + change
        return free[0] if len(free) == 1 else np.concatenate(free)

    def _solve_with_friction(self, W: Array, q: Array, force: Array, y: Array) -> Array:
        """Forces of the near points, of a friction that fits the slip they allow."""
        points, near = self._points, self._near
        bounds = points.bounds_at(near, y)
        for _ in range(FOLLOWED):
            force = self.local.solve(W, q, force, bounds)
            following = points.follow(near, q, W, force)
            if following is None:
                break
            bounds = following
        return force

    @property
    def _contact_weight(self) -> float:
        """w_c, the same for all bodies."""
        return self._balance.weights[0].contact

    def _delassus(self, near: Indices, seats: Sequence[ContactKinematics]) -> Array:
        """W (m, d, m, d) with the interface's softness."""
        points = self._points
        if same(near, self._near):
            near = self._near  # known by the same array
        # Steps of another size or rho_inf may have gone by without any point near.
        if self._stale or near is not self._near or self._response is not self._coupled:
            m, d = len(near), self.system.dimension
            self._place = CandidateSet(near, points.frames_at(near), seats)
            W = np.zeros((m, d, m, d))
            for response in self._response:
                response.couple(self._place, self._contact_weight, W)
            soft = points.softness[near]
            if self._softened:
                self._soft = self._softening[near] * np.einsum("ijij->ij", W).max(axis=1)
                if len(self._least):
                    self._soft = np.maximum(self._soft, self._least[near])
                soft = soft + self._soft
            number = np.arange(m)
            for k in range(d):
                W[number, k, number, k] += soft
            self._near, self._turned, self._stale = near, W, False
            self._coupled = self._response
        return self._turned


def _softening(system: System, link: Link) -> float:
    """Of the points of an interface that have no softness of their own."""
    return SOFTENING if system.rigid(link) else LIGHT


def _factor(body: Body, weights: TangentWeights) -> Factorization | Array:
    """The factorized tangent of a body; the diagonal of a rigid one's."""
    if isinstance(body, DenseBody):
        return body.tangent(weights)
    return body.factorization(weights)


def add_contact_forces(
    system: System,
    link: Link,
    memory: Memory,
    seen: tuple[SurfaceState, ContactKinematics],
    force: Array,
    target: Array,
    *,
    traction_weight: float,
    contact_weight: float,
    sign: float,
) -> None:
    """Add the forces of one interface on both its bodies to a vector of owned unknowns.

    Args:
        system: All bodies.
        link: The interface and its bodies.
        memory: Of t_n.
        seen: Surface and seat at t_{n+1}.
        force: Point forces f, (points, d), N.
        target: Forces of all owned unknowns, changed in place.
        traction_weight: 1 - alpha_f for the theta term of Nitsche's method, 0 to leave it out.
        contact_weight: w_c.
        sign: 1, or -1 to subtract.
    """
    interface, (surface, seat) = link.interface, seen
    vectors, reaction = interface.point_forces(memory.seat, seat, (sign * contact_weight) * force)
    pull = None
    if interface.theta:
        pull = sign * interface.traction_pull(
            memory.surface, surface, force, traction_weight, contact_weight
        )
    if link.body is not None:
        own = target[system.slices[link.body]]
        interface.points.add_forces(own, memory.surface, surface, vectors, pull)
    if link.carrier is not None and reaction is not None:
        carrier, points = target[system.slices[link.carrier]], interface.carrier.points
        before, after = memory.seat.carrier, seat.carrier
        assert points is not None and before is not None and after is not None
        points.add_forces(carrier, before, after, reaction)
