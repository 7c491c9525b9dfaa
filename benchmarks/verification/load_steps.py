"""Sequences of equilibria of bodies in contact: loads, supports that move, contact tractions.

`Stepper.static_start` solves one equilibrium. With `start` it continues from the contact memory of
the equilibrium before, so that loads can follow one another and friction remembers them. This
module adds what such sequences need besides: supports that move, loads that are reached by moving a
support, and contact forces as tractions.

    state = stepper.static_start(u, load=load)                      # press
    for _ in range(5):                                              # then shear, step by step
        u = shifted(stepper, state.u, body=0, by=(0.1 * shift, 0.0))
        state = stepper.static_start(u, load=load, start=state)
    tractions = contact_tractions(stepper.links[0], state.contacts[0])
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from solver.bodies.elastic_body import ElasticBody
from solver.contact.body_points import NitschePoints
from solver.contact.memory import Memory
from solver.contact.pairs import Link
from solver.parallel import global_sum
from solver.stepping.stepper import Stepper
from solver.types import Array, Mask

#: Nodal areas below this part of the largest one are round-off of nodes off the face.
AREA_ROUND_OFF = 1e-9

#: Friction within this part of its limit is at it.
BOUND_ROUND_OFF = 1e-9

#: Relative difference between a load and the contact force that answers it, in `pressed`.
LOAD_TOLERANCE = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class Tractions:
    """Contact forces of a meshed face, point by point, sorted by place on the undeformed body.

    Attributes:
        place: Places of the points on the undeformed body, (points, d), m.
        position: Places of the points in the deformed state, (points, d), m.
        weight: Undeformed length (per metre of thickness) or area of each point, (points,).
        force: Point forces on the body of the points, normal then tangential, (points, d), N.
        slipping: True for points whose friction is at its bound, (points,).
    """

    place: Array
    position: Array
    weight: Array
    force: Array
    slipping: Mask

    @property
    def pressure(self) -> Array:
        """Normal force over undeformed area, (points,), Pa."""
        return self.force[:, 0] / self.weight

    @property
    def shear(self) -> Array:
        """Friction force over undeformed area, (points, d - 1), Pa."""
        return self.force[:, 1:] / self.weight[:, None]

    @property
    def resultant(self) -> Array:
        """Sum of the forces: normal, tangential, (d,), N."""
        return self.force.sum(axis=0)

    @property
    def half_width(self) -> float:
        """Half-width 2 sqrt(sum f x^2 / sum f), m, of a line contact with its middle at x = 0.

        That is the half-width a of the ellipse of pressure with the same second moment, P a^2/4.
        """
        normal = self.force[:, 0]
        return float(2 * np.sqrt(normal @ self.position[:, 0] ** 2 / normal.sum()))


def contact_tractions(link: Link, memory: Memory) -> Tractions:
    """Tractions that an interface transmits.

    Args:
        link: The interface; its points are those of a meshed body.
        memory: Contact memory of the state, `state.contacts[number of the link]`.

    Raises:
        TypeError: For points without area: nodes, or those of rigid bodies.
    """
    points, interface = link.interface.points, link.interface
    if not isinstance(points, NitschePoints):
        raise TypeError(f"contact_tractions: got {type(points).__name__}, allowed NitschePoints")
    order = np.lexsort(points.reference.T[::-1])
    normal, tangential = memory.force[:, 0], np.linalg.norm(memory.force[:, 1:], axis=1)
    limit = interface.bounds(memory.past).mu * normal
    return Tractions(
        place=points.reference[order],
        position=memory.surface.position[order],
        weight=interface.weight[order],
        force=memory.force[order],
        slipping=((normal > 0) & (tangential >= limit * (1 - BOUND_ROUND_OFF)))[order],
    )


def nodal_pressure(link: Link, memory: Memory) -> Array:
    """Normal nodal forces over nodal areas of the undeformed face, (nodes with an area,), Pa.

    The pressure of a single point carries the round-off of its gap times gamma_h; nodal pressures
    do not.

    Args:
        link: The interface; its points are those of a meshed body.
        memory: Contact memory of the state, `state.contacts[number of the link]`.

    Raises:
        TypeError: For points without area: nodes, or those of rigid bodies.
    """
    points = link.interface.points
    if not isinstance(points, NitschePoints):
        raise TypeError(f"nodal_pressure: got {type(points).__name__}, allowed NitschePoints")
    spread = points.points.values_T
    area = spread @ link.interface.weight
    own = np.abs(area) > AREA_ROUND_OFF * np.max(np.abs(area))
    pressure: Array = (spread @ memory.force[:, 0])[own] / area[own]
    return pressure


def shifted(stepper: Stepper, u: Array, *, body: int, by: Sequence[float] | Array) -> Array:
    """Displacements after one body has moved with its supports: a guess for the next equilibrium.

    Held unknowns stay where the guess has them, all others find their equilibrium.

    Args:
        stepper: The stepper of the bodies.
        u: Displacements of all owned unknowns, m.
        body: Number of the body in its system.
        by: Translation, (d,), m.
    """
    moved = u.copy()
    own = moved[stepper.system.slices[body]].reshape(-1, stepper.system.dimension)
    own += np.asarray(by)
    return moved


def support_load(stepper: Stepper, *, body: int, force: Sequence[float] | Array) -> Array:
    """Load on the held unknowns of a body, which goes straight into the supports; collective.

    It moves nothing. But residuals are judged relative to the loads: where moved supports are the
    only load of a problem, this tells the solver what forces to expect.

    Args:
        stepper: The stepper of the bodies.
        body: Number of a meshed body with supports in its system.
        force: Approximate force that the supports exert, (d,), N.

    Raises:
        ValueError: Where no unknown in the direction of a force is held.
    """
    member, d = stepper.system.bodies[body], stepper.system.dimension
    assert isinstance(member, ElasticBody)
    load = np.zeros(stepper.system.size)
    own = load[stepper.system.slices[body]]
    for direction, component in enumerate(force):
        held = member.fixed[member.fixed % d == direction]
        count = float(global_sum(member.comm, np.array([float(len(held))]))[0])
        if component and not count:
            raise ValueError(f"support_load: {member.name} is not held in direction {direction}")
        own[held] = component / count if component else 0.0
    return load


def pressed(
    stepper: Stepper, loads: Sequence[float], *, approach: Callable[[float], float], body: int = 0
) -> Iterator[Tractions]:
    """Contact under normal loads one after another, each reached by moving a support; collective.

    A body that is held cannot roll or tilt while it is pressed. Its supports are moved down the
    last axis by the expected approach, then corrected by (missing load) x (approach over load)
    until the contact force is the load, to `LOAD_TOLERANCE`.

    Args:
        stepper: Bodies whose first interface is a contact of the pressed body with level ground.
        loads: Rising loads P, N (in two dimensions N per metre of thickness).
        approach: Expected approach (m) of the supports to the ground under a load, from a closed
            form or an estimate; it decides only how many corrections are needed.
        body: Number of the pressed body in the system.

    Yields:
        Tractions of the first interface under each load.

    Raises:
        StepFailed: Where there is no equilibrium.
    """
    down = -np.eye(stepper.system.dimension)[-1]
    state, reached = None, 0.0
    u: Array = np.zeros(stepper.system.size)
    for load in loads:
        expected = support_load(stepper, body=body, force=load * down)
        found, sinking = None, approach(load) - reached
        while found is None or abs(load - found.resultant[0]) > LOAD_TOLERANCE * load:
            if found is not None:
                sinking = (load - float(found.resultant[0])) * approach(load) / load
            guess = shifted(stepper, u, body=body, by=sinking * down)
            state = stepper.static_start(guess, load=expected, start=state)
            u, reached = state.u, reached + sinking
            found = contact_tractions(stepper.links[0], state.contacts[0])
        yield found
