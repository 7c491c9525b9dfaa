"""Rigid blocks in the plane: three unknowns each, no mesh.

`PlaneSystem` holds any number of rectangular blocks on a rigid floor, or on a platform on a
horizontal spring and dashpot, both infinitely long, or on each other. Corners touch the floor, and
the faces of the block above or below; a block that falls off its carrier lands on the floor. Blocks
side by side do not notice each other. `advance` runs many steps at once in compiled code and
returns rows of a history. The equations: `plane_step`, `plane_contact`.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from solver.history.columns import check_filled, columns, row_layout
from solver.law.local_problem import named
from solver.rigid.ground import ground_of_steps
from solver.rigid.outcome import Advance
from solver.rigid.plane.model import new_memory, new_work
from solver.rigid.plane.rows import RUN, advance, stored_energy, write_row
from solver.rigid.plane.start import PlaneBlock, PlanePlatform, state_of, system_of
from solver.scene import Scene
from solver.scene.places import poses
from solver.scheme.generalized_alpha import GeneralizedAlpha
from solver.types import Array

#: Forces at the start are those of a trial step of this part of the first one.
TRIAL = 0.1


class PlaneSystem:
    """Rigid blocks in the plane, and how they stand at the moment."""

    def __init__(
        self,
        blocks: Sequence[PlaneBlock],
        scheme: GeneralizedAlpha,
        *,
        gravity: Sequence[float] = (0.0, -9.81),
        platform: PlanePlatform | None = None,
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
        self._platform = platform
        self._system = system_of(blocks, platform, gravity, scheme, velocity_solve)
        self._state = state_of(blocks, platform)
        points = len(self._system.corner_of)
        self._memory = new_memory(points)
        self._work = new_work(points, len(self._state.q), len(blocks))
        self._first = float(sum(stored_energy(self._system, self._state)))
        self._layout = row_layout(len(blocks), dimension=2, platform=platform is not None)

    @classmethod
    def from_scene(cls, scene: Scene) -> PlaneSystem:
        """The system of a scene in the plane whose blocks are all rigid.

        Args:
            scene: Its foundation is rigid or an oscillator.
        """
        platform = _platform(scene) if scene.has_platform else None
        return cls(
            blocks_of(scene, 0.0 if platform is None else platform.drift),
            GeneralizedAlpha(scene.time.rho_inf),
            gravity=scene.gravity_vector,
            platform=platform,
            velocity_solve=scene.contact.velocity_solve,
        )

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns of the rows: those of a history with all motions of the ground."""
        return columns(self.names, platform=self._platform is not None, vertical=True)

    @property
    def unknowns(self) -> int:
        """Number of unknowns."""
        return len(self._state.q)

    @property
    def rescued(self) -> dict[str, int]:
        """How many local contact problems Newton's method left to which other method."""
        return dict(named(self._work.counts[2:]))

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
            ground: (count + 1, 2) accelerations of the ground at the ends of the steps, m/s2,
                linear in between; None: it stands.
            smallest: To which part a step that fails is divided, s; 0: dt / 1024.
            mean: (count, 2) mean accelerations of the ground over the steps, m/s2, where they are
                not those of its ends.
        """
        motion, shift = ground_of_steps(count, 2, ground, mean)
        rows = np.full((count, len(self.columns)), np.nan)
        smallest = smallest or dt / 1024
        system, state, memory, work = self._system, self._state, self._memory, self._work
        start, layout = self._first, self._layout
        done, rejected = advance(
            system, state, memory, work, dt, smallest, motion, shift, start, layout, rows
        )
        rows[:done, RUN.time_s] = self.time + dt * np.arange(1, done + 1)
        check_filled(self.columns, rows[:done])
        self.time += dt * done
        failure = None
        if done < count:
            failure = f"no solution of the contact problem after {self.time:.6g} s"
        return Advance(rows=rows[:done], rejected=rejected, failure=failure)

    def saved(self) -> Any:
        """How everything stands at the moment, for `restore`."""
        return copy.deepcopy((self._state, self._memory, self._work, self.time))

    def restore(self, saved: Any) -> None:
        """Go back to where everything stood when it was saved."""
        self._state, self._memory, self._work, self.time = saved

    def row(self, dt: float, ground: Sequence[float] = (0.0, 0.0)) -> Array:
        """The row of this moment, before a step; its forces are those of the instant that follows.

        Args:
            dt: The step that follows, s.
            ground: Acceleration of the ground, m/s2.
        """
        state, memory, work = copy.deepcopy((self._state, self._memory, self._work))
        trial, row = np.full((2, 1, len(self.columns)), np.nan)
        motion, short = np.array([ground, ground], dtype=np.float64), TRIAL * dt
        none, start, layout = np.zeros((1, 2)), self._first, self._layout
        advance(self._system, state, memory, work, short, short, motion, none, start, layout, trial)
        gained = (float(state.v[-1]) - float(self._state.v[-1])) / short
        write_row(self._system, self._state, work, short, gained, start, layout, row[0])
        row[0, RUN.time_s], row[0, RUN.step_s], row[0, RUN.newton_iterations] = self.time, dt, 0
        row[0, RUN.contact_points_closed] = trial[0, RUN.contact_points_closed]
        row[0, RUN.base_acceleration_m_s2] = ground[0]
        row[0, RUN.base_vertical_acceleration_m_s2] = ground[1]
        check_filled(self.columns, row)
        return row[0]

    @property
    def drift(self) -> float:
        """Displacement of the platform, m; 0 without one."""
        return 0.0 if self._platform is None else float(self._state.q[-1])

    @property
    def drift_velocity(self) -> float:
        """Velocity of the platform, m/s; 0 without one."""
        return 0.0 if self._platform is None else float(self._state.v[-1])

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


def _platform(scene: Scene) -> PlanePlatform:
    """The platform of a scene; on an incline it starts where the spring holds what it carries."""
    mass, stiffness, damping = scene.platform()
    drift = 0.0
    if scene.time.initial == "static" and not any(spec.tilt for spec in scene.blocks):
        drift = (mass + scene.carried_mass) * scene.gravity_vector[0] / stiffness
    return PlanePlatform(mass=mass, stiffness=stiffness, damping=damping, drift=drift)


def blocks_of(scene: Scene, drift: float = 0.0) -> list[PlaneBlock]:
    """The blocks of a scene in the plane, in the order of the file, each where it starts.

    Args:
        scene: The scene.
        drift: Of the platform, m.
    """
    placed = poses(scene, drift=(drift, 0.0))
    blocks = []
    for spec in scene.blocks:
        assert isinstance(spec.angular_velocity, float)  # the scene saw to it in the plane
        blocks.append(
            PlaneBlock(
                name=spec.name,
                on=spec.on,
                shape=spec.shape,
                friction=scene.friction_of(spec),
                pose=placed[spec.name],
                velocity=spec.velocity,
                angular_velocity=spec.angular_velocity,
                restitution=spec.restitution or 0.0,
            )
        )
    return blocks
