"""How a scene with one block begins: Shenton (1996) from rest, else the forces at release."""

from __future__ import annotations

import math

from solver.excitation.motion import GroundMotion, read_ground
from solver.reference.friction import Resistance
from solver.reference.shenton import initial_mode, release_friction
from solver.scene import Scene


def resistance(scene: Scene) -> Resistance:
    """Friction under the only block of a scene."""
    block = scene.blocks[0]
    law = scene.friction_of(block)
    area = block.width * block.thickness
    return Resistance(law=law, cohesion=law.cohesion * area / block.shape.mass)


def demand(scene: Scene, ground: GroundMotion) -> float:
    """Largest horizontal acceleration of the base over gravity, an incline counted in: A.

    Where the ground also moves vertically, over the least gravity that remains; then it is more
    than what happens at any one time. Infinite where nothing remains.
    """
    along, down = scene.gravity_vector[0], -scene.gravity_vector[-1]
    left = down - (ground.up.peak if ground.up else 0.0)
    wanted = abs(along) + (ground.along.peak if ground.along else 0.0)
    return wanted / left if left > 0 else math.inf


def has_expected_mode(scene: Scene) -> bool:
    """Whether there is a criterion: one block on ground that does not give way, and gravity."""
    block = scene.blocks[0]
    moves = [*block.velocity[1:], *block.spins]
    in_plane = scene.motion is None or scene.motion.second is None
    in_plane = in_plane and (block.tilt == 0 or block.tilt_direction == 0)
    firm = scene.gravity > 0 and not scene.carrier_moves and not _sways(scene)
    return firm and len(scene.blocks) == 1 and in_plane and not any(moves)


def _sways(scene: Scene) -> bool:
    """Whether what carries the blocks is a mesh that is higher than wide: it moves by itself."""
    foundation = scene.foundation
    if not foundation.is_meshed or foundation.top is None or foundation.depth is None:
        return False
    return foundation.depth > foundation.top[0]


def expected_mode(scene: Scene, ground: GroundMotion | None = None) -> str:
    """Mode in which the only block of a scene on firm ground begins to move.

    "rest", "slide", "rock", "slide-rock" or "overturned"; from a tilt by the forces at release. The
    motion of the ground is read here where it is not given.
    """
    block, law = scene.blocks[0], resistance(scene)
    gravity, slender = -scene.gravity_vector[-1], block.height / block.width
    friction = law.holds(gravity, slipped=False) / gravity
    if block.tilt != 0:
        needed = release_friction(block.tilt, block.shape.slenderness)
        if abs(block.tilt) > block.shape.slenderness:
            return "overturned"
        return "rock" if friction >= needed else "slide-rock"
    speed = abs(block.velocity[0])
    if speed:
        # Friction at work, not what it could hold, decides whether the block trips over it.
        return "slide" if law.slides(gravity, speed) <= gravity / slender else "slide-rock"
    return initial_mode(demand(scene, ground or read_ground(scene)), friction, slender)
