"""What all bodies offer to a step: inertia, forces, damping, a factorized tangent.

Vectors hold the owned unknowns of a rank, and belong to the whole thickness.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import Any

from mpi4py import MPI

import numpy as np
from numpy.typing import NDArray

from solver.bodies.kinematics import RigidMotion
from solver.scene.damping import DampingSpec
from solver.scheme.generalized_alpha import GeneralizedAlpha, TangentWeights
from solver.types import Array


class Body(ABC):
    """A part of a scene that moves: meshed, reduced, or of a few unknowns.

    Attributes:
        name: What messages and files call it.
        comm: Communicator of the run.
        dimension: d, 2 or 3.
        size: Number of the owned unknowns.
        unknowns: Number of all unknowns.
        mass: Its mass, kg.
        directional_mass: Mass of each owned unknown in motion along each direction, (d, size), kg.
        rigidity: Order of magnitude of its stiffness against forces on its surface, N/m; 0 where it
            does not deform.
        fixed: Owned unknowns that do not move.
        clamped: True if it stands on the ground, and does not turn.
        damping: Its Rayleigh damping.
        has_spring: True if springs tie it to the ground.
        delay: Dashpots over these springs, s.
    """

    name: str
    comm: MPI.Intracomm
    dimension: int
    size: int
    unknowns: int
    mass: float
    directional_mass: Array
    rigidity: float
    fixed: NDArray[np.int32]
    clamped: bool
    damping: DampingSpec
    has_spring: bool
    delay: float
    _factorizations: dict[TangentWeights, Any]

    @abstractmethod
    def inertia(self, vector: Array) -> Array:
        """M x."""

    @abstractmethod
    def resultant(self, force: Array) -> Array:
        """Sum of the forces on the owned unknowns along each direction, (d,), N."""

    @abstractmethod
    def rigid_motion(self, u: Array, v: Array) -> RigidMotion:
        """Motion of the rigid body that has the same momentum and angular momentum."""

    @abstractmethod
    def spring(self, vector: Array) -> Array | None:
        """Force of the springs to the ground for a displacement; None without them."""

    @abstractmethod
    def round_off(self, u: Array, weights: TangentWeights) -> float:
        """Square of the residual that round-off leaves at u; this rank's part."""

    @abstractmethod
    def factorization(self, weights: TangentWeights) -> Any:
        """The factorized tangent for these weights: an `Inverse`, or a diagonal."""

    @abstractmethod
    def mass_inverse(self) -> Any:
        """The factorized mass, likewise."""

    def forget(self, weights: TangentWeights) -> None:
        """Drop a factorization; it is made anew when needed."""
        self._factorizations.pop(weights, None)

    def dashpot(self, velocity: Array) -> Array:
        """Force of the dashpots beside the springs to the ground, which there are."""
        spring = self.spring(velocity)
        assert spring is not None
        return self.delay * spring

    def drag(self, velocity: Array) -> Array | None:
        """C v: mass-proportional damping and the dashpots; None without both."""
        force = self.damping.mass * self.inertia(velocity) if self.damping.mass else None
        if self.delay and self.has_spring:
            dashpot = self.dashpot(velocity)
            force = dashpot if force is None else force + dashpot
        return force

    def weights(self, scheme: GeneralizedAlpha, dt: float) -> TangentWeights:
        """Weights of the tangent in a step."""
        return scheme.weights(dt, self.damping.mass, self.damping.stiffness, self.delay)

    def begin_step(self, u_old: Array, scheme: GeneralizedAlpha, dt: float) -> None:
        """Fix what a step of length `dt` starts from: nothing of a body without strain."""

    def begin_static(self, u: Array) -> None:
        """Prepare for the forces of a state itself: a body without strain needs no preparation."""

    def internal_force(self, u: Array, *, static: bool = False) -> Array | None:
        """Averaged internal force in a step to u; with `static`, of that state itself.

        A new array; None of a body that does not deform.
        """
        return None

    def impulsive_force(self, u: Array, dt: float) -> Array | None:
        """Internal force outside the averages of the step that ends at u; None: there is none."""
        return None

    def settled(self, u: Array) -> Array:
        """The unknowns that the next step starts from: those at the end of this one."""
        return u

    def turned(self, force: Array, vector: Array) -> Array:
        """Forces that turn with the body, by an angle or a rotation vector: here nothing does."""
        return force

    def extrapolated(
        self, u: Array, v: Array, dt: float, angle: Array, motion: RigidMotion
    ) -> Array:
        """The owned unknowns after dt if nothing acted on the body."""
        return u + dt * v

    def rotation(self, u: Array) -> Array:
        """The rotation R that fits the displacement u best, (d, d): the identity."""
        return np.eye(self.dimension)

    def way(self, change: Array) -> float:
        """The farthest that any of its points moves by a change of the owned unknowns, m."""
        return math.sqrt(self.dimension) * float(np.abs(change).max(initial=0.0))
