"""How rigid blocks start: blocks and platform as data, from plain numbers and from a scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geometry.arrangement import Pose
from geometry.block import Block
from solver.scene import FrictionSpec, Scene
from solver.scene.places import Drift
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
            on=spec.on,
            shape=spec.shape,
            friction=scene.friction_of(spec),
            pose=placed[spec.name],
            velocity=spec.velocity,
            angular_velocity=spec.angular_velocity,
            restitution=spec.restitution or 0.0,
        )
        for spec in scene.blocks
    ]


def carriers_of(blocks: Sequence[RigidBlock]) -> Indices:
    """Number of the block that carries each block, -1: ground or platform."""
    number = {GROUND: -1} | {block.name: b for b, block in enumerate(blocks)}
    return np.array([number[block.on] for block in blocks], dtype=np.int64)
