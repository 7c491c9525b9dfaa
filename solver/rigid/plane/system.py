"""Rigid blocks in the plane: three unknowns each, no mesh.

`PlaneSystem` holds any number of rectangular blocks on a rigid floor, or on a platform on a
horizontal spring and dashpot, both infinitely long, or on each other. Corners touch the floor, and
the faces of the block above or below; a block that falls off its carrier lands on the floor. Blocks
side by side do not notice each other. `advance` runs many steps at once in compiled code and
returns rows of a history. The equations stand in `step` and `contact` beside this file.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from solver.rigid.plane.model import new_memory, new_work, state_of, system_of
from solver.rigid.plane.rows import advance, stored_energy, write_row
from solver.rigid.system import RigidBlock, RigidPlatform, RigidSystem
from solver.scheme.generalized_alpha import GeneralizedAlpha
from solver.types import Array, Indices


class PlaneSystem(RigidSystem):
    """Rigid blocks in the plane, and how they stand at the moment."""

    dimension = 2
    moving = ("_state", "_memory", "_work")

    def _set_up(
        self,
        blocks: Sequence[RigidBlock],
        scheme: GeneralizedAlpha,
        gravity: Array,
        platform: RigidPlatform | None,
        velocity_solve: bool,
    ) -> float:
        """Make the arrays of the compiled code; returns the energy that they start with, J."""
        self._system = system_of(blocks, platform, gravity, scheme, velocity_solve)
        self._state = state_of(blocks, platform)
        points = len(self._system.corner_of)
        self._memory = new_memory(points)
        self._work = new_work(points, len(self._state.q), len(blocks))
        return sum(stored_energy(self._system, self._state))

    @property
    def _counts(self) -> Indices:
        """Number of local problems by what came of them."""
        return self._work.counts[2:]

    def _run_steps(
        self, dt: float, smallest: float, ground: Array, shift: Array, rows: Array
    ) -> tuple[int, int]:
        """Fill rows but for their times; numbers of steps that succeeded, and of rejected ones."""
        parts = self._system, self._state, self._memory, self._work
        return advance(*parts, dt, smallest, ground, shift, self._layout, rows)

    def _write_moment(self, row: Array) -> None:
        """The columns of blocks, platform and energies as things stand; forces have no meaning."""
        write_row(self._system, self._state, self._work, 1.0, 0.0, self._layout, row)

    @property
    def drift(self) -> Array:
        """Displacement of the platform, m, (1,); empty without one."""
        return self._state.q[3 * len(self.names) :].copy()

    @property
    def drift_velocity(self) -> Array:
        """Velocity of the platform, m/s, (1,); empty without one."""
        return self._state.v[3 * len(self.names) :].copy()

    def centre(self, block: int) -> Array:
        """Centre of a block, m."""
        return self._state.q[3 * block : 3 * block + 2].copy()

    def angle(self, block: int) -> float:
        """Angle of a block, rad, clockwise, not wrapped."""
        return float(self._state.q[3 * block + 2])

    def rotation(self, block: int) -> Array:
        """Rotation matrix of a block."""
        c, s = math.cos(self.angle(block)), math.sin(self.angle(block))
        return np.array([[c, s], [-s, c]])

    def velocity(self, block: int) -> Array:
        """Velocity of the centre of a block, m/s."""
        return self._state.v[3 * block : 3 * block + 2].copy()

    def angular_velocity(self, block: int) -> float:
        """Angular velocity of a block, rad/s, clockwise."""
        return float(self._state.v[3 * block + 2])
