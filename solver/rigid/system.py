"""Rigid blocks, the platform under them, and systems of them: starts, steps, rows.

`solver.rigid.plane.system` and `solver.rigid.space.system` have the states and the compiled steps.
"""

from __future__ import annotations

import copy
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from geometry.arrangement import Pose
from geometry.block import Block
from solver.history.columns import check_filled, columns, positions, row_layout
from solver.law.local_problem import named
from solver.scene import FrictionSpec, Scene
from solver.scene.places import Drift
from solver.scheme.generalized_alpha import GeneralizedAlpha
from solver.types import Array, Indices

GROUND = "foundation"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RigidBlock:
    """A block and how it starts, in the plane or in space."""

    name: str = "block"
    on: str = GROUND
    """Name of the block that carries it, or "foundation"."""
    shape: Block
    friction: FrictionSpec
    """On what carries it and on the ground."""
    pose: Pose
    """From its own frame, origin at the bottom centre, to where it stands; level 0: the ground."""
    velocity: Sequence[float] | Array | float = 0.0
    """Velocity of the centre, relative to the ground, m/s; 0: it rests."""
    angular_velocity: Sequence[float] | Array | float = 0.0
    """rad/s: in the plane clockwise, in space a vector or 0."""
    restitution: float = 0.0
    """e on what carries it and on the floor; 0: it lands without rebound."""

    @property
    def centre(self) -> Array:
        """Where its centre starts, m."""
        middle = np.zeros((1, len(self.pose.place)))
        middle[0, -1] = self.shape.height / 2
        return self.pose(middle)[0]


@dataclass(frozen=True, slots=True, kw_only=True)
class RigidPlatform:
    """A rigid platform on springs and dashpots, in space alike along x and y."""

    mass: float
    """kg."""
    stiffness: float
    """k, N/m."""
    damping: float = 0.0
    """c, N s/m."""
    drift: Drift = (0.0, 0.0)
    """Along x and y at the start, m; in the plane along x."""


def platform_of(scene: Scene) -> RigidPlatform | None:
    """The platform of a scene; on an incline it starts where the spring holds what it carries."""
    if not scene.has_platform:
        return None
    mass, stiffness, damping = scene.platform()
    drift = 0.0, 0.0
    if scene.time.initial == "static" and not any(spec.tilt for spec in scene.blocks):
        held = (mass + scene.carried_mass) / stiffness
        pull = *scene.gravity_vector[:-1], 0.0
        drift = held * pull[0], held * pull[1]
    return RigidPlatform(mass=mass, stiffness=stiffness, damping=damping, drift=drift)


def blocks_of(scene: Scene, drift: Drift = (0.0, 0.0)) -> list[RigidBlock]:
    """The blocks in the order of the scene, each where it starts; `drift` of the platform, m."""
    placed = scene.poses(drift=drift)
    return [
        RigidBlock(
            name=spec.name,
            on=spec.carrier,
            shape=spec.shape,
            friction=scene.friction_of(spec),
            pose=placed[spec.name],
            velocity=spec.velocity,
            angular_velocity=spec.angular_velocity,
            restitution=scene.restitution_of(spec),
        )
        for spec in scene.blocks
    ]


def carriers_of(blocks: Sequence[RigidBlock]) -> Indices:
    """Number of the block that carries each block, -1: ground or platform."""
    number = {GROUND: -1} | {block.name: b for b, block in enumerate(blocks)}
    return np.array([number[block.on] for block in blocks], dtype=np.int64)


TRIAL = 0.1
"""Forces at the start are those of a trial step of this part of the first one."""

FOLLOWING = (
    *("normal_force_N", "friction_force_N", "friction_force_second_N"),
    *("platform.acceleration_m_s2", "platform.acceleration_second_m_s2"),
    *("foundation.base_shear_N", "foundation.base_shear_second_N"),
)
"""Columns of blocks, platform and ground that tell of the instant after a moment."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Advance:
    """Rows of steps, and how they went."""

    rows: Array
    """One row a step that succeeded, in the order of the system's `columns`."""
    rejected: int
    """Solutions that failed and were tried again with smaller steps."""
    failure: str | None
    """When and why it stopped early, or None."""


class RigidSystem(ABC):
    """Rigid blocks, and how they stand at the moment."""

    dimension: ClassVar[int]

    moving: ClassVar[tuple[str, ...]]
    """Names of the attributes that steps change, besides the time."""

    def __init__(
        self,
        blocks: Sequence[RigidBlock],
        scheme: GeneralizedAlpha,
        *,
        gravity: Sequence[float] | None = None,
        platform: RigidPlatform | None = None,
        velocity_solve: bool = True,
    ):
        """Start at t = 0; without `gravity`, in m/s2, it is 9.81 downwards.

        `velocity_solve`: whether contact is also solved at velocity level after each step.
        """
        self.names = tuple(block.name for block in blocks)
        self.time = 0.0
        d, moves = self.dimension, platform is not None
        self.columns = columns(
            self.names, dimension=d, platform=moves, vertical=True, second=d == 3
        )
        """Names of the columns of the rows: those of a history with all motions of the ground."""
        self._run = positions("run", d)
        self._layout = row_layout(len(blocks), dimension=d, platform=moves)
        self._error = self._layout.energy + positions("energy", d).ledger_error_J
        pull = (*(0.0,) * (d - 1), -9.81) if gravity is None else gravity
        given = np.array(pull, dtype=np.float64)
        self._first = self._set_up(blocks, scheme, given, platform, velocity_solve)

    @classmethod
    def from_scene(cls, scene: Scene) -> Self:
        """The system of a scene of rigid blocks on rigid ground or an oscillator."""
        platform = platform_of(scene)
        return cls(
            blocks_of(scene, (0.0, 0.0) if platform is None else platform.drift),
            GeneralizedAlpha(scene.time.rho_inf),
            gravity=scene.gravity_vector,
            platform=platform,
            velocity_solve=scene.contact.velocity_solve,
        )

    @abstractmethod
    def _set_up(
        self,
        blocks: Sequence[RigidBlock],
        scheme: GeneralizedAlpha,
        gravity: Array,
        platform: RigidPlatform | None,
        velocity_solve: bool,
    ) -> float:
        """Make the arrays of the compiled code; returns the energy that they start with, J."""

    @property
    @abstractmethod
    def _counts(self) -> Indices:
        """Number of local problems by what came of them."""

    @abstractmethod
    def _run_steps(
        self, dt: float, smallest: float, ground: Array, shift: Array, rows: Array
    ) -> tuple[int, int]:
        """Fill rows but for their times; numbers of steps that succeeded, and of rejected ones.

        The energy at the start is still in the error of the ledger. No step is divided below the
        smallest. `ground`, (rows + 1, d), has its accelerations at the ends of the steps, `shift`,
        (rows, d), what its mean over each step has beyond that of its ends, m/s2.
        """

    @abstractmethod
    def _write_moment(self, row: Array) -> None:
        """The columns of blocks, platform and energies as things stand; forces have no meaning."""

    @property
    def unknowns(self) -> int:
        """Number of unknowns."""
        d, moves = self.dimension, self._layout.energy > self._layout.platform
        return d * (d + 1) // 2 * len(self.names) + (d - 1) * moves

    @property
    def rescued(self) -> dict[str, int]:
        """How many local contact problems Newton's method left to which other method."""
        return dict(named(self._counts))

    def advance(
        self,
        count: int,
        dt: float,
        ground: Array | None = None,
        smallest: float = 0.0,
        mean: Array | None = None,
    ) -> Advance:
        """Run `count` steps; one that fails is divided down to the smallest, by default dt / 1024.

        `ground`, (count + 1, d), has its accelerations at the ends of the steps, linear in between,
        m/s2; None: it stands. `mean`, (count, d), has those over the steps, where they are not
        those of the ends.
        """
        motion, shift = _ground_of_steps(count, self.dimension, ground, mean)
        filled: Array = np.full((count, len(self.columns)), np.nan)
        done, rejected = self._run_steps(dt, smallest or dt / 1024, motion, shift, filled)
        rows = filled[:done]
        rows[:, self._run.time_s] = self.time + dt * np.arange(1, done + 1)
        rows[:, self._error] -= self._first
        check_filled(self.columns, rows)
        self.time += dt * done
        failure = f"no solution of a step at {self.time:.6g} s" if done < count else None
        return Advance(rows=rows, rejected=rejected, failure=failure)

    def saved(self) -> dict[str, Any]:
        """How everything stands at the moment, for `restore`."""
        return copy.deepcopy({name: getattr(self, name) for name in ("time", *self.moving)})

    def restore(self, saved: dict[str, Any]) -> None:
        """Go back to where everything stood when it was saved."""
        for name, value in saved.items():
            setattr(self, name, value)

    def row(self, dt: float, ground: Sequence[float] | None = None) -> Array:
        """The row of this moment, before a step dt (s); its forces are those of the next instant.

        The ground has an acceleration, m/s2; None: it stands.
        """
        rows, d, short = np.full((2, len(self.columns)), np.nan), self.dimension, TRIAL * dt
        motion = np.tile(np.zeros(d) if ground is None else np.array(ground, float), (2, 1))
        trial, (after, row) = copy.deepcopy(self), rows
        done, _ = trial._run_steps(short, short / 1024, motion, np.zeros((1, d)), rows[:1])
        self._write_moment(row)
        taken = [k for k, name in enumerate(self.columns) if name.endswith(FOLLOWING)]
        row[: len(self._run)], row[taken] = after[: len(self._run)], after[taken]
        row[self._run.time_s], row[self._run.step_s] = self.time, dt
        row[self._run.newton_iterations] = 0
        row[self._error] -= self._first
        if done:  # else the forces are not known, and the step that follows fails and says so
            check_filled(self.columns, rows[1:])
        return row


def _ground_of_steps(
    count: int, dimension: int, ground: Array | None, mean: Array | None
) -> tuple[Array, Array]:
    """Accelerations of the ground at the ends of steps, and by how much both ends of each shift.

    Within a step, and the pieces into which events cut it, the ground's acceleration is linear; the
    shift gives it the right mean, so that no impulse goes missing whatever happens in between.
    """
    if ground is None:
        return np.zeros((count + 1, dimension)), np.zeros((count, dimension))
    ground = np.ascontiguousarray(ground, dtype=np.float64)
    if mean is None:
        return ground, np.zeros((count, dimension))
    return ground, np.ascontiguousarray(mean - (ground[1:] + ground[:-1]) / 2)
