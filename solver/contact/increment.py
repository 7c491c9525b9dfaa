"""An interface over a step, between whose ends its forces do their work."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from solver.contact.body_points import SurfaceState
from solver.contact.memory import Memory
from solver.contact.projection import ContactKinematics
from solver.types import Array


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
