"""Mass properties of a meshed body: what moves as a whole in a motion, and what is left of it."""

from __future__ import annotations

from collections.abc import Callable

from mpi4py import MPI

import numpy as np

from solver.bodies.kinematics import RigidMotion, polar_rotation
from solver.kernels import meshed
from solver.parallel import global_sum
from solver.types import Array


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
        meshed.best_rotation(u, self._moment_row, self._moment, rotation)
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
        meshed.momenta(self.arm, u, v, self._inertia(v), self.directional, own)
        sums = global_sum(self._comm, own)
        meshed.velocities(sums, self.mass, rotation, self.tensor, motion, spin)
        return RigidMotion(motion[0], motion[1], spin, rotation), float(sums[-1]) / self.mass
