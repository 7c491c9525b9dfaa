"""Rigid blocks in space: six unknowns each, no mesh.

`SpaceSystem` holds any number of rectangular blocks on a rigid ground, or on a platform that moves
along x and y on springs, in stacks as they like; `advance` runs many steps at once in compiled code
and returns rows of a history. What touches what stands in `contact` beside this file, the equations
in `rotation` and `solve`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from solver.rigid.space.advance import run
from solver.rigid.space.model import model_of, state_of
from solver.rigid.space.rotation import rotation_of
from solver.rigid.space.rows import record, stored_energy
from solver.rigid.system import RigidBlock, RigidPlatform, RigidSystem
from solver.scheme.generalized_alpha import GeneralizedAlpha
from solver.types import Array, Indices


class SpaceSystem(RigidSystem):
    """Rigid blocks in space, and how they stand at the moment."""

    dimension = 3
    moving = ("_state", "_seen")

    def _set_up(
        self,
        blocks: Sequence[RigidBlock],
        scheme: GeneralizedAlpha,
        gravity: Array,
        platform: RigidPlatform | None,
        velocity_solve: bool,
    ) -> float:
        """Make the arrays of the compiled code; returns the energy that they start with, J."""
        self._model = model_of(blocks, scheme, gravity, platform, velocity_solve)
        self._state = state_of(blocks, self._model, platform)
        self._seen = np.zeros((len(blocks), 4))
        return sum(stored_energy(self._model, self._state))

    @property
    def _counts(self) -> Indices:
        """Number of local problems by what came of them."""
        return self._state.settled

    def _run_steps(
        self, dt: float, smallest: float, ground: Array, shift: Array, rows: Array
    ) -> tuple[int, int]:
        """Fill rows but for their times; numbers of steps that succeeded, and of rejected ones."""
        parts = self._model, self._state
        return run(*parts, dt, smallest, ground, shift, self._seen, self._layout, rows)

    def _write_moment(self, row: Array) -> None:
        """The columns of blocks, platform and energies as things stand; forces have no meaning."""
        none, parts = np.zeros((len(self.names) + 1, 3)), (self._model, self._state)
        record(*parts, none[0], self._seen, none, none[0], self._layout, row)

    @property
    def drift(self) -> Array:
        """Displacement of the platform along x and y, m."""
        return self._state.place[-1, :2].copy()

    @property
    def drift_velocity(self) -> Array:
        """Velocity of the platform along x and y, m/s."""
        return self._state.velocity[-1, :2].copy()

    def centre(self, block: int) -> Array:
        """Centre of a block, m."""
        return self._state.place[block].copy()

    def rotation(self, block: int) -> Array:
        """Rotation matrix of a block."""
        return rotation_of(self._state.quaternion[block])

    def velocity(self, block: int) -> Array:
        """Velocity of the centre of a block, m/s."""
        return self._state.velocity[block].copy()

    def angular_velocity(self, block: int) -> Array:
        """Angular velocity of a block, in space, rad/s."""
        return self.rotation(block) @ self._state.spin[block]
