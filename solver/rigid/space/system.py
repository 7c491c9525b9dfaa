"""Rigid blocks in space: six unknowns each, no mesh.

`SpaceSystem` holds any number of rectangular blocks on a rigid ground, or on a platform that moves
along x and y on springs, in stacks as they like; `advance` runs many steps at once in compiled code
and returns rows of a history. What touches what: `space_contact`; the equations: `space_rotation`
and `space_solve`.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import Any

import numpy as np

from solver.history.columns import check_filled, columns, row_layout
from solver.law.local_problem import named
from solver.rigid.ground import ground_of_steps
from solver.rigid.outcome import Advance
from solver.rigid.space.advance import run
from solver.rigid.space.rotation import rotation_of
from solver.rigid.space.rows import BLOCK, ENERGY, RUN, record, stored_energies
from solver.rigid.space.start import (
    SpaceBlock,
    SpacePlatform,
    blocks_of,
    model_of,
    platform_of,
    state_of,
)
from solver.scene import Scene
from solver.scheme.generalized_alpha import GeneralizedAlpha
from solver.types import Array

TRIAL = 0.1
"""Forces at the start are those of a trial step of this part of the first one."""


class SpaceSystem:
    """Rigid blocks in space, and how they stand at the moment."""

    def __init__(
        self,
        blocks: Sequence[SpaceBlock],
        scheme: GeneralizedAlpha,
        *,
        gravity: Sequence[float] = (0.0, 0.0, -9.81),
        platform: SpacePlatform | None = None,
        velocity_solve: bool = True,
    ):
        """Start at t = 0.

        Args:
            blocks: In any order.
            scheme: Time stepping.
            gravity: m/s2.
            platform: What carries the blocks, if it moves.
            velocity_solve: Whether contact is also solved at velocity level after each step.
        """
        self.names = tuple(block.name for block in blocks)
        self.time = 0.0
        self._model = model_of(blocks, scheme, np.array(gravity, float), platform, velocity_solve)
        self._state = state_of(blocks, self._model, platform)
        self._seen = np.zeros((len(blocks), 4))
        self._first = float(stored_energies(self._model, self._state).sum())
        moves = platform is not None
        self._layout = row_layout(len(blocks), dimension=3, platform=moves)

    @classmethod
    def from_scene(cls, scene: Scene) -> SpaceSystem:
        """The system of a scene in space whose blocks are all rigid.

        Args:
            scene: Its foundation is rigid or an oscillator.
        """
        platform = platform_of(scene)
        return cls(
            blocks_of(scene, (0.0, 0.0) if platform is None else platform.drift),
            GeneralizedAlpha(scene.time.rho_inf),
            gravity=scene.gravity_vector,
            platform=platform,
            velocity_solve=scene.contact.velocity_solve,
        )

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns of the rows: those of a history with all motions of the ground."""
        moves = bool(self._model.mass[-1] > 0)
        return columns(self.names, dimension=3, platform=moves, vertical=True, second=True)

    @property
    def rescued(self) -> dict[str, int]:
        """How many local contact problems Newton's method left to which other method."""
        return dict(named(self._state.settled))

    def advance(
        self,
        count: int,
        dt: float,
        ground: Array | None = None,
        smallest: float = 0.0,
        mean: Array | None = None,
    ) -> Advance:
        """Run `count` steps.

        Args:
            count: Number of steps.
            dt: Step, s.
            ground: (count + 1, 3) accelerations of the ground at the ends of the steps, m/s2,
                linear in between; None: it stands.
            smallest: To which part a step that fails is divided, s; 0: dt / 1024.
            mean: (count, 3) mean accelerations of the ground over the steps, m/s2, where they are
                not those of its ends.
        """
        motion, shift = ground_of_steps(count, 3, ground, mean)
        rows = np.full((count, len(self.columns)), np.nan)
        smallest, layout = smallest or dt / 1024, self._layout
        done, rejected = run(
            self._model, self._state, dt, smallest, motion, shift, self._seen, layout, rows
        )
        rows[:done, RUN.time_s] = self.time + dt * np.arange(1, done + 1)
        rows[:, layout.energy + ENERGY.ledger_error_J] -= self._first
        check_filled(self.columns, rows[:done])
        self.time += dt * done
        failure = f"no solution of a step at {self.time:.6g} s" if done < count else None
        return Advance(rows=rows[:done], rejected=rejected, failure=failure)

    def saved(self) -> Any:
        """How everything stands at the moment, for `restore`."""
        return copy.deepcopy((self._state, self._seen, self.time))

    def restore(self, saved: Any) -> None:
        """Go back to where everything stood when it was saved."""
        self._state, self._seen, self.time = saved

    def row(self, dt: float, ground: Sequence[float] = (0.0, 0.0, 0.0)) -> Array:
        """The row of this moment, before a step; its forces are those of the instant that follows.

        Args:
            dt: The step that follows, s.
            ground: Acceleration of the ground, m/s2.
        """
        trial, row = np.full((2, 1, len(self.columns)), np.nan)
        seen, layout = self._seen.copy(), self._layout
        state = copy.deepcopy(self._state)
        motion, short = np.array([ground, ground], dtype=np.float64), TRIAL * dt
        still = np.zeros((1, 3))
        run(self._model, state, short, short / 1024, motion, still, seen, layout, trial)
        none = np.zeros((len(self.names) + 1, 3))
        gained = (state.velocity[-1] - self._state.velocity[-1]) / short
        record(self._model, self._state, motion[0], self._seen, none, gained, layout, row[0])
        forces = [BLOCK.normal_force_N, BLOCK.friction_force_N, BLOCK.friction_force_second_N]
        first = layout.block + layout.stride * np.arange(len(self.names))
        taken = np.append(np.add.outer(first, forces), RUN.contact_points_closed)
        row[:, taken] = trial[:, taken]
        row[0, RUN.time_s], row[0, RUN.step_s], row[0, RUN.newton_iterations] = self.time, dt, 0
        row[0, layout.energy + ENERGY.ledger_error_J] -= self._first
        check_filled(self.columns, row)
        return row[0]

    @property
    def drift(self) -> Array:
        """Displacement of the platform along x and y, m."""
        return self._state.place[-1, :2].copy()

    @property
    def drift_velocity(self) -> Array:
        """Velocity of the platform along x and y, m/s."""
        return self._state.velocity[-1, :2].copy()

    @property
    def unknowns(self) -> int:
        """Number of unknowns."""
        return 6 * len(self.names) + 2 * bool(self._model.mass[-1] > 0)

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
