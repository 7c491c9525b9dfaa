"""Initiation of motion of a rigid block: Shenton's (1996) criteria for rest, sliding and rocking.

r = H/B; A = horizontal acceleration of the base over gravity; mu = friction, static = dynamic. From
rest these criteria say how the only block of a scene begins to move, else the forces at release.
"""

from __future__ import annotations

import math

from geometry.block import Block
from solver.excitation.motion import GroundMotion, read_ground
from solver.reference.sliding import Resistance
from solver.scene import Scene


def rocking_friction(acceleration: float, slenderness_ratio: float) -> float:
    """Friction that pure rocking needs: mu_R(A) = [A (4 + r^2) + 3 r] / [1 + 4 r^2 + 3 r A].

    A = |a_g|/g >= 1/r, r = H/B.
    """
    a, r = acceleration, slenderness_ratio
    return (a * (4 + r**2) + 3 * r) / (1 + 4 * r**2 + 3 * r * a)


def initial_mode(acceleration: float, friction: float, slenderness_ratio: float) -> str:
    """Mode in which a block at rest answers to a sudden acceleration of its base, A = |a_g|/g.

    "rest", "slide", "rock" or "slide-rock", by mu and r = H/B.
    """
    uplift = 1 / slenderness_ratio
    if acceleration <= min(friction, uplift):
        return "rest"
    if acceleration <= uplift or friction <= uplift:
        return "slide"
    return "rock" if friction >= rocking_friction(acceleration, slenderness_ratio) else "slide-rock"


def release_friction(angle: float, slenderness: float) -> float:
    """Friction that a block needs to rock from a tilt without sliding, at its release from rest.

    With phi = alpha - |theta| the lean of the half diagonal, theta'' = -p^2 sin(phi) (Housner 1963)
    moves the centre; force over normal force is (3/4) sin(phi) cos(phi) / (1 - (3/4) sin^2(phi)).
    """
    lean = slenderness - abs(angle)
    return abs(0.75 * math.sin(lean) * math.cos(lean) / (1 - 0.75 * math.sin(lean) ** 2))


def initial_accelerations(
    acceleration: float, friction: float, shape: Block, gravity: float
) -> tuple[float, float]:
    """Angular acceleration and slip acceleration of the block as its motion begins.

    With a = A g, half width b and half height h (Shenton 1996): theta'' = (3/4) (a h - g b)/(b^2 +
    h^2) where it rocks, theta'' = 3 g (mu r - 1)/[b (4 + r^2 - 3 mu r)] where it slides and rocks,
    whatever a; the corner slips with a - h theta'' - mu (g + b theta'') where it slides.

    Args:
        acceleration: A = |a_g|/g.
        friction: mu.
        shape: The block.
        gravity: g, m/s^2.

    Returns:
        theta'' (rad/s^2) and slip'' (m/s^2), both >= 0: the block leans and slips against the
        acceleration of the base.
    """
    r, b, h = shape.height / shape.width, shape.width / 2, shape.height / 2
    a, mode = acceleration * gravity, initial_mode(acceleration, friction, r)
    if mode == "rest":
        return 0.0, 0.0
    if mode == "rock":
        return 0.75 * (a * h - gravity * b) / (b**2 + h**2), 0.0
    turn = 0.0
    if mode == "slide-rock":
        turn = 3 * gravity * (friction * r - 1) / (b * (4 + r**2 - 3 * friction * r))
    return turn, a - h * turn - friction * (gravity + b * turn)


def near_boundary(
    acceleration: float, friction: float, slenderness_ratio: float, band: float
) -> bool:
    """True if the mode changes where A and mu change by no more than a part `band` of themselves.

    Arguments as those of `initial_mode`.
    """
    factors = (1 - band, 1.0, 1 + band)
    modes = {
        initial_mode(a * acceleration, f * friction, slenderness_ratio)
        for a in factors
        for f in factors
    }
    return len(modes) > 1


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
    """True if there is a criterion: one block on ground that does not give way, and gravity.

    Neither links nor forces.
    """
    block = scene.blocks[0]
    moves = [*block.velocity[1:], *block.spins]
    in_plane = scene.motion is None or scene.motion.second is None
    in_plane = in_plane and (block.tilt == 0 or block.tilt_direction == 0)
    firm = scene.gravity > 0 and not scene.carrier_moves and not _sways(scene)
    stands = len(scene.blocks) == 1 and block.position is None
    stands = stands and not (scene.links or scene.forces)
    return firm and stands and in_plane and not any(moves)


def _sways(scene: Scene) -> bool:
    """True if what carries the blocks is a mesh that is higher than wide: it moves by itself."""
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
