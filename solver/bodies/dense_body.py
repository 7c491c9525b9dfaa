"""Bodies of a few unknowns beside meshed ones: the rigid block and the platform on a spring.

Rank 0 owns their unknowns; `replicate` tells the others. Scenes in which nothing is meshed have an
engine of their own, `solver.rigid`.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod

from mpi4py import MPI

import numpy as np

from geometry.block import Block
from solver.bodies.kinematics import RigidMotion, turn
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

    def begin_step(self, u_old: Array, scheme: GeneralizedAlpha, dt: float) -> None:
        """Nothing to prepare."""

    def begin_static(self, u: Array) -> None:
        """Nothing to prepare."""

    def internal_force(self, u: Array, *, static: bool = False) -> Array | None:
        """None: nothing deforms."""
        return None

    def viscous_force(self, dt: float) -> Array | None:
        """None: nothing deforms."""
        return None

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

    def extrapolated(self, u: Array, v: Array, dt: float, motion: RigidMotion) -> Array:
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


class Oscillator(DenseBody):
    """A rigid platform on a horizontal spring and dashpot: one unknown, in space two."""

    turns = False

    def __init__(
        self,
        *,
        mass: float,
        stiffness: float,
        dashpot: float,
        dimension: int = 2,
        comm: MPI.Intracomm = MPI.COMM_WORLD,
    ):
        """Set up.

        Args:
            mass: m_P, kg.
            stiffness: k, N/m.
            dashpot: c, N s/m.
            dimension: Of space.
            comm: Communicator of the run.
        """
        translations = np.eye(dimension, dimension - 1)
        diagonal = np.full(dimension - 1, mass)
        super().__init__(
            "platform", diagonal, translations, stiffness=stiffness, dashpot=dashpot, comm=comm
        )
        self._rows: dict[int, Array] = {}
        self._unturned = np.empty(0), np.eye(dimension)

    def rigid_motion(self, u: Array, v: Array) -> RigidMotion:
        """It does not move vertically, and does not turn."""
        motion = np.zeros((2, self.dimension))
        motion[0, :-1], motion[1, :-1] = self.replicate(u), self.replicate(v)
        return RigidMotion(motion[0], motion[1], *self._unturned)

    def material_positions(self, points: Array, values: Array) -> Array:
        """Points of the platform, moved."""
        places = points.copy()
        places[:, :-1] += values
        return places

    def rows(self, points: Array, values: Array) -> Array:
        """Every point moves with the platform; one array for all calls, not to be written to."""
        count = len(points)
        if count not in self._rows:
            each = np.eye(self.dimension, self.dimension - 1)
            self._rows[count] = np.tile(each, (count, 1, 1))
            self._rows[count].flags.writeable = False
        return self._rows[count]

    def increment_rows(self, points: Array, old: Array, new: Array) -> Array:
        """The same at any time."""
        return self.rows(points, new)


class RigidBlock(DenseBody):
    """A rigid block in the plane: displacement of its centre and angle, clockwise."""

    turns = True

    def __init__(
        self, name: str, shape: Block, centre: Array, *, comm: MPI.Intracomm = MPI.COMM_WORLD
    ):
        """Set up; points are given in the block's own frame, moved to its initial place.

        Args:
            name: Of the block.
            shape: Its size and density.
            centre: Of the unrotated block, in its own frame, m.
            comm: Communicator of the run.
        """
        diagonal = np.array([shape.mass, shape.mass, shape.rotary_inertia])
        super().__init__(name, diagonal, np.eye(2, 3), comm=comm)
        self.shape, self.centre = shape, centre
        self.corners = np.array(shape.corners()) + centre - (0.0, shape.height / 2)
        """In its reference configuration, counterclockwise from the bottom left one, (4, 2), m."""

    def round_off(self, u: Array, weights: TangentWeights) -> float:
        """That of its points' places, too, which are as long as it is."""
        size = self.shape.half_diagonal
        return super().round_off(np.abs(u) + np.array([size, size, 1.0])[self.own], weights)

    def rigid_motion(self, u: Array, v: Array) -> RigidMotion:
        """The unknowns themselves."""
        pose, speed = self.replicate(u), self.replicate(v)
        return RigidMotion(pose[:2], speed[:2], speed[2:], turn(pose[2:]))

    def rotation(self, u: Array) -> Array:
        """Clockwise by the third unknown."""
        return turn(self.replicate(u)[2:])

    def material_positions(self, points: Array, values: Array) -> Array:
        """Points of the block where it stands."""
        return self.centre + values[:2] + (points - self.centre) @ turn(values[2:]).T

    def rows(self, points: Array, values: Array) -> Array:
        """Translation, and the derivative of the rotation."""
        return self._rows((points - self.centre) @ turn(values[2:]).T)

    @staticmethod
    def _rows(arms: Array, factor: float = 1.0) -> Array:
        """Rows for arms in space; a clockwise turn moves (x, y) along (y, -x)."""
        rows = np.zeros((len(arms), 2, 3))
        rows[:, 0, 0] = rows[:, 1, 1] = 1.0
        rows[:, 0, 2], rows[:, 1, 2] = factor * arms[:, 1], -factor * arms[:, 0]
        return rows

    def increment_rows(self, points: Array, old: Array, new: Array) -> Array:
        """Rows at the mean angle; the chord of the turn is sin(d/2)/(d/2) of its arc."""
        mean, half = 0.5 * (old + new), 0.5 * (new[2] - old[2])
        chord = math.sin(half) / half if half else 1.0
        return self._rows((points - self.centre) @ turn(mean[2:]).T, chord)
