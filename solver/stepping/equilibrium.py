"""Balance without motion: weights of an equilibrium, and states whose inertia balances stresses."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from solver.bodies.dense_body import DenseBody
from solver.contact.kinematics import ContactIncrement, ForceWeights
from solver.scheme.generalized_alpha import TangentWeights
from solver.stepping.ledger import energies
from solver.stepping.state import State
from solver.stepping.system import Body, Link, System


def static_weights(bodies: Sequence[Body], steady: float) -> list[TangentWeights]:
    """Weights of equilibrium: a mass term holds the rigid motions of the tangent."""
    stiffness = max(
        (body.rigidity for body in bodies if not isinstance(body, DenseBody)),
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
            standing = ContactIncrement(memory.seen, memory.seen, np.zeros_like(memory.force))
            link.interface.add_forces(standing, system.parts(forces, link), weights)
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
