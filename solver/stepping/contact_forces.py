"""Forces of an interface on the unknowns of both its bodies."""

from __future__ import annotations

from typing import NamedTuple

from solver.contact.body_points import SurfaceState
from solver.contact.increment import ContactIncrement
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

    Weights and sign are those of `Interface.add_forces`.
    """
    link.interface.add_forces(
        increment,
        system.part(target, link.body),
        system.part(target, link.carrier),
        contact_weight=contact_weight,
        traction_weight=traction_weight,
        sign=sign,
    )
