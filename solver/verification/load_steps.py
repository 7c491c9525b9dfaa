"""Equilibrium of bodies in contact through the Python interface: loads, supports that are moved.

`Stepper.static_start` solves one equilibrium; with `start` it goes on from the contact memory of
the one before, so that loads can follow one another and friction remembers them. Here is what such
sequences need besides: supports that move, and contact forces as tractions.

    state = stepper.static_start(u, load=load)                      # press
    for _ in range(5):                                              # then shear, step by step
        u = shifted(stepper, state.u, body=0, by=(0.1 * shift, 0.0))
        state = stepper.static_start(u, load=load, start=state)
    tractions = contact_tractions(stepper.links[0], state.contacts[0])
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from solver.bodies.elastic_body import ElasticBody
from solver.contact.body_points import NitschePoints
from solver.contact.memory import Memory
from solver.parallel import global_sum
from solver.stepping.stepper import Stepper
from solver.stepping.system import Link
from solver.types import Array, Mask


@dataclass(frozen=True, slots=True, kw_only=True)
class Tractions:
    """Contact of a meshed face, point by point, sorted by the place on the undeformed body.

    Attributes:
        place: Of the points on the undeformed body, (points, d), m.
        position: Where they are, (points, d), m.
        weight: Undeformed length (per metre of thickness) or area of each point, (points,).
        force: Point forces, normal and tangential, on the body of the points, (points, d), N.
        slipping: Points whose friction is at its bound.
    """

    place: Array
    position: Array
    weight: Array
    force: Array
    slipping: Mask

    @property
    def pressure(self) -> Array:
        """Normal force on undeformed area, (points,), Pa."""
        return self.force[:, 0] / self.weight

    @property
    def shear(self) -> Array:
        """Friction on undeformed area, (points, d - 1), Pa."""
        return self.force[:, 1:] / self.weight[:, None]

    @property
    def resultant(self) -> Array:
        """Sum of the forces: normal, tangential, (d,), N."""
        return self.force.sum(axis=0)


def contact_tractions(link: Link, memory: Memory) -> Tractions:
    """What an interface transmits.

    Args:
        link: The interface; its points are those of a meshed body.
        memory: Of the state, `state.contacts[number of the link]`.

    Raises:
        TypeError: For points without area: nodes, or those of rigid bodies.
    """
    points, interface = link.interface.points, link.interface
    if not isinstance(points, NitschePoints):
        raise TypeError(f"contact_tractions: got {type(points).__name__}, allowed NitschePoints")
    order = np.lexsort(points.reference.T[::-1])
    bounds = interface.bounds(memory, memory.slipped, None)
    return Tractions(
        place=points.reference[order],
        position=memory.surface.position[order],
        weight=interface.weight[order],
        force=memory.force[order],
        slipping=interface.at_bound(memory.force, bounds)[order],
    )


def nodal_pressure(link: Link, memory: Memory) -> Array:
    """Normal nodal forces over nodal areas of the undeformed face, (nodes that have any,), Pa.

    Pressures of single points carry the round-off of their gap times gamma_h; these do not.

    Args:
        link: As for `contact_tractions`.
        memory: Likewise.

    Raises:
        TypeError: As `contact_tractions`.
    """
    points = link.interface.points
    if not isinstance(points, NitschePoints):
        raise TypeError(f"nodal_pressure: got {type(points).__name__}, allowed NitschePoints")
    spread = points.points.values_T
    area = spread @ link.interface.weight
    own = np.abs(area) > 1e-9 * np.max(np.abs(area))
    pressure: Array = (spread @ memory.force[:, 0])[own] / area[own]
    return pressure


def shifted(stepper: Stepper, u: Array, *, body: int, by: Sequence[float]) -> Array:
    """Displacements where one body with its supports has moved: a guess for the next equilibrium.

    Held unknowns stay where the guess has them, all others find their equilibrium.

    Args:
        stepper: Of the bodies.
        u: Displacements of all owned unknowns, m.
        body: Number of the body in its system.
        by: How far, (d,), m.
    """
    moved = u.copy()
    own = moved[stepper.system.slices[body]].reshape(-1, stepper.system.dimension)
    own += np.asarray(by)
    return moved


def support_load(stepper: Stepper, *, body: int, force: Sequence[float]) -> Array:
    """A load on the held unknowns of a body, where it goes into the supports; collective.

    It moves nothing, but a residual counts as small in relation to the loads: where supports that
    move are all that loads a scene, this says what forces to expect.

    Args:
        stepper: Of the bodies.
        body: Number of a meshed body with supports in its system.
        force: About the force that the supports exert, (d,), N.

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
