"""How rigid blocks in space start: from plain numbers, and from a scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geometry.arrangement import Pose
from geometry.block import Block
from solver.law.friction import PAST, FrictionLaws
from solver.law.local_problem import new_counts
from solver.rigid.space.boxes import SLOTS
from solver.rigid.space.model import AWAY, SpaceMemory, SpaceModel, SpaceState
from solver.rigid.space.rotation import quaternion_of, rotation_of
from solver.scene import FrictionSpec, Scene
from solver.scene.places import poses
from solver.scheme.generalized_alpha import GeneralizedAlpha
from solver.types import Array

GROUND = "foundation"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SpaceBlock:
    """A block and how it starts."""

    name: str
    on: str = GROUND
    """Name of the block that carries it, or "foundation"."""
    shape: Block
    friction: FrictionSpec
    """On what carries it and on the ground."""
    pose: Pose
    """From its own frame, origin at the bottom centre, to where it stands; the floor is z = 0."""
    velocity: Sequence[float] | Array = (0.0, 0.0, 0.0)
    """Of the centre, relative to the ground, m/s."""
    angular_velocity: Sequence[float] | Array = (0.0, 0.0, 0.0)
    """In space, rad/s."""

    @property
    def half(self) -> Array:
        """Half of width, thickness and height, m."""
        shape = self.shape
        return 0.5 * np.array([shape.width, shape.thickness, shape.height])

    @property
    def centre(self) -> Array:
        """Where its centre starts, m."""
        return self.pose(np.array([[0.0, 0.0, self.shape.height / 2]]))[0]

    @property
    def inertia(self) -> Array:
        """Principal moments of inertia about its centre, kg m2."""
        square = self.half**2
        return self.shape.mass / 3 * (square.sum() - square)


@dataclass(frozen=True, slots=True, kw_only=True)
class SpacePlatform:
    """A rigid platform on springs and dashpots, alike along x and y."""

    mass: float
    """kg."""
    stiffness: float
    """N/m."""
    damping: float = 0.0
    """N s/m."""
    drift: tuple[float, float] = (0.0, 0.0)
    """Along x and y at the start, m."""


def platform_of(scene: Scene) -> SpacePlatform | None:
    """The platform of a scene; on an incline it starts where the spring holds what it carries."""
    if not scene.has_platform:
        return None
    mass, stiffness, damping = scene.platform()
    drift = 0.0, 0.0
    if scene.time.initial == "static" and not any(spec.tilt for spec in scene.blocks):
        held = (mass + scene.carried_mass) / stiffness
        drift = held * scene.gravity_vector[0], held * scene.gravity_vector[1]
    return SpacePlatform(mass=mass, stiffness=stiffness, damping=damping, drift=drift)


def blocks_of(scene: Scene, drift: tuple[float, float] = (0.0, 0.0)) -> list[SpaceBlock]:
    """The blocks of a scene in space, in the order of the file, each where it starts.

    Args:
        scene: The scene.
        drift: Of the platform, m.
    """
    placed = poses(scene, drift=drift)
    return [
        SpaceBlock(
            name=spec.name,
            on=spec.on,
            shape=spec.shape,
            friction=scene.friction_of(spec),
            pose=placed[spec.name],
            velocity=spec.velocity,
            angular_velocity=np.broadcast_to(spec.angular_velocity, 3),
        )
        for spec in scene.blocks
    ]


def model_of(
    blocks: Sequence[SpaceBlock],
    scheme: GeneralizedAlpha,
    gravity: Array,
    platform: SpacePlatform | None,
    velocity_solve: bool,
) -> SpaceModel:
    """The constants of the compiled code."""
    n, base = len(blocks), platform or SpacePlatform(mass=0.0, stiffness=0.0)
    number = {block.name: b for b, block in enumerate(blocks)}
    carried = [b for b, block in enumerate(blocks) if block.on != GROUND]
    upper = np.array([*range(n), *carried], dtype=np.int64)
    lower = np.array([n] * n + [number[blocks[b].on] for b in carried], dtype=np.int64)
    own = np.arange(n)
    own[carried] = n + np.arange(len(carried))
    nothing = np.zeros((1, 3))
    return SpaceModel(
        mass=np.array([*(block.shape.mass for block in blocks), base.mass]),
        inertia=np.concatenate([*(block.inertia[None] for block in blocks), nothing]),
        half=np.concatenate([*(block.half[None] for block in blocks), nothing]),
        upper=upper,
        lower=lower,
        carried=own,
        law=FrictionLaws.of([blocks[b].friction for b in upper]),
        spring=np.array([base.stiffness, base.damping]),
        gravity=gravity,
        scheme=np.array([scheme.alpha_m, scheme.alpha_f, scheme.beta]),
        velocity_solve=velocity_solve,
    )


def new_memory(pairs: int) -> SpaceMemory:
    """The memory of points that have touched nothing yet."""
    size = pairs, SLOTS
    return SpaceMemory(
        force=np.zeros((*size, 3)),
        face=np.full(size, AWAY, dtype=np.int64),
        rest=np.zeros(size),
        past=np.zeros((*size, PAST)),
    )


def state_of(
    blocks: Sequence[SpaceBlock],
    model: SpaceModel,
    platform: SpacePlatform | None,
) -> SpaceState:
    """Where the blocks start, and the platform, whose inertia balances its spring."""
    n = len(blocks)
    place, velocity, spin = np.zeros((n + 1, 3)), np.zeros((n + 1, 3)), np.zeros((n + 1, 3))
    quaternion = np.zeros((n + 1, 4))
    quaternion[n, 0] = 1.0
    if platform is not None:
        place[n, :2] = platform.drift
    for b, block in enumerate(blocks):
        place[b], velocity[b] = block.centre, block.velocity
        quaternion[b] = quaternion_of(block.pose.rotation)
        spin[b] = rotation_of(quaternion[b]).T @ np.asarray(block.angular_velocity)
    pairs, inertia_force = len(model.upper), -model.spring[0] * place[n, :2]
    return SpaceState(
        place=place,
        quaternion=quaternion,
        velocity=velocity,
        spin=spin,
        inertia_force=inertia_force,
        memory=new_memory(pairs),
        slip=np.zeros((n, 2)),
        settled=new_counts(),
        exchanged=np.zeros(5),
    )
