"""What a step consists of: what is settled before it is solved, its balance, and what follows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from solver.contact.kinematics import ContactIncrement, ForceWeights
from solver.contact.memory import NOTHING_LOST, Dissipation, Memory
from solver.scheme.generalized_alpha import GeneralizedAlpha, TangentWeights
from solver.stepping.balance import Balance, Contact
from solver.stepping.interfaces import StepStart
from solver.stepping.ledger import StepEnds
from solver.stepping.point_table import joined
from solver.stepping.state import State, Turning
from solver.stepping.system import Link, System
from solver.types import Array


class Step(NamedTuple):
    """What is settled of a step before it is solved.

    Attributes:
        dt: Length, s.
        scheme: Time stepping, damped after a change of contact.
        start: Contact at its start.
        load: Mean of gravity and of the accelerated ground, N.
        turning: How bodies turn in it.
        p: Inertia forces of t_n, turned to the middle of the step, N.
        rotations: Rotations of all bodies at t_n, (d, d) each.
    """

    dt: float
    scheme: GeneralizedAlpha
    start: StepStart
    load: Array
    turning: Turning
    p: Array
    rotations: Sequence[Array]


def balance_of(
    system: System, state: State, step: Step, weights: Sequence[TangentWeights]
) -> Balance:
    """The balance of a step; bodies are told what they start from."""
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
    return Balance(
        contact=step.start.contacts,
        weights=weights,
        constant=constant,
        load=weighted,
        start=state.u,
        way=dt * state.v,
        rotations=step.rotations,
        step=dt,
    )


def extrapolated(system: System, state: State, turning: Turning) -> Array:
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
        if c.is_unseen(memory):
            continue
        increment = ContactIncrement(memory.seen, c.seen, c.force)
        link.interface.add_forces(increment, system.parts(p, link), weights)
    return p


def remembered(
    links: Sequence[Link], old: Sequence[Memory], contacts: Sequence[Contact], dt: float
) -> tuple[list[Memory], Dissipation]:
    """Memories of all interfaces after a step of length dt (s), and what it lost in all of them."""
    memories, lost = [], []
    for link, before, c in zip(links, old, contacts, strict=True):
        if c.is_unseen(before):
            memories.append(before.until(c.clear))
            continue
        after = link.interface.remember(before, c.surface, c.kinematics, c.force, c.bounds, dt)
        memories.append(after[0].until(c.clear) if c.clear else after[0])
        lost.append(after[1])
    return memories, Dissipation(*map(sum, zip(NOTHING_LOST, *lost, strict=True)))
