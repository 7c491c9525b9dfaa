"""The balance of forces that a step or an equilibrium solves, its solution, and what follows.

In equilibrium a mass term holds the rigid motions of the tangent.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from solver.bodies.body import Body
from solver.bodies.rigid_body import DenseBody
from solver.contact.body_points import SurfaceState
from solver.contact.kinematics import ContactIncrement, ContactKinematics, ForceWeights, Observed
from solver.contact.memory import Dissipation, Memory
from solver.contact.pairs import Link
from solver.law.friction import Bounds
from solver.parallel import global_sums
from solver.scheme.generalized_alpha import GeneralizedAlpha, TangentWeights
from solver.stepping.attached import AttachedForces, StepAttached
from solver.stepping.convergence import ResidualTolerance
from solver.stepping.interfaces import StepStart
from solver.stepping.ledger import StepEnds, energies
from solver.stepping.point_table import joined
from solver.stepping.state import RotationPrediction, State
from solver.stepping.system import System
from solver.types import Array

RESIDUAL_TOLERANCE = 1e-8
"""Residual that counts as zero, over the loads, where it balances itself on every body."""

RESULTANT_TOLERANCE = 3e-10
"""Acceleration of a body by the resultant of a residual that counts as zero, over the largest that
loads of the same norm give a body, some twice that of gravity: momentum that a step leaves out is
gone, while stress out of balance is taken in by the next step."""

STAGNANT_TOLERANCE = 1e-9
"""Residual over the loads that may be round-off where it no longer falls."""

ROUND_OFFS = 3.0
"""Least residual that counts as zero, over the estimate of its round-off: round-off is to decide
nothing. In the demo and on every kind of foundation, in the plane and in space, what is left when
no correction helps is 0.3 to 1.3 of the estimate."""


class Balance(NamedTuple):
    """Balance for u: internal forces + mass M (u - start - way) + constant = contact."""

    contact: Sequence[Memory]
    """Memory of each interface that the step starts from, in the frame of the step."""
    weights: Sequence[TangentWeights]
    """Weights of the tangent of each body."""
    constant: Array
    """Loads, inertia of the old state (owned unknowns), N."""
    load: Array
    """The loads alone; a residual is small or large in relation to them."""
    start: Array
    """u_n, m."""
    way: Array | None
    """dt v_n, m; None in equilibrium, where the mass term only steadies the tangent."""
    rotations: Sequence[Array | None]
    """Rotations of all bodies at t_n, (d, d) each; None in equilibrium."""
    step: float = np.inf
    """dt, s, for the speed of slip; infinite in equilibrium."""
    glued: bool = False
    """True if closed points hold any friction."""
    attached: StepAttached | None = None
    """Links and forces on bodies; None without any."""

    @property
    def static(self) -> bool:
        """True if it is an equilibrium."""
        return self.way is None

    @property
    def contact_weight(self) -> float:
        """w_c, the same for all bodies."""
        return self.weights[0].contact

    def tolerance(self, system: System, guess: Array) -> ResidualTolerance:
        """Residuals that count as zero: a part of the forces, or round-off of the stresses.

        Displacements at both ends of the step, the guess (m) among them, make the round-off: a body
        that comes down without loads may touch just where its displacement is zero.
        """
        reached = np.maximum(np.abs(guess), np.abs(self.start))
        squares: list[float] = []
        for body, own, weights in zip(system.bodies, system.slices, self.weights, strict=True):
            load, constant = self.load[own], self.constant[own]
            squares += float(load.dot(load)), float(constant.dot(constant))
            squares.append(body.round_off(reached[own], weights))
        squares = global_sums(system.comm, squares)
        loads, inertias, rough = squares[::3], squares[1::3], squares[2::3]  # of each body
        if self.attached is not None:
            pulls = self.attached.round_off(len(system.bodies), self.contact_weight)
            rough = [own + more**2 for own, more in zip(rough, pulls, strict=True)]
        given = loads if any(loads) else inertias
        scale, least = math.sqrt(sum(given)), ROUND_OFFS * math.sqrt(sum(rough))
        accelerations = [
            max(
                RESULTANT_TOLERANCE * math.sqrt(body.unknowns * square),
                ROUND_OFFS * math.sqrt(left),
            )
            / body.mass
            for body, square, left in zip(system.bodies, given, rough, strict=True)
        ]
        return ResidualTolerance(
            norm=max(RESIDUAL_TOLERANCE * scale, least),
            acceleration=max(accelerations),
            round_off=max(STAGNANT_TOLERANCE * scale, least),
        )

    def smooth_residual(self, system: System, u: Array) -> tuple[Array, Array]:
        """Out-of-balance force at the displacement u (m) without that of contact, N.

        And M (u - start - way), kg m, from which its inertia is made; zero in equilibrium.
        """
        # Not from u_n + dt v_n: far from the origin that sum loses the digits of the difference.
        travel, static = None, self.way is None
        if self.way is not None:
            travel = u - self.start
            travel -= self.way
        forces, momenta = [], []
        for body, own, weights in zip(system.bodies, system.slices, self.weights, strict=True):
            # Internal forces are new arrays, which are added to here.
            force, constant = body.internal_force(u[own], static=static), self.constant[own]
            if force is None:
                force = constant.copy()
            else:
                force += constant
            if travel is not None:
                momentum = body.inertia(travel[own])
                momenta.append(momentum)
                force += weights.mass * momentum
            if body.has_spring:
                force += _spring(body, weights, u[own], None if travel is None else travel[own])
            forces.append(force)
        return joined(forces), joined(momenta) if momenta else np.zeros(u.shape)


def _spring(body: Body, weights: TangentWeights, u: Array, travel: Array | None) -> Array:
    """The averaged force of a spring and dashpot to the ground, which there is."""
    moved = weights.interface * u
    if travel is not None:
        moved += (weights.spring - weights.interface) * travel
    spring = body.spring(moved)
    assert spring is not None
    return spring


class Contact(NamedTuple):
    """One interface at the end of a step.

    Attributes:
        surface: Its points.
        kinematics: Their gaps and tangential positions.
        force: Point forces f, (points, d), N.
        bounds: Bounds of friction at all points.
        own: What the force at a point moves it by, (points,), m/N.
    """

    surface: SurfaceState
    kinematics: ContactKinematics
    force: Array
    bounds: Bounds
    own: Array

    @property
    def seen(self) -> Observed:
        """Its points, and where they are."""
        return self.surface, self.kinematics


class StepSolution(NamedTuple):
    """The solution of a balance."""

    u: Array
    """Displacement of the owned unknowns, m."""
    contacts: Sequence[Contact]
    """Interfaces and point forces."""
    residual: Array
    """Rest of the out-of-balance force, N."""
    inertia: Array
    """M (u - u_n - dt v_n), kg m; zero in equilibrium."""
    iterations: int
    """Corrections that it took."""
    held: Array
    """The residual at the unknowns that do not move, `System.fixed`, N."""
    on_places: AttachedForces | None = None
    """What links and forces do; None without any."""


class Step(NamedTuple):
    """Data of a step that are settled before it is solved.

    Attributes:
        dt: Length, s.
        scheme: Time stepping, damped after a change of contact.
        start: Contact at its start.
        load: Mean of gravity and of the accelerated ground, N.
        turning: How bodies turn in it.
        p: Inertia forces of t_n, turned to the middle of the step, N.
        rotations: Rotations of all bodies at t_n, (d, d) each.
        attached: Links and forces on bodies; None without any.
    """

    dt: float
    scheme: GeneralizedAlpha
    start: StepStart
    load: Array
    turning: RotationPrediction
    p: Array
    rotations: Sequence[Array]
    attached: StepAttached | None = None


def balance_of(
    system: System, state: State, step: Step, weights: Sequence[TangentWeights]
) -> Balance:
    """The balance of a step; bodies keep the start of it."""
    scheme, dt = step.scheme, step.dt
    af, am, beta = scheme.alpha_f, scheme.alpha_m, scheme.beta
    weighted = scheme.contact_weight * step.load
    constant = (am - (1 - am) * (0.5 - beta) / beta) * step.p - weighted
    for body, own in system.members:
        body.begin_step(state.u[own], scheme, dt)
    for body, own in system.tied:
        drag, spring = body.drag(state.v[own]), body.spring(state.u[own])
        if drag is not None:
            constant[own] += scheme.contact_weight * drag
        if spring is not None:
            constant[own] += af * spring
    load = weighted
    if step.attached is not None:
        load = step.attached.with_loads(weighted, scheme.contact_weight)
    return Balance(
        contact=step.start.contacts,
        weights=weights,
        constant=constant,
        load=load,
        start=state.u,
        way=dt * state.v,
        rotations=step.rotations,
        step=dt,
        attached=step.attached,
    )


def extrapolated(system: System, state: State, turning: RotationPrediction) -> Array:
    """The displacement after a step in which bodies turn as they did, and nothing else acts."""
    bodies = zip(system.bodies, system.slices, turning.angles, strict=True)
    return joined(
        [
            body.extrapolated(
                state.u[own],
                state.v[own],
                turning.step,
                angle,
                state.rigid_motion(system, number),
            )
            for number, (body, own, angle) in enumerate(bodies)
        ]
    )


def turned(system: System, p: Array, vectors: Sequence[Array]) -> Array:
    """Inertia forces turned with their bodies, by an angle or rotation vector each.

    A step weighs those of its ends against one another, and forces of strain in its middle: in
    the frame of the middle no torque comes of it.
    """
    bodies = zip(system.bodies, system.slices, vectors, strict=True)
    return joined([body.turned(p[own], vector) for body, own, vector in bodies])


def impulsive_forces(system: System, u: Array, dt: float) -> list[Array | None]:
    """Forces of all bodies that a step of length dt (s) to u does not average; None: there is none.

    Of meshed bodies that is C du/dt by strain rates.
    """
    return [body.impulsive_force(u[own], dt) for body, own in system.members]


def inertia_force(
    system: System,
    links: Sequence[Link],
    state: State,
    step: Step,
    ends: StepEnds,
    contacts: Sequence[Contact],
    on_places: AttachedForces | None = None,
) -> Array:
    """p_{n+1} = M a_tot less impulses/(2 beta), in the frame of the middle of the step.

    Forces of supports are not in it: those rows are for `ground_forces`, and to be 0 afterwards.
    """
    scheme, dt = step.scheme, step.dt
    impulse = 0.5 / scheme.beta
    p: Array = np.divide(ends.inertia, scheme.beta * dt**2)
    p -= (impulse - 1) * step.p
    for own, rates in zip(system.slices, ends.impulsive, strict=True):
        if rates is not None:
            p[own] += impulse * rates
    for body, own in system.tied:
        drag = body.drag(ends.mean[own])
        if drag is not None:
            p[own] += impulse * drag
    p -= impulse * step.load
    weights = ForceWeights.of(contact=1.0, traction=0.0, sign=-impulse)
    for link, memory, c in zip(links, step.start.contacts, contacts, strict=True):
        increment = ContactIncrement(memory.seen, c.seen, c.force)
        link.interface.add_forces(increment, system.parts(p, link), weights)
    if step.attached is not None and on_places is not None:
        step.attached.add_forces(p, on_places, -impulse)
    return p


def remembered(
    links: Sequence[Link], old: Sequence[Memory], contacts: Sequence[Contact], dt: float
) -> tuple[list[Memory], Dissipation]:
    """Memories of all interfaces after a step of length dt (s), and what it lost in all of them."""
    memories, lost = [], []
    for link, before, c in zip(links, old, contacts, strict=True):
        after = link.interface.remember(before, *c, dt)
        memories.append(after[0])
        lost.append(after[1])
    return memories, Dissipation(*map(sum, zip(*lost, strict=True)))


def static_weights(bodies: Sequence[Body], steady: float) -> list[TangentWeights]:
    """Weights of equilibrium: a mass term holds the rigid motions of the tangent."""
    stiffness = max(body.rigidity for body in bodies) or 1.0
    return [
        TangentWeights(
            mass=steady * stiffness / body.mass,
            stiffness=1.0,
            interface=1.0,
            contact=1.0,
            spring=1.0,
        )
        for body in bodies
    ]


def consistent(system: System, links: Sequence[Link], state: State) -> State:
    """Fill in p_0 = -F(u_0) and the energies of a state."""
    forces, held = np.zeros(system.size), np.zeros(system.size)
    for body, own in system.members:
        u = state.u[own]
        body.begin_static(u)
        internal, spring = body.internal_force(u, static=True), body.spring(u)
        for force in (internal, spring):
            if force is not None:
                forces[own] += force
        if not isinstance(body, DenseBody) and spring is not None:
            held[own] = -spring
    weights = ForceWeights.of(contact=1.0, traction=1.0, sign=-1.0)
    for link, memory in zip(links, state.contacts, strict=True):
        if link.interface.theta:
            increment = ContactIncrement(memory.seen, memory.seen, np.zeros_like(memory.force))
            link.interface.add_forces(increment, system.parts(forces, link), weights)
    held[system.fixed] = -forces[system.fixed]
    forces[system.fixed] = 0.0
    stored = energies(system, state.u, state.v)
    return state._replace(
        p=-forces,
        held=held,
        kinetic=stored.kinetic,
        strain=stored.strain,
        spring=stored.spring,
    )
