"""A rigid platform on a horizontal spring and dashpot."""

from __future__ import annotations

from mpi4py import MPI

import numpy as np

from solver.bodies.dense_body import DenseBody
from solver.bodies.kinematics import RigidMotion
from solver.types import Array


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
