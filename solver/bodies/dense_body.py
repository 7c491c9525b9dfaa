"""Bodies of a few unknowns beside meshed ones: rigid boxes and the platform on a spring.

Rank 0 owns their unknowns; `replicate` tells the others. Scenes in which nothing is meshed have an
engine of their own, `solver.rigid`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

from mpi4py import MPI

import numpy as np

from solver.bodies.kinematics import RigidMotion
from solver.scheme.generalized_alpha import GeneralizedAlpha, TangentWeights
from solver.types import Array


class DenseBody(ABC):
    """A body with a diagonal mass and, perhaps, a spring and a dashpot to the ground.

    Attributes:
        turns: Whether it can: the rows of one that cannot are the same in all configurations.
    """

    turns: bool

    def __init__(
        self,
        name: str,
        mass: Array,
        translations: Array,
        *,
        stiffness: float = 0.0,
        dashpot: float = 0.0,
        comm: MPI.Intracomm = MPI.COMM_WORLD,
    ):
        """Keep the constants.

        Args:
            name: What messages and files call it.
            mass: Diagonal of M, (unknowns,).
            translations: Unknowns of a unit translation along each direction, (d, unknowns).
            stiffness: k of the spring that each unknown has, N/m.
            dashpot: c, N s/m.
            comm: Communicator of the run.
        """
        self.name, self.comm = name, comm
        self.dimension, self.unknowns = translations.shape
        self.own = slice(0, self.unknowns if comm.rank == 0 else 0)
        self.size = self.own.stop
        self.diagonal, self.stiffness, self.dashpot = mass, stiffness, dashpot
        self._translations = translations[:, self.own]
        self.directional_mass = (translations * mass)[:, self.own]
        self.mass = float(mass[0])
        self.fixed = np.empty(0, dtype=np.int32)

    def replicate(self, owned: Array) -> Array:
        """All unknowns, on every rank; a copy, since SNES goes on to change what it handed out."""
        if self.comm.size == 1:
            return owned.copy()
        values = np.empty(self.unknowns)
        values[self.own] = owned
        self.comm.Bcast(values, root=0)
        return values

    def inertia(self, vector: Array) -> Array:
        """M x."""
        return self.diagonal[self.own] * vector

    def resultant(self, force: Array) -> Array:
        """Sum of the forces on the owned unknowns along each direction, (d,), N."""
        return np.asarray(self._translations @ force)

    def begin_step(self, u_old: Array, scheme: GeneralizedAlpha, dt: float) -> None:
        """Prepare for a step or an equilibrium: a body without strain needs no preparation."""

    def begin_static(self, u: Array) -> None:
        """Prepare for a step or an equilibrium: a body without strain needs no preparation."""

    def internal_force(self, u: Array, *, static: bool = False) -> Array | None:
        """Internal force of strain: None, because the body does not deform."""
        return None

    def impulsive_force(self, u: Array, dt: float) -> Array | None:
        """Internal force of strain: None, because the body does not deform."""
        return None

    def settled(self, u: Array) -> Array:
        """The unknowns that the next step starts from: those at the end of this one."""
        return u

    @property
    def has_spring(self) -> bool:
        """Whether a spring holds it to the ground."""
        return bool(self.stiffness)

    def spring(self, vector: Array) -> Array | None:
        """Force of the spring to the ground for a displacement; None without one."""
        return self.stiffness * vector if self.stiffness else None

    def drag(self, velocity: Array) -> Array | None:
        """C v of the dashpot; None without one."""
        return self.dashpot * velocity if self.dashpot else None

    def weights(self, scheme: GeneralizedAlpha, dt: float) -> TangentWeights:
        """Weights of the tangent in a step."""
        ratio = self.dashpot / self.stiffness if self.stiffness else 0.0
        return scheme.weights(dt, spring_damping=ratio)

    def way(self, change: Array) -> float:
        """The farthest that any of its points moves by a change of the owned unknowns, m."""
        return float(np.linalg.norm(change))

    def tangent(self, weights: TangentWeights) -> Array:
        """Diagonal of the tangent."""
        return weights.mass * self.diagonal + weights.spring * self.stiffness

    def round_off(self, u: Array, weights: TangentWeights) -> float:
        """Square of the residual that round-off leaves at u; this rank's part."""
        scale = np.finfo(float).eps * weights.mass * self.diagonal[self.own]
        return float(((scale * u) ** 2).sum())

    def turned(self, force: Array, vector: Array) -> Array:
        """The same: generalized forces know of no frame."""
        return force

    @abstractmethod
    def rigid_motion(self, u: Array, v: Array) -> RigidMotion:
        """The unknowns or some of them, on every rank."""

    def extrapolated(
        self, u: Array, v: Array, dt: float, angle: Array, motion: RigidMotion
    ) -> Array:
        """The owned unknowns after dt if nothing acted on the body."""
        return u + dt * v

    @abstractmethod
    def material_positions(self, points: Array, values: Array) -> Array:
        """Where material points (n, d) of the body are for all unknowns `values`, (n, d)."""

    @abstractmethod
    def rows(self, points: Array, values: Array) -> Array:
        """Derivatives of those positions, (n, d, unknowns)."""

    @abstractmethod
    def increment_rows(self, points: Array, old: Array, new: Array) -> Array:
        """Rows whose product with new - old is exactly the change of position."""

    def rotation(self, u: Array) -> Array:
        """The rotation of the body, (d, d), on every rank."""
        return np.eye(self.dimension)
