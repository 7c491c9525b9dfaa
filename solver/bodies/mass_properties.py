"""Mass properties of a meshed body: what moves as a whole in a motion, and what is left of it.

Sums over nodes are compiled.
"""

from __future__ import annotations

from collections.abc import Callable

from mpi4py import MPI

import numpy as np

from solver.bodies.kinematics import RigidMotion, best_rotation, polar_rotation, turn_by
from solver.law.compiled import compiled
from solver.parallel import global_sum
from solver.types import Array


@compiled
def momenta(
    arm: Array, u: Array, v: Array, momentum: Array, directional_mass: Array, sums: Array
) -> None:
    """Fill in sums over the nodes of a body: m u and m v, (d,) each, (arm + u) x M v, and v.M v.

    The moments are about the axes of space; in the plane there is one, which turns clockwise.

    Args:
        arm: Places of the nodes from the centre of the undeformed body, (n, d), m.
        u: Displacements, (n d,), m.
        v: Velocities, (n d,), m/s.
        momentum: M v, (n d,), kg m/s.
        directional_mass: Mass of each unknown in motion along each direction, (d, n d), kg.
        sums: The sums, (2 d + 2,) or in space (2 d + 4,).
    """
    d = arm.shape[1]
    sums[:] = 0.0
    for i in range(d):
        for n in range(len(u)):
            sums[i] += directional_mass[i, n] * u[n]
            sums[d + i] += directional_mass[i, n] * v[n]
    for n in range(len(v)):
        sums[-1] += v[n] * momentum[n]
    for axis in range(len(sums) - 2 * d - 1):
        i, j = (1, 0) if d == 2 else ((axis + 1) % 3, (axis + 2) % 3)
        for n in range(len(arm)):
            along, across = arm[n, i] + u[n * d + i], arm[n, j] + u[n * d + j]
            sums[2 * d + axis] += along * momentum[n * d + j] - across * momentum[n * d + i]


@compiled
def resultant(forces: Array, total: Array) -> None:
    """Fill in the sum (d,) of forces on nodes, one after another in (n d,), N."""
    d = len(total)
    total[:] = 0.0
    for n in range(0, len(forces), d):
        for i in range(d):
            total[i] += forces[n + i]


@compiled
def velocities(
    sums: Array, mass: float, rotation: Array, inertia: Array, motion: Array, spin: Array
) -> None:
    """Fill in how a body moves as a whole, by sums over its nodes as `momenta` gives them.

    Args:
        sums: Over the nodes of all ranks.
        mass: Of the body, kg.
        rotation: That fits its displacement best, (d, d).
        inertia: Inertia tensor of the unrotated body about its centre, (3, 3), in the plane its
            polar inertia, (1, 1), kg m2.
        motion: Displacement (m) and velocity (m/s) of the centre, (2, d).
        spin: Angular velocity, (1,) or (3,), rad/s.
    """
    d, axes = len(rotation), len(spin)
    for k in range(d):
        motion[0, k], motion[1, k] = sums[k] / mass, sums[d + k] / mass
    own = np.empty(axes)
    for axis in range(axes):
        i, j = (1, 0) if d == 2 else ((axis + 1) % 3, (axis + 2) % 3)
        centre = motion[0, i] * motion[1, j] - motion[0, j] * motion[1, i]
        own[axis] = sums[2 * d + axis] - mass * centre
    if d == 2:
        spin[0] = own[0] / inertia[0, 0]
        return
    turned, spin[:] = np.zeros(3), 0.0
    for i in range(3):
        for j in range(3):
            turned[i] += rotation[j, i] * own[j]
    own_frame = np.linalg.solve(inertia, turned)
    for i in range(3):
        for j in range(3):
            spin[i] += rotation[i, j] * own_frame[j]


@compiled
def move_on(arm: Array, u: Array, moved: Array, vector: Array, way: Array, after: Array) -> None:
    """Fill in displacements of a body that turns and moves on as a whole, its strains unchanged.

    Args:
        arm: Places of the nodes from the centre of the undeformed body, (n, d), m.
        u: Displacements before, (n d,), m.
        moved: That of the centre, (d,), m.
        vector: Angle (1,) or rotation vector (3,) by which the body turns, rad.
        way: How far its centre moves, (d,), m.
        after: Displacements after, (n d,), m.
    """
    d = arm.shape[1]
    turn = np.empty((d, d))
    turn_by(vector, turn)
    for i in range(d):
        turn[i, i] -= 1.0
    for n in range(len(arm)):
        for i in range(d):
            after[n * d + i] = u[n * d + i] + way[i]
            for j in range(d):
                after[n * d + i] += turn[i, j] * (arm[n, j] + u[n * d + j] - moved[j])


@compiled
def turn_all(vectors: Array, vector: Array, turned: Array) -> None:
    """Fill in vectors x, one after another in (n d,), turned by an angle (1,) or a vector (3,)."""
    d = 2 if len(vector) == 1 else 3
    rotation = np.empty((d, d))
    turn_by(vector, rotation)
    for n in range(0, len(vectors), d):
        for i in range(d):
            turned[n + i] = 0.0
            for j in range(d):
                turned[n + i] += rotation[i, j] * vectors[n + j]


class MassProperties:
    """Mass, centre and moments of inertia of the undeformed body, from its consistent mass.

    Attributes:
        directional: Mass of each owned unknown in motion along each direction, (d, n d), kg.
        mass: Of the body, kg.
        centre: Of the mass, (d,), m.
        arm: Places of the owned nodes from the centre, (n, d), m.
        tensor: Inertia tensor about the centre, (3, 3), in the plane (1, 1), kg m2.
    """

    def __init__(self, comm: MPI.Intracomm, nodes: Array, inertia: Callable[[Array], Array]):
        """Measure a body by its owned nodes, (n, d), and its product M x; collective."""
        self._comm, self._inertia = comm, inertia
        owned, d = nodes.shape
        unit = np.zeros((d, owned, d))
        for i in range(d):
            unit[i, :, i] = 1.0
        self.directional = np.array([inertia(unit[i].ravel()) for i in range(d)])
        sums = [
            self.directional[0] @ unit[0].ravel(),
            *(self.directional[i] @ nodes.ravel() for i in range(d)),
        ]
        total = global_sum(comm, np.array(sums))
        self.mass, self.centre = float(total[0]), total[1:] / total[0]
        self.arm = nodes - self.centre
        self._moment_row = inertia(self.arm.ravel()).reshape(-1, d)
        self._moment = global_sum(comm, self.arm.T @ self._moment_row)
        polar = float(np.trace(self._moment))
        self.tensor = np.array([[polar]]) if d == 2 else polar * np.eye(3) - self._moment

    def rotation(self, u: Array) -> Array:
        """The rotation R that fits the displacement u best, (d, d); collective."""
        if self._comm.size > 1:
            moment = u.reshape(self.arm.shape).T @ self._moment_row
            return polar_rotation(global_sum(self._comm, moment) + self._moment)
        rotation = np.empty(self._moment.shape)
        best_rotation(u, self._moment_row, self._moment, rotation)
        return rotation

    def rigid_motion(self, u: Array, v: Array, rotation: Array) -> RigidMotion:
        """Motion of the rigid body that has the same momentum and angular momentum; collective."""
        return self._split(u, v, rotation)[0]

    def vibration(self, u: Array, v: Array, rotation: Array, *, turns: bool) -> float:
        """Mean square of a velocity v over the mass, less that of the motion as a whole, m2/s2.

        The kinetic energy is that of the centre, of turning about it, and of what is left (Koenig).
        A body that stands on the ground does not turn. Collective.
        """
        whole, square = self._split(u, v, rotation)
        left = square - float(whole.velocity @ whole.velocity)
        if turns:
            spin = whole.spin if len(rotation) == 2 else rotation.T @ whole.spin
            left -= float(spin @ self.tensor @ spin) / self.mass
        return max(0.0, left)

    def _split(self, u: Array, v: Array, rotation: Array) -> tuple[RigidMotion, float]:
        """Motion as a whole at u, where the rotation fits best, and mean square of v, m2/s2."""
        d, axes = len(rotation), len(self.tensor)
        own, motion, spin = np.empty(2 * d + axes + 1), np.empty((2, d)), np.empty(axes)
        momenta(self.arm, u, v, self._inertia(v), self.directional, own)
        sums = global_sum(self._comm, own)
        velocities(sums, self.mass, rotation, self.tensor, motion, spin)
        return RigidMotion(motion[0], motion[1], spin, rotation), float(sums[-1]) / self.mass
