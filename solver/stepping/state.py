"""The state that a step starts from, and the energy that it exchanges."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np

from solver.bodies.kinematics import RigidMotion
from solver.contact.memory import Memory
from solver.kernels import meshed
from solver.stepping.body_links import LinkMemory
from solver.stepping.system import System
from solver.types import Array


class RotationPrediction(NamedTuple):
    """Predicted rotations of all bodies in a step.

    Attributes:
        step: Length of the step, s.
        spins: Angular velocities, one (2-D) or three (3-D) numbers each, rad/s.
        rates: Their change since the start of the step before, rad/s2; zero in a first step.
        angles: Angles, or rotation vectors, by which bodies turn in the step, rad.
        halves: Those by which they turn up to its middle, rad.
    """

    step: float
    spins: Sequence[Array]
    rates: Sequence[Array]
    angles: Sequence[Array]
    halves: Sequence[Array]

    @classmethod
    def of(
        cls, spins: Sequence[Array], step: float, last: RotationPrediction | None
    ) -> RotationPrediction:
        """The turning of a step of a length (s), after the last step."""
        ahead = []
        for number, spin in enumerate(spins):
            if last is None:
                before, rate, length = spin, np.zeros_like(spin), 1.0
            else:
                before, rate, length = last.spins[number], last.rates[number], last.step
            ahead.append(np.empty((3, len(spin))))
            meshed.turning_ahead(spin, before, rate, length, step, ahead[-1])
        rates, angles = [each[0] for each in ahead], [each[2] for each in ahead]
        return cls(step, spins, rates, angles, [0.5 * angle for angle in angles])


NO_FORCES: Array = np.zeros(0)
"""Forces of the supports of bodies that have none."""


class State(NamedTuple):
    """Everything a step starts from; no step writes to it.

    Attributes:
        time: t_n, s.
        u: Displacement of the owned unknowns of all bodies, m.
        v: Velocity, m/s.
        p: Inertia force M a without that of the impulses, which are contact, loads and damping, N.
        contacts: Memory of each interface.
        motions: What `rigid_motion` finds for u and v, by the number of the body; empty at first.
        held: The p of elastic forces at supports and of springs to the ground, else 0, N; kept
            up to date where a meshed body stands on the ground.
        active: What is active of each pair of bodies: whose interfaces the memories are of.
        kinetic: Kinetic energy, J.
        strain: Strain energy, J.
        spring: Energy of springs to the ground, J.
        turning: How bodies turned at the start of the last step; None before the first.
        changed: True if contact changed in the step that led here.
        reversal: Speed at which what slipped in that step now slips back, the largest, m/s.
        damped_until: Time until which steps are damped since contact changed, s.
        body_links: Links between bodies; None in a scene without links and forces.
    """

    time: float
    u: Array
    v: Array
    p: Array
    contacts: Sequence[Memory]
    motions: dict[int, RigidMotion]
    held: Array = NO_FORCES
    active: tuple[Any, ...] = ()
    kinetic: float = 0.0
    strain: float = 0.0
    spring: float = 0.0
    turning: RotationPrediction | None = None
    changed: bool = False
    reversal: float = 0.0
    damped_until: float = 0.0
    body_links: LinkMemory | None = None

    def is_damped(self, dt: float) -> bool:
        """True if a step of length `dt` (s) from here is taken with rho_inf = 0."""
        return self.damped_until - self.time > 1e-6 * dt

    def rigid_motion(self, system: System, number: int) -> RigidMotion:
        """The motion of a body as a whole; computed once."""
        if number not in self.motions:
            own = system.slices[number]
            self.motions[number] = system.bodies[number].rigid_motion(self.u[own], self.v[own])
        return self.motions[number]


class GroundForces(NamedTuple):
    """Forces of the ground on meshed bodies that it holds and on a platform on a spring, N."""

    nodal: Array
    """On each of the owned unknowns of all meshed bodies; 0 for others."""
    total: Array
    """Sum over this rank along each direction, (d,), with damping that is relative to the ground:
    exactly what balances the momentum of all bodies, which residuals are left in."""


class Push(NamedTuple):
    """What an interface did in a step.

    Attributes:
        body: Number of the body whose points these are; None for what is fixed to the ground.
        carrier: Number of the body that carries them; None likewise.
        impulse: On the body, with that at velocity level, (d,), N s.
        normal: Its normal part times the normals, (d,), N s.
        moment: Its normal part times where it acts, (d,), N s m.
        slip: Its normal part times how far points slipped, (d,), N s m.
        pressed: Its normal part, N s.
        gap: Of the nearest point that may touch, m.
        points: Number of closed points.
    """

    body: int | None
    carrier: int | None
    impulse: Array
    normal: Array
    moment: Array
    slip: Array
    pressed: float
    gap: float
    points: int

    @property
    def place(self) -> Array:
        """Where the normal part acts, (d,), m."""
        return np.asarray(self.moment / self.pressed, dtype=np.float64)

    def reversed(self) -> Push:
        """What the interface did, as the carrier receives it."""
        return self._replace(
            body=self.carrier,
            carrier=self.body,
            impulse=-self.impulse,
            normal=-self.normal,
            slip=-self.slip,
        )

    def plus(self, other: Push) -> Push:
        """This and what another interface of the same bodies did, added up."""
        return self._replace(
            impulse=self.impulse + other.impulse,
            normal=self.normal + other.normal,
            moment=self.moment + other.moment,
            slip=self.slip + other.slip,
            pressed=self.pressed + other.pressed,
            gap=min(self.gap, other.gap),
            points=self.points + other.points,
        )


class Pushes(Protocol):
    """Finds what interfaces near contact did in a step."""

    def __call__(self, *, homes: bool) -> Sequence[Push]:
        """With what those between a block and what carries it did, or without."""


def no_pushes(*, homes: bool) -> Sequence[Push]:
    """What interfaces did where there was no step."""
    return ()


class Exchange(NamedTuple):
    """Energy that a step took in or lost, J; each term from its own formula.

    Attributes:
        input: Work of the ground.
        friction: Lost in friction.
        damping: Lost to damping of materials and dashpots.
        contact_damping: Lost in the dashpots of contact.
        contact: Lost in closing, opening and exchanging contact points.
        numerical: Lost to the averaging of forces.
        iterations: Corrections that the step took.
        ground: Mean forces of the ground; None: it has none, or they are not known.
        pushes: Finds what interfaces near contact did (`solver.stepping.pushes`).
    """

    input: float = 0.0
    friction: float = 0.0
    damping: float = 0.0
    contact_damping: float = 0.0
    contact: float = 0.0
    numerical: float = 0.0
    iterations: int = 0
    ground: GroundForces | None = None
    pushes: Pushes = no_pushes
