"""The nonlinear problem of one step, solved with one factorization per body.

The residual is the exact nonlinear one. The tangent of a meshed body is that of the undeformed body,
turned with the body's rotation R (K(u) = R K_0 R^T up to terms of the size of the strain), so that a
correction costs one back substitution and one small contact problem, which couples all bodies:

    du_f = -K^-1 r,    f = solution of the local problem with W = w_c sum over bodies G K^-1 G^T,
    du = du_f + w_c K^-1 G^T df.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from solver.contact.carriers import Seat
from solver.contact.friction import Bounds
from solver.contact.interface import Memory
from solver.contact.local_problem import LocalProblem, NoContactSolution, image, row_sum_scaling
from solver.contact.points import SurfaceState
from solver.contact.response import Near, Response
from solver.contact.surfaces import Seen
from solver.dynamics.generalized_alpha import TangentWeights
from solver.dynamics.nonlinear import NonlinearSolver, Outcome
from solver.dynamics.system import Body, Link, System, response_of
from solver.mechanics.dense_body import DenseBody
from solver.mechanics.factorization import Factorization
from solver.parallel import global_sum

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

TOLERANCE = 1e-9

GLUE = 1e6
"""Coefficient of friction that holds anything."""

SOFTENING = 1e-9
"""Relative diagonal of W for points of rigid bodies: their forces are not unique without it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Balance:
    """The balance of forces to be solved for u: internal + mass M (u - drift) + constant = contact.

    Attributes:
        contact: Memory of each interface that the step starts from.
        weights: Of the tangent of each body.
        constant: Loads, inertia of the old state (owned unknowns), N.
        load: The loads alone; a residual is small or large in relation to them.
        drift: u_n + dt v_n, m; None in equilibrium, where the mass term only steadies the tangent.
        step: dt, s, for the speed of slip; infinite in equilibrium.
        glued: Whether closed points hold any friction.
    """

    contact: Sequence[Memory]
    weights: Sequence[TangentWeights]
    constant: Array
    load: Array
    drift: Array | None
    step: float = np.inf
    glued: bool = False


@dataclass(frozen=True, slots=True)
class Contact:
    """One interface at the end of a step."""

    surface: Seen
    seat: Seat
    force: Array
    bounds: Bounds


@dataclass(frozen=True, slots=True)
class Solution:
    """Displacement, interfaces and point forces that balance, and how SNES came to them.

    `residual` is what is left of the out-of-balance force.
    """

    u: Array
    contacts: Sequence[Contact]
    residual: Array
    outcome: Outcome


class ContactSolve:
    """SNES with the contact problem condensed inside its correction."""

    def __init__(
        self, system: System, links: Sequence[Link], local: LocalProblem, options: Sequence[str]
    ):
        """Set SNES up for the bodies and their interfaces."""
        self.system, self.links, self.local = system, tuple(links), local
        counts = [link.interface.count for link in links]
        self._first = np.concatenate([[0], np.cumsum(counts)]).astype(int)
        self._own = [slice(*ends) for ends in zip(self._first[:-1], self._first[1:], strict=True)]
        functions = self._residual, self._correct, NoContactSolution
        self._solver = NonlinearSolver(system.comm, system.size, *functions, options)
        self._responses: dict[tuple[TangentWeights, ...], list[Response]] = {}
        self.softness = np.concatenate([link.interface.softness for link in links])
        # Whether friction depends on neither speed nor the past.
        self._steady = all(link.interface.law.constant for link in links)
        self._turning = any(link.interface.carrier.turns for link in links)
        self._rigid = self.softness == 0
        self._any_rigid = bool(self._rigid.any())
        # Points farther from their carrier than this after the free step are not pressed into it
        # by the others.
        self._margin = np.concatenate(
            [np.full(n, 0.002 * link.interface.size) for n, link in zip(counts, links, strict=True)]
        )

    def destroy(self) -> None:
        """Free what PETSc holds; collective."""
        self._solver.destroy()

    def solve(self, balance: Balance, guess: Array) -> Solution:
        """Solve a balance from a guess of the displacement and the last point forces."""
        self._balance = balance
        self._force = np.concatenate([memory.force for memory in balance.contact])
        self._anchor = np.concatenate([memory.anchor for memory in balance.contact])
        self._eligible = np.concatenate([memory.eligible for memory in balance.contact])
        self._response = self._responses_for(tuple(balance.weights))
        for response, own in zip(self._response, self.system.slices, strict=True):
            response.begin(guess[own])
        self._frames = [link.interface.carrier.frame for link in self.links]
        self._near: Indices = np.empty(0, dtype=np.int64)
        self._slipped = [memory.slipped for memory in balance.contact]
        self._bounds = self._bounds_of_all(None)
        self._gather_bounds()
        self._asleep = [self._far(k, guess) for k in range(len(self.links))]
        u, outcome = self._solver.solve(guess, self._tolerance(guess))
        while outcome.converged and (self._wakes(u) or self._breaks_loose()):
            before = outcome.iterations
            u, outcome = self._solver.solve(u, self._tolerance(guess))
            outcome = replace(outcome, iterations=outcome.iterations + before)
        contacts = [
            Contact(*self._last_seen(number, u), self._force[own], bounds)
            for number, (own, bounds) in enumerate(zip(self._own, self._bounds, strict=True))
        ]
        return Solution(u, contacts, self._solver.residual, outcome)

    def _far(self, number: int, guess: Array) -> bool:
        """Whether an interface need not be looked at in this step, far from contact as it is.

        Only those without tractions can sleep: the theta term acts on open points, too.
        """
        interface, memory = self.links[number].interface, self._balance.contact[number]
        if interface.theta or memory.force.any() or self._balance.drift is None:
            return False
        return self._clearance(number, guess) > 5 * float(self._margin[self._own[number]][0])

    def _clearance(self, number: int, u: Array) -> float:
        """Smallest gap of an interface's points that may touch, m."""
        link, memory = self.links[number], self._balance.contact[number]
        part = self.system.part
        _, seat = link.interface.observe(part(u, link.body), part(u, link.carrier))
        off = link.interface.carrier.off(seat)
        may = memory.eligible if off is None else memory.eligible & ~off
        return float(np.min(seat.place[may, 0], initial=np.inf))

    def _last_seen(self, number: int, u: Array) -> tuple[Seen, Seat]:
        """Surface and seat of an interface at the end."""
        if not self._asleep[number]:
            return self._seen[number]
        link, part = self.links[number], self.system.part
        return link.interface.observe(part(u, link.body), part(u, link.carrier))

    def _wakes(self, u: Array) -> bool:
        """Whether interfaces that were left out have come into contact after all."""
        woken = [
            number
            for number, asleep in enumerate(self._asleep)
            if asleep and self._clearance(number, u) < 0
        ]
        for number in woken:
            self._asleep[number] = False
        return bool(woken)

    def _bounds_of_all(self, speed: Array | None) -> list[Bounds]:
        """Bounds of friction at all points of each interface."""
        if self._balance.glued:
            return [Bounds.uniform(GLUE, link.interface.count) for link in self.links]
        return [
            link.interface.bounds(memory, slipped, None if speed is None else speed[own])
            for link, memory, slipped, own in zip(
                self.links, self._balance.contact, self._slipped, self._own, strict=True
            )
        ]

    def _breaks_loose(self) -> bool:
        """Points that held on static friction and reached it slip from now on: mu_s to mu_d only.

        True where there are any: their forces are those of the wrong friction then.
        """
        any_loose = False
        for k, (link, own) in enumerate(zip(self.links, self._own, strict=True)):
            if link.interface.jumps:
                loose = link.interface.at_bound(self._force[own], self._bounds[k])
                loose &= ~self._slipped[k]
                if loose.any():
                    self._slipped[k] = self._slipped[k] | loose
                    any_loose = True
        if any_loose:
            self._bounds = self._bounds_of_all(None)
            self._gather_bounds()
        return any_loose

    def _responses_for(self, weights: tuple[TangentWeights, ...]) -> list[Response]:
        """What the bodies offer for a step size."""
        if weights not in self._responses:
            self._responses[weights] = [
                response_of(self.system, number, self.links, _factor(body, weight), tractions=True)
                for number, (body, weight) in enumerate(
                    zip(self.system.bodies, weights, strict=True)
                )
            ]
        return self._responses[weights]

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
        weight, inertia, least = (float(value) for value in np.sqrt(squares))
        return max(TOLERANCE * (weight or inertia), least)

    def _residual(self, u: Array) -> Array:
        """Out-of-balance force at u with the current point forces."""
        balance, system = self._balance, self.system
        static = balance.drift is None
        residual = balance.constant.copy()
        travel = None if balance.drift is None else u - balance.drift
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
        self._seen = []
        for number, (link, memory) in enumerate(zip(self.links, balance.contact, strict=True)):
            if self._asleep[number]:
                self._seen.append((memory.surface, memory.seat))
            else:
                self._push(link, memory, self._force[self._own[number]], u, residual)
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

    def _push(self, link: Link, memory: Memory, force: Array, u: Array, residual: Array) -> None:
        """Look at an interface, and subtract its forces on both bodies."""
        interface, system, balance = link.interface, self.system, self._balance
        carried = system.part(u, link.carrier)
        surface, seat = interface.observe(system.part(u, link.body), carried)
        self._seen.append((surface, seat))
        if balance.drift is None:
            memory = replace(memory, surface=surface, seat=seat)
        weights = balance.weights[link.body or 0]
        add_contact_forces(
            system,
            link,
            memory,
            (surface, seat),
            force,
            residual,
            traction_weight=weights.interface,
            contact_weight=weights.contact,
            sign=-1.0,
        )

    def _correct(self, residual: Array) -> Array:
        """Free step, local contact problem, and the response to the change of the point forces."""
        system, d = self.system, self.system.dimension
        seats = [seat for _, seat in self._seen]
        y = self._augmented()
        free = []
        for response, own in zip(self._response, system.slices, strict=True):
            free.append(response.free(residual[own]))
            response.read(y, self._frames, seats)
        near = np.flatnonzero((y[:, 0] < self._margin) & self._eligible | (self._force[:, 0] > 0))
        if len(near):
            force = self._force[near]
            W, scaling = self._delassus(near, seats)
            # W holds the interface's own softness too, which is no part of y.
            q = y[near] - image(W, force) + force * self._soft[:, None]
            q[:, 1:] -= self._anchor[near]
            new = self.local.solve(W, q, force, self._bounds_at(near, y), scaling)
            self._force[near] = new
            contact = self._balance.weights[0].contact
            for k, response in enumerate(self._response):
                change = response.respond(self._place, new - force, contact)
                if change is not None:
                    free[k] = free[k] + change
        return free[0] if len(free) == 1 else np.concatenate(free)

    def _augmented(self) -> Array:
        """Augmented positions of all points; those beyond an edge are far from their carrier."""
        parts = []
        for link, (surface, seat), asleep in zip(self.links, self._seen, self._asleep, strict=True):
            y = link.interface.augmented(surface, seat)
            if asleep:
                y = np.full_like(y, link.interface.size)
            off = link.interface.carrier.off(seat)
            if off is not None and off.any():
                y = y.copy()
                y[off, 0] = link.interface.size
            parts.append(y)
        return parts[0].copy() if len(parts) == 1 else np.concatenate(parts)

    def _delassus(self, near: Indices, seats: Sequence[Seat]) -> tuple[Array, Array]:
        """W (m, d, m, d) with the interface's softness, and its scaling."""
        if self._turning or not np.array_equal(near, self._near):
            m, d = len(near), self.system.dimension
            frames = np.empty((m, d, d))
            for frame, own in zip(self._frames, self._own, strict=True):
                frames[(near >= own.start) & (near < own.stop)] = frame
            self._place = Near(near, frames, seats)
            W = np.zeros((m, d, m, d))
            contact = self._balance.weights[0].contact
            for response in self._response:
                response.couple(self._place, contact, W)
            self._soft = self.softness[near]
            if self._any_rigid:
                number = np.flatnonzero(self._rigid[near])
                own_compliance = np.einsum("ijij->ij", W)[number]
                self._soft = self._soft.copy()
            number = np.arange(m)
            for k in range(d):
                W[number, k, number, k] += self._soft
            if self._any_rigid:
                rigid = np.flatnonzero(self._rigid[near])
                for k in range(d):
                    W[rigid, k, rigid, k] += SOFTENING * own_compliance.max(axis=1)
            self._near, self._turned = near, (W, row_sum_scaling(W))
            self._near_bounds = None
        return self._turned

    def _bounds_at(self, near: Indices, y: Array) -> Bounds:
        """Bounds of friction at near points, by the slip of the last iterate."""
        if not self._steady:
            slip = y[:, 1:] - self._anchor
            slip += self.softness[:, None] * self._force[:, 1:]
            speed = np.sqrt(np.sum(slip**2, axis=1)) / self._balance.step
            self._bounds = self._bounds_of_all(speed)
            self._gather_bounds()
        elif self._near_bounds is not None:
            return self._near_bounds
        self._near_bounds = Bounds(self._mu[near], self._cohesion[near])
        return self._near_bounds

    def _gather_bounds(self) -> None:
        """Bounds of friction of all interfaces in one array each."""
        self._near_bounds: Bounds | None = None
        self._mu = np.concatenate([bounds.mu for bounds in self._bounds])
        self._cohesion = np.concatenate([bounds.cohesion for bounds in self._bounds])


def _factor(body: Body, weights: TangentWeights) -> Factorization | Array:
    """The factorized tangent of a body; the diagonal of a rigid one's."""
    if isinstance(body, DenseBody):
        return body.tangent(weights)
    return body.factorization(weights)


def add_contact_forces(
    system: System,
    link: Link,
    memory: Memory,
    seen: tuple[Seen, Seat],
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
    vectors, reaction = interface.push(memory.seat, seat, (sign * contact_weight) * force)
    pull = None
    if interface.theta:
        pull = sign * interface.traction_pull(
            memory.surface, surface, force, traction_weight, contact_weight
        )
    if link.body is not None:
        own = target[system.slices[link.body]]
        interface.points.push(own, memory.surface, surface, vectors, pull)
    if link.carrier is not None and reaction is not None:
        carrier, points = target[system.slices[link.carrier]], interface.carrier.points
        before, after = memory.seat.carrier, seat.carrier
        assert points is not None and before is not None and after is not None
        points.push(carrier, before, after, reaction)
