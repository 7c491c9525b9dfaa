"""Steps of bodies in contact: start, advance, and the energy ledger of each step."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import replace
from functools import lru_cache

import numpy as np

from solver.bodies.elastic_body import ElasticBody
from solver.contact.candidates import ContactPair
from solver.contact.crossing_interface import CrossingInterface
from solver.contact.events import contact_changed
from solver.contact.interface import Memory, carry_over
from solver.excitation.motion import GroundMotion
from solver.law.local_problem import LocalProblem
from solver.parallel import any_rank
from solver.scheme.generalized_alpha import GeneralizedAlpha, TangentWeights
from solver.stepping.contact_points import joined
from solver.stepping.contact_solve import Balance, ContactSolve, StepSolution, add_contact_forces
from solver.stepping.impulses import VelocityImpulses
from solver.stepping.ledger import StepLedger, energies
from solver.stepping.state import Exchange, State
from solver.stepping.system import Link, System
from solver.stepping.turning import Turning
from solver.types import Array


class StepFailed(Exception):
    """The nonlinear solve of a step did not converge."""


class Stepper:
    """Time stepping of all bodies of a scene."""

    def __init__(
        self,
        system: System,
        contacts: Sequence[ContactPair],
        scheme: GeneralizedAlpha,
        *,
        gravity: Array,
        ground: GroundMotion | None = None,
        velocity_solve: bool = True,
        petsc_options: Sequence[str] = (),
    ):
        """Set the solver up.

        Args:
            system: The bodies.
            contacts: Who may touch whom, and with which of its faces.
            scheme: Time stepping.
            gravity: Acceleration of gravity, (d,), m/s2.
            ground: Motion of the ground; None for ground at rest.
            velocity_solve: Whether contact is also solved at velocity level after each step.
            petsc_options: Options for SNES.
        """
        self.system, self.scheme, self._contacts = system, scheme, tuple(contacts)
        self.gravity = gravity
        motion = ground or GroundMotion((None,) * system.dimension)
        self.base = motion.acceleration
        """Acceleration of the ground at a time, (d,), m/s2."""
        self.mean_base = lru_cache(maxsize=1)(motion.mean)  # a step asks several times
        """Mean acceleration of the ground over a step: its start and length, m/s2."""
        self._weights = lru_cache(
            lambda scheme, dt: [body.weights(scheme, dt) for body in system.bodies]
        )
        self.velocity_solve = velocity_solve
        self.local = LocalProblem(system.dimension)
        # A step may go without its velocity solve: it is not worth the slow methods.
        self.velocity_local = LocalProblem(system.dimension, patience=1)
        self._petsc_options = tuple(petsc_options)
        self._resources = ExitStack()

    def _join(self, facing: Sequence[frozenset[int]]) -> None:
        """Build the interfaces of these faces of each contact; tangents change with them."""
        self.links: tuple[Link, ...] = tuple(
            Link(contact.join(faces), contact.body, contact.carrier)
            for contact, faces in zip(self._contacts, facing, strict=True)
        )
        self._rigid = [self.system.rigid(link) for link in self.links]
        for link in self.links:
            body = None if link.body is None else self.system.bodies[link.body]
            if link.interface.theta and isinstance(body, ElasticBody):
                body.stiffen(link.interface.theta_matrix(body.mass_matrix))
        self._resources.close()
        self._solve = ContactSolve(self.system, self.links, self.local, self._petsc_options)
        self._resources.callback(self._solve.destroy)
        self._impulses: VelocityImpulses | None = None

    def _turn(self, state: State, dt: float) -> None:
        """Before a step: let faces join that turned to their carriers, choose points of corners.

        The interface energy that this loses is kept in the state, also where the step then fails;
        it is added to what contact dissipates.
        """
        turned = [self._rotation(state, contact.body) for contact in self._contacts]
        facing = [c.facing(rotation) for c, rotation in zip(self._contacts, turned, strict=True)]
        if any(f != c.joined for f, c in zip(facing, self._contacts, strict=True)):
            before, links = self.interface_energy(state), self.links
            self._join(facing)
            state.contacts = [
                carry_over(memory, old.interface, new.interface, self._fresh(new, state.u))
                for memory, old, new in zip(state.contacts, links, self.links, strict=True)
            ]
            state.exchanged += before - self.interface_energy(state)
        ahead, part = state.u, self.system.part
        if any(link.interface.carrier.turns for link in self.links):
            ahead = state.u + 0.5 * dt * state.v  # the frame of the step is that of its middle
        for link, memory, rotation in zip(self.links, state.contacts, turned, strict=True):
            carrier = None
            if isinstance(link.interface, CrossingInterface):
                link.interface.prepare(memory, part(ahead, link.body), part(ahead, link.carrier))
            elif link.carrier is not None and link.interface.carrier.turns:
                carrier = self.system.rotation(ahead, link.carrier)
            state.exchanged += link.interface.rotate_frame(memory, rotation, carrier)

    def _rotation(self, state: State, body: int | None) -> Array:
        """The rotation of a body, (d, d); that of the ground is none."""
        if body is None:
            return np.eye(self.system.dimension)
        return state.rigid_motion(self.system, body).rotation

    def _fresh(self, link: Link, u: Array) -> Memory:
        """Memory of an interface without contact forces."""
        system = self.system
        rotation = system.rotation(u, link.body)
        carried = system.part(u, link.carrier)
        return link.interface.start(system.part(u, link.body), carried, rotation)

    def interface_energy(self, state: State) -> float:
        """Energy stored in all interfaces, J."""
        pairs = zip(self.links, state.contacts, strict=True)
        return sum(link.interface.energy(memory) for link, memory in pairs)

    def start(self, u: Array, v: Array, time: float = 0.0) -> State:
        """A state whose inertia balances stresses, without loads and contact forces (r_0 = 0)."""
        for contact in self._contacts:
            if contact.carrier is not None:
                contact.surface.rotate_frame(self.system.rotation(u, contact.carrier))
        self._join([c.facing(self.system.rotation(u, c.body)) for c in self._contacts])
        contacts = [self._fresh(link, u) for link in self.links]
        return self._consistent(State(time, u, v, np.zeros_like(u), contacts))

    def launch(self, state: State, v: Array) -> State:
        """The same state with other velocities."""
        return self._consistent(State(state.time, state.u, v, state.p, state.contacts))

    def static_start(
        self,
        u: Array,
        time: float = 0.0,
        *,
        load: Array | None = None,
        start: State | None = None,
        glued: bool = False,
        steady: float = 1e-7,
    ) -> State:
        """Gravity and loads in equilibrium with contact, at rest; the ground begins to move after.

        Args:
            u: Where the search begins.
            time: s.
            load: Forces on the owned unknowns besides gravity, N; they belong to this start alone.
            start: A state whose contact memory is gone on from (loads that come one after another).
            glued: Whether friction holds whatever it takes: where a block is about to slide, this
                is what holds it until it is let go.
            steady: Stiffness of the tangent against rigid motions of a body, over that against
                strain. Small ones cost the contact forces as many digits, of large ones each
                correction leaves a part in the error.

        Raises:
            StepFailed: Where there is no equilibrium.
        """
        state = start or self.start(u, np.zeros_like(u), time)
        system = self.system
        for body, own in zip(system.bodies, system.slices, strict=True):
            body.begin_static(u[own])
        gravity = self.gravity @ system.directional_mass
        total = gravity if load is None else gravity + load
        balance = Balance(
            contact=state.contacts,
            weights=self._static_weights(steady),
            constant=-total,
            load=total,
            start=u,
            way=None,
            rotations=[None] * len(system.bodies),
            glued=glued,
        )
        solution = self._solved(balance, u)
        contacts = [
            link.interface.remember(memory, c.surface, c.seat, c.force, c.bounds)[0]
            for link, memory, c in zip(self.links, state.contacts, solution.contacts, strict=True)
        ]
        self.system.settle(solution.u)
        return self._consistent(State(time, solution.u, np.zeros_like(u), state.p, contacts))

    def _static_weights(self, steady: float) -> list[TangentWeights]:
        """Weights of equilibrium: a mass term holds the rigid motions of the tangent."""
        stiffness = max(
            (body.rigidity for body in self.system.bodies if isinstance(body, ElasticBody)),
            default=1.0,
        )
        return [
            TangentWeights(
                mass=steady * stiffness / body.mass,
                stiffness=1.0,
                interface=1.0,
                contact=1.0,
                spring=1.0,
            )
            for body in self.system.bodies
        ]

    def _consistent(self, state: State) -> State:
        """Fill in p_0 = -F(u_0) and the energies of a state."""
        system = self.system
        forces = np.zeros(system.size)
        for body, own in zip(system.bodies, system.slices, strict=True):
            u = state.u[own]
            body.begin_static(u)
            for force in (body.internal_force(u, static=True), body.spring(u)):
                if force is not None:
                    forces[own] += force
        for link, memory in zip(self.links, state.contacts, strict=True):
            if link.interface.theta:
                nothing = np.zeros_like(memory.force)
                seen = memory.surface, memory.seat
                add_contact_forces(
                    *(system, link, memory, seen, nothing, forces),
                    traction_weight=1.0,
                    contact_weight=1.0,
                    sign=-1.0,
                )
        forces[system.fixed] = 0.0
        state.p = -forces
        state.kinetic, state.strain, state.spring = energies(system, state)
        return state

    def _load(self, time: float, dt: float) -> Array:
        """Body forces of gravity and of the accelerated ground, mean over a step, N.

        From the ground's velocity: no impulse goes missing, whatever the step.
        """
        return (self.gravity - self.mean_base(time, dt)) @ self.system.directional_mass

    def _solved(self, balance: Balance, guess: Array) -> StepSolution:
        """Solve, or say why not."""
        solution = self._solve.solve(balance, guess)
        if not solution.outcome.converged:
            raise StepFailed(
                f"SNES: {solution.outcome.reason}, residual {solution.outcome.residual:.2e} N"
            )
        return solution

    def advance(self, state: State, dt: float) -> tuple[State, Exchange]:
        """One step of length `dt`.

        Raises:
            StepFailed: `state` can then be tried again with another step.
        """
        scheme = self.scheme.damped if state.unsettled else self.scheme
        system = self.system
        self._turn(state, dt)
        af, am, beta = scheme.alpha_f, scheme.alpha_m, scheme.beta
        load = self._load(state.time, dt)
        weighted = scheme.contact_weight * load
        motions = [state.rigid_motion(system, number) for number in range(len(system.bodies))]
        turning = Turning.of([motion.spin for motion in motions], dt, state.turning)
        half = turning.halves
        start = replace(state, p=self._turned(state.p, half))
        constant = (am - (1 - am) * (0.5 - beta) / beta) * start.p - weighted
        for body, own in zip(system.bodies, system.slices, strict=True):
            body.begin_step(state.u[own], scheme, dt)
            drag, spring = body.drag(state.v[own]), body.spring(state.u[own])
            if drag is not None:
                constant[own] += scheme.contact_weight * drag
            if spring is not None:
                constant[own] += af * spring
        way = dt * state.v
        extrapolated = [
            body.extrapolated(state.u[own], state.v[own], dt, motion)
            for body, own, motion in zip(system.bodies, system.slices, motions, strict=True)
        ]
        balance = Balance(
            contact=state.contacts,
            weights=self._weights(scheme, dt),
            constant=constant,
            load=weighted,
            start=state.u,
            way=way,
            rotations=[motion.rotation for motion in motions],
            step=dt,
        )
        solution = self._solved(balance, joined(extrapolated))
        new, exchange = self._update(start, dt, solution, load, scheme)
        system.settle(new.u)
        new.p, new.turning = self._turned(new.p, half), turning
        new.unsettled = max(state.unsettled - 1, 0)
        changed = contact_changed(state.contacts, new.contacts, self._rigid)
        if any_rank(system.comm, changed):
            new.unsettled = self.scheme.damped_steps
        exchange.contact += state.exchanged
        exchange.iterations = solution.outcome.iterations
        return new, exchange

    def _turned(self, p: Array, vectors: Sequence[Array]) -> Array:
        """Inertia forces turned with their bodies, by an angle or rotation vector each.

        A step weighs those of its ends against one another, and forces of strain in its middle: in
        the frame of the middle no torque comes of it.
        """
        bodies = zip(self.system.bodies, self.system.slices, vectors, strict=True)
        return joined([body.turned(p[own], vector) for body, own, vector in bodies])

    def _update(
        self, state: State, dt: float, solution: StepSolution, load: Array, scheme: GeneralizedAlpha
    ) -> tuple[State, Exchange]:
        """State at t_{n+1} and the ledger of the step."""
        system = self.system
        du = solution.u - state.u
        mean = np.asarray(du / dt)
        v = 2 * mean - state.v
        p = system.inertia(du - dt * state.v)
        p /= scheme.beta * dt**2
        p -= (0.5 / scheme.beta - 1) * state.p
        for body, own in zip(system.bodies, system.slices, strict=True):
            for force in (body.impulsive_force(dt), body.drag(mean[own])):
                if force is not None:
                    p[own] += 0.5 / scheme.beta * force
        p -= 0.5 / scheme.beta * load
        contacts, friction, lost = [], 0.0, 0.0
        for link, memory, c in zip(self.links, state.contacts, solution.contacts, strict=True):
            add_contact_forces(
                *(system, link, memory, (c.surface, c.seat), c.force, p),
                traction_weight=0.0,
                contact_weight=1.0,
                sign=-0.5 / scheme.beta,
            )
            after, loss = link.interface.remember(memory, c.surface, c.seat, c.force, c.bounds)
            contacts.append(after)
            friction, lost = friction + loss.friction, lost + loss.contact
        p[system.fixed] = 0.0
        new = State(state.time + dt, solution.u, v, p, contacts)
        ledger = StepLedger(self, state, new, dt, scheme.skew)
        exchange = ledger.exchange(solution.residual)
        exchange.friction, exchange.contact = friction, lost
        if self.velocity_solve:
            self._correct_velocity(new, solution, dt, exchange)
        return new, exchange

    def _correct_velocity(
        self, new: State, solution: StepSolution, dt: float, exchange: Exchange
    ) -> None:
        """Solve contact at velocity level and book what it takes."""
        if not any((c.force[:, 0] > 0).any() for c in solution.contacts):
            return
        if self._impulses is None:
            self._impulses = VelocityImpulses(self.system, self.links, self.velocity_local)
        correction = self._impulses.correct(new, solution.contacts, dt)
        if correction is None:
            return
        new.v = new.v + correction.change
        new.kinetic -= correction.contact + correction.friction
        exchange.contact += correction.contact
        exchange.friction += correction.friction
