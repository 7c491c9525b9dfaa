"""What a step starts from, and what it exchanges."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from solver.bodies.kinematics import RigidMotion
from solver.contact.interface import Memory
from solver.stepping.system import System
from solver.stepping.turning import Turning
from solver.types import Array


@dataclass(slots=True)
class State:
    """Everything a step starts from.

    Attributes:
        time: t_n, s.
        u: Displacement of the owned unknowns of all bodies, m.
        v: Velocity, m/s.
        p: Inertia force M a without that of the impulses, which are contact, loads and damping, N.
        contacts: Memory of each interface.
        kinetic: Kinetic energy, J.
        strain: Strain energy, J.
        spring: Energy of springs to the ground, J.
        exchanged: Interface energy lost since t_n by choosing other contact points, J.
        motions: What `rigid_motion` found, body by body.
        turning: How bodies turned at the start of the last step; None before the first.
        unsettled: Steps that are still to be damped since contact changed.
    """

    time: float
    u: Array
    v: Array
    p: Array
    contacts: Sequence[Memory]
    kinetic: float = 0.0
    strain: float = 0.0
    spring: float = 0.0
    exchanged: float = 0.0
    motions: dict[int, RigidMotion] = field(default_factory=dict)
    turning: Turning | None = None
    unsettled: int = 0

    def rigid_motion(self, system: System, number: int) -> RigidMotion:
        """The motion of a body as a whole; asked for by several, and worked out once."""
        if number not in self.motions:
            own = system.slices[number]
            self.motions[number] = system.bodies[number].rigid_motion(self.u[own], self.v[own])
        return self.motions[number]


@dataclass(slots=True)
class Exchange:
    """Energy that a step took in or lost, J; each term from its own formula."""

    input: float = 0.0
    friction: float = 0.0
    damping: float = 0.0
    contact: float = 0.0
    numerical: float = 0.0
    iterations: int = 0
