"""Forces of an interface on the unknowns of both its bodies."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from solver.contact.body_points import PointForces, SurfaceState
from solver.contact.memory import Memory
from solver.contact.projection import ContactKinematics
from solver.law.friction import Bounds
from solver.stepping.system import Link, System
from solver.types import Array


class Contact(NamedTuple):
    """One interface at the end of a step.

    Attributes:
        surface: Its points.
        kinematics: Their gaps and tangential positions.
        force: Point forces f, (points, d), N.
        bounds: Bounds of friction at all points.
        clear: As in its memory: how far it may move before anybody has to look at it, m.
    """

    surface: SurfaceState
    kinematics: ContactKinematics
    force: Array
    bounds: Bounds
    clear: float = 0.0

    def is_unseen(self, before: Memory) -> bool:
        """Whether the step did not even look where it is: it stays as it was remembered before."""
        return self.surface is before.surface


class ContactIncrement(NamedTuple):
    """An interface over a step, or over an iteration of it.

    Attributes:
        before: Memory of t_n, in the frame of the step.
        surface: Points at t_{n+1}.
        kinematics: Their gaps and tangential positions at t_{n+1}.
        force: Point forces f at t_{n+1}, (points, d), N.
    """

    before: Memory
    surface: SurfaceState
    kinematics: ContactKinematics
    force: Array

    @classmethod
    def standing(cls, memory: Memory, force: Array) -> ContactIncrement:
        """An interface that stays where it is."""
        return cls(before=memory, surface=memory.surface, kinematics=memory.kinematics, force=force)

    @property
    def in_equilibrium(self) -> ContactIncrement:
        """This increment with the interface at t_{n+1} at both ends."""
        return self._replace(
            before=replace(self.before, surface=self.surface, kinematics=self.kinematics)
        )


def add_contact_forces(
    system: System,
    link: Link,
    increment: ContactIncrement,
    target: Array,
    *,
    traction_weight: float,
    contact_weight: float,
    sign: float,
) -> None:
    """Add the forces of one interface on both its bodies to a vector of owned unknowns, in place.

    The traction weight is 1 - alpha_f for the theta term of Nitsche's method, 0 to leave it out,
    the contact weight w_c, the sign 1, or -1 to subtract.
    """
    interface, before, after = link.interface, increment.before, increment
    weighted = (sign * contact_weight) * after.force
    vectors, reaction = interface.point_forces(before.kinematics, after.kinematics, weighted)
    pull = None
    if interface.theta:
        pull = interface.traction_pull(weighted, traction_weight=traction_weight, sign=sign)
    if link.body is not None:
        own = target[system.slices[link.body]]
        forces = PointForces(before.surface, after.surface, vectors, pull)
        interface.points.add_forces(own, forces)
    if link.carrier is not None and reaction is not None:
        carrier, points = target[system.slices[link.carrier]], interface.carrier.points
        first, last = before.kinematics.carrier, after.kinematics.carrier
        assert points is not None and first is not None and last is not None
        points.add_forces(carrier, PointForces(first, last, reaction))
