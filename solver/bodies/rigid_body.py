"""Bodies of a few unknowns beside meshed ones: rigid boxes and the platform on a spring.

Rank 0 owns their unknowns; `replicate` brings them to the others. Scenes in which nothing is meshed
have an engine of their own, `solver.rigid`.

Boxes have three unknowns in the plane and six in space. There a step turns a box by the Cayley
vector Psi in the frame of its start,

    R_{n+1} = R_n cay(Psi),    cay(Psi) = (I - S/2)^-1 (I + S/2),    S = skew(Psi),

and the angular velocity W in the box obeys W_{n+1} = 2 Psi/dt - W_n like every other velocity. With
the moment M about the centre, whose arms are those of the mean rotation (R_n + R_{n+1})/2, the
energy-momentum rule (Simo and Wong 1991) reads

    2 J (Psi - dt W_n) + Psi x J Psi = dt^2 (I - S/2) R_n^T M.                                   (1)

The second term is the gyroscopic moment W_m x J W_m of the mean velocity W_m = Psi/dt. It does no
work on Psi, and like contact forces it acts as an impulse: the inertia force p has no part of it.
"""

from __future__ import annotations

import math
from abc import abstractmethod

from mpi4py import MPI

import numpy as np

from geometry.block import Block
from solver.bodies.body import Body
from solver.bodies.kinematics import RigidMotion, rotation_vector, turn
from solver.scene.damping import DampingSpec
from solver.scheme.generalized_alpha import GeneralizedAlpha, TangentWeights
from solver.types import Array


class DenseBody(Body):
    """A body with a diagonal mass and, perhaps, a spring and a dashpot to the ground."""

    damping = DampingSpec()
    rigidity = 0.0

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
        self.diagonal, self._stiffness, self._dashpot = mass, stiffness, dashpot
        self.has_spring, self.delay = bool(stiffness), dashpot / stiffness if stiffness else 0.0
        self._factorizations = {}  # none is worth keeping
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

    def spring(self, vector: Array) -> Array | None:
        """Force of the spring to the ground for a displacement; None without one."""
        return self._stiffness * vector if self._stiffness else None

    def drag(self, velocity: Array) -> Array | None:
        """C v of the dashpot; None without one."""
        return self._dashpot * velocity if self._dashpot else None

    def way(self, change: Array) -> float:
        """The farthest that any of its points moves by a change of the owned unknowns, m."""
        return float(np.linalg.norm(change))

    def factorization(self, weights: TangentWeights) -> Array:
        """Diagonal of the tangent."""
        return weights.mass * self.diagonal + weights.spring * self._stiffness

    def mass_inverse(self) -> Array:
        """Diagonal of the mass."""
        return self.diagonal

    def round_off(self, u: Array, weights: TangentWeights) -> float:
        """Square of the residual that round-off leaves at u; this rank's part."""
        scale = np.finfo(float).eps * weights.mass * self.diagonal[self.own]
        return float(((scale * u) ** 2).sum())

    @abstractmethod
    def material_positions(self, points: Array, values: Array) -> Array:
        """Positions of material points (n, d) of the body for all unknowns `values`, (n, d)."""

    @abstractmethod
    def rows(self, points: Array, values: Array) -> Array:
        """Derivatives of those positions, (n, d, unknowns)."""

    @abstractmethod
    def increment_rows(self, points: Array, old: Array, new: Array) -> Array:
        """Rows whose product with new - old is exactly the change of position."""


class Oscillator(DenseBody):
    """A rigid platform on a horizontal spring and dashpot: one unknown, in space two."""

    clamped = True

    def __init__(
        self,
        *,
        mass: float,
        stiffness: float,
        dashpot: float,
        dimension: int = 2,
        comm: MPI.Intracomm = MPI.COMM_WORLD,
    ):
        """Take the mass m_P (kg), the stiffness k (N/m) and the dashpot c (N s/m)."""
        translations = np.eye(dimension, dimension - 1)
        diagonal = np.full(dimension - 1, mass)
        super().__init__(
            "platform", diagonal, translations, stiffness=stiffness, dashpot=dashpot, comm=comm
        )
        self._rows: dict[int, Array] = {}
        self._unturned = np.empty(0), np.eye(dimension)

    def rigid_motion(self, u: Array, v: Array) -> RigidMotion:
        """The motion along the ground: it does not move vertically, and does not turn."""
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
        """Rows of an increment, which do not depend on where the platform is."""
        return self.rows(points, new)


TURNED = slice(3, 6)
"""Unknowns of a box in space that turn it within a step: the Cayley vector, rad."""

CARRIED = slice(6, 9)
"""Parameters of a box in space that no step solves for: the rotation vector before it, rad."""

UNIT_SKEWS = np.cross(np.eye(3)[:, None], np.eye(3)[None]).swapaxes(1, 2).reshape(3, 9)
"""skew(e_k) of the unit vectors, row by row: their products with vectors are `skew`."""


class RigidBox(DenseBody):
    """A rigid block; points are given in its own frame, moved to its initial place.

    Attributes:
        shape: Its size and mass.
        centre: Of mass, of the unrotated block, (d,), m.
        corners: Of the unrotated block, in the order of `Block.corners`, m.
    """

    clamped = False

    def __init__(
        self,
        name: str,
        shape: Block,
        centre: Array,
        *,
        mass: Array,
        comm: MPI.Intracomm = MPI.COMM_WORLD,
    ):
        """Take the unrotated block's centre of mass, m, and M's diagonal, kg and kg m2."""
        dimension = len(centre)
        super().__init__(name, mass, np.eye(dimension, len(mass)), comm=comm)
        self.shape, self.centre = shape, centre
        arms = np.array(shape.corners(dimension)) - shape.centre_of_mass(dimension)
        self.corners: Array = arms + centre
        self._radius = float(np.linalg.norm(arms, axis=1).max())

    def way(self, change: Array) -> float:
        """At most the way of its centre, and that of a corner by the turn."""
        d = self.dimension
        return float(np.linalg.norm(change[:d]) + self._radius * np.linalg.norm(change[d:]))

    @property
    def bottom(self) -> Array:
        """The corners of the bottom of a box, counterclockwise seen from above, (2 or 4, d), m."""
        return self.corners[: len(self.corners) // 2]

    @abstractmethod
    def initial(self, moved: Array, rotation: Array) -> Array:
        """The owned unknowns where the centre has moved, (d,), m, and the block turned, (d, d)."""

    @abstractmethod
    def initial_velocity(self, velocity: Array, spin: Array, rotation: Array) -> Array:
        """The owned velocities: of the centre, m/s, and the spin, (1,) clockwise or (3,), rad/s."""

    @abstractmethod
    def rotation_at(self, values: Array) -> Array:
        """The rotation (d, d) for all unknowns `values`."""

    @abstractmethod
    def _spin(self, speed: Array, rotation: Array) -> Array:
        """Angular velocity in space for all velocities `speed`, rad/s."""

    def rotation(self, u: Array) -> Array:
        """The rotation of the block, (d, d), on every rank."""
        return self.rotation_at(self.replicate(u))

    def rigid_motion(self, u: Array, v: Array) -> RigidMotion:
        """The motion that its unknowns describe."""
        d, pose, speed = self.dimension, self.replicate(u), self.replicate(v)
        rotation = self.rotation_at(pose)
        return RigidMotion(pose[:d], speed[:d], self._spin(speed, rotation), rotation)

    def material_positions(self, points: Array, values: Array) -> Array:
        """Points of the block where it stands."""
        return self.centre + values[: self.dimension] + self._arms(points, self.rotation_at(values))

    def _arms(self, points: Array, rotation: Array) -> Array:
        """Points (n, d) of the block about its centre, turned, m."""
        arms: Array = (points - self.centre) @ rotation.T
        return arms


class PlaneBox(RigidBox):
    """A rigid block in the plane: displacement of its centre and angle, clockwise."""

    def __init__(
        self, name: str, shape: Block, centre: Array, *, comm: MPI.Intracomm = MPI.COMM_WORLD
    ):
        """Set up; see `RigidBox`."""
        mass = np.array([shape.mass, shape.mass, shape.rotary_inertia])
        super().__init__(name, shape, centre, mass=mass, comm=comm)

    def initial(self, moved: Array, rotation: Array) -> Array:
        """Displacement and angle at a place."""
        return np.append(moved, np.arctan2(rotation[0, 1], rotation[0, 0]))[self.own]

    def initial_velocity(self, velocity: Array, spin: Array, rotation: Array) -> Array:
        """Velocity of the centre and angular velocity."""
        return np.append(velocity, spin)[self.own]

    def round_off(self, u: Array, weights: TangentWeights) -> float:
        """Square of the residual that round-off leaves, of the places of its points as well."""
        size = np.array([self._radius, self._radius, 1.0])
        return super().round_off(np.abs(u) + size[self.own], weights)

    def rotation_at(self, values: Array) -> Array:
        """The rotation, clockwise by the third unknown."""
        return turn(values[2:])

    def _spin(self, speed: Array, rotation: Array) -> Array:
        """Angular velocity, clockwise, (1,), rad/s."""
        return speed[2:]

    def rows(self, points: Array, values: Array) -> Array:
        """Translation, and the derivative of the rotation."""
        return self._rows(self._arms(points, self.rotation_at(values)))

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
        return self._rows(self._arms(points, self.rotation_at(mean)), chord)


class SpaceBox(RigidBox):
    """A rigid block in space: displacement of its centre, and the Cayley vector of a step.

    Behind these six unknowns the vector carries three parameters that no step changes: the rotation
    vector of the block where the Cayley vector is zero. So the rotation is a function of the vector
    alone; `settle` makes the end of a step the start of the next one.

    The Cayley vector, the angular velocity and M's diagonal are those about the principal axes of
    its inertia, which are its own axes unless its mass is uneven.
    """

    def __init__(
        self, name: str, shape: Block, centre: Array, *, comm: MPI.Intracomm = MPI.COMM_WORLD
    ):
        """Set up; see `RigidBox`."""
        # What is carried does not move: its mass only keeps the diagonal regular.
        self._axes: Array | None = None
        moments = np.array(shape.principal_inertias)
        if not shape.is_even:
            moments, axes = np.linalg.eigh(np.array(shape.inertia_tensor))
            self._axes = axes * np.linalg.det(axes)  # turned, not mirrored
        mass = np.array([*(shape.mass,) * 3, *moments, *(shape.mass,) * 3])
        super().__init__(name, shape, centre, mass=mass, comm=comm)
        self.fixed = np.arange(*CARRIED.indices(self.size), dtype=np.int32)
        self._start: Array = np.zeros(self.size)
        self._step, self._weight = math.inf, 0.0

    def initial(self, moved: Array, rotation: Array) -> Array:
        """Displacement and rotation vector at a place."""
        return np.concatenate([moved, np.zeros(3), rotation_vector(rotation)])[self.own]

    def initial_velocity(self, velocity: Array, spin: Array, rotation: Array) -> Array:
        """Velocity of the centre, and angular velocity in the block."""
        own = spin @ rotation
        if self._axes is not None:
            own = own @ self._axes
        return np.concatenate([velocity, own, np.zeros(3)])[self.own]

    def _of_block(self, vector: Array) -> Array:
        """A vector of its principal axes along its own axes."""
        return vector if self._axes is None else np.asarray(self._axes @ vector)

    def begin_step(self, u_old: Array, scheme: GeneralizedAlpha, dt: float) -> None:
        """Keep where a step starts, for the gyroscopic moment."""
        self._start, self._step, self._weight = u_old, dt, scheme.contact_weight

    def internal_force(self, u: Array, *, static: bool = False) -> Array | None:
        """The gyroscopic moment w_c Psi x J Psi/dt^2 of a step, N m; None in equilibrium."""
        return None if static else self._weight * self.impulsive_force(u, self._step)

    def impulsive_force(self, u: Array, dt: float) -> Array:
        """The gyroscopic moment Psi x J Psi/dt^2 of a step from where it began to u, N m."""
        gyroscopic = np.zeros(self.size)
        if self.size:
            psi = u[TURNED] - self._start[TURNED]
            gyroscopic[TURNED] = skew(psi) @ (self.diagonal[TURNED] * psi) / dt**2
        return gyroscopic

    def settled(self, u: Array) -> Array:
        """The unknowns with the turn of the step moved into the rotation vector that is carried."""
        if not (self.size and u[TURNED].any()):
            return u
        settled = u.copy()
        settled[CARRIED] = rotation_vector(self.rotation_at(u))
        settled[TURNED] = 0.0
        return settled

    def round_off(self, u: Array, weights: TangentWeights) -> float:
        """Square of the residual that round-off leaves, of the places of its points as well."""
        size = np.array([*(self._radius,) * 3, *(1.0,) * 3, *(0.0,) * 3])[self.own]
        scale = np.abs(u) + size
        scale[self.fixed] = 0.0
        return super().round_off(scale, weights)

    def rotation_at(self, values: Array) -> Array:
        """The rotation R = R_n cay(Psi)."""
        before = turn(values[CARRIED])
        psi = self._of_block(values[TURNED])
        return before @ cayley(psi) if psi.any() else before

    def _spin(self, speed: Array, rotation: Array) -> Array:
        """Angular velocity in space, (3,), by the right-hand rule, rad/s."""
        spin: Array = rotation @ self._of_block(speed[TURNED])
        return spin

    def rows(self, points: Array, values: Array) -> Array:
        """Velocities for the velocity of the centre and the angular velocity in the block."""
        return self._rows(points, self.rotation_at(values))

    def increment_rows(self, points: Array, old: Array, new: Array) -> Array:
        """Rows at the mean rotation A = (R_n + R_{n+1})/2 = R_n (I - S/2)^-1.

        A point r moves by psi x A r with psi = R_n Psi = A^-T Psi, since A^-T = R_n (I + S/2): the
        product of the rows with the increment is exact, and their transpose gives a force the
        factor (I - S/2) R_n^T that its moment has in (1), which conserves angular momentum.
        """
        return self._rows(points, 0.5 * (self.rotation_at(old) + self.rotation_at(new)))

    def _rows(self, points: Array, mean: Array) -> Array:
        """I and -skew(A r) A^-T for a mean rotation A, (n, 3, unknowns)."""
        rows = np.zeros((len(points), 3, self.unknowns))
        rows[:, :, :3] = np.eye(3)
        turning = np.linalg.inv(mean).T
        if self._axes is not None:
            turning = turning @ self._axes
        rows[:, :, TURNED] = -skew(self._arms(points, mean)) @ turning
        return rows


def rigid_box(
    name: str, shape: Block, centre: Array, *, comm: MPI.Intracomm = MPI.COMM_WORLD
) -> RigidBox:
    """A rigid block in the plane or in space, as its centre has two or three coordinates."""
    return (PlaneBox if len(centre) == 2 else SpaceBox)(name, shape, centre, comm=comm)


def skew(vectors: Array) -> Array:
    """Matrices S(a) with S(a) b = a x b, (3, 3) or (n, 3, 3), for vectors (3,) or (n, 3)."""
    matrices: Array = (vectors @ UNIT_SKEWS).reshape(*vectors.shape, 3)
    return matrices


def cayley(psi: Array) -> Array:
    """The rotation cay(Psi) = I + (S + S^2/2)/(1 + |Psi|^2/4), (3, 3), S = skew(Psi)."""
    S = skew(psi)
    rotation: Array = np.eye(3) + (S + 0.5 * S @ S) / (1 + 0.25 * psi @ psi)
    return rotation
