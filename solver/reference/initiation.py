"""Initiation of motion of a rigid block: Shenton's (1996) criteria for rest, sliding and rocking.

r = H/B; A = horizontal acceleration of the base over gravity; mu = friction, static = dynamic. From
rest these criteria say how the only block of a scene begins to move, else the forces at release.

For a block that is uneven they are derived again, about the edge that it turns about: r = h/b by
the height of the centre of mass and its distance from that edge, and j = I/(m b^2), which is (1 +
r^2)/3 where the block is even.
"""

from __future__ import annotations

import math

import numpy as np

from geometry.block import SIDES, Block
from solver.excitation.motion import GroundMotion, read_ground
from solver.excitation.sampled import SampledMotion
from solver.reference.sliding import Resistance
from solver.scene import Scene
from solver.types import Array


def rocking_friction(
    acceleration: float, slenderness_ratio: float, inertia: float | None = None
) -> float:
    """Friction that pure rocking needs: mu_R(A) = [A (4 + r^2) + 3 r] / [1 + 4 r^2 + 3 r A].

    A = |a_g|/g >= 1/r, r = H/B. With the inertia j it is [A (1 + j) + r] / [j + r^2 + r A].
    """
    a, r = acceleration, slenderness_ratio
    if inertia is not None:
        return (a * (1 + inertia) + r) / (inertia + r**2 + r * a)
    return (a * (4 + r**2) + 3 * r) / (1 + 4 * r**2 + 3 * r * a)


def initial_mode(
    acceleration: float, friction: float, slenderness_ratio: float, inertia: float | None = None
) -> str:
    """Mode in which a block at rest answers to a sudden acceleration of its base, A = |a_g|/g.

    "rest", "slide", "rock" or "slide-rock", by mu and r = H/B, and by j of an uneven block.
    """
    uplift = 1 / slenderness_ratio
    if acceleration <= min(friction, uplift):
        return "rest"
    if acceleration <= uplift or friction <= uplift:
        return "slide"
    needed = rocking_friction(acceleration, slenderness_ratio, inertia)
    return "rock" if friction >= needed else "slide-rock"


def release_friction(angle: float, slenderness: float, share: float = 0.75) -> float:
    """Friction that a block needs to rock from a tilt without sliding, at its release from rest.

    With phi = alpha - |theta| the lean of the half diagonal, theta'' = -p^2 sin(phi) (Housner 1963)
    moves the centre; force over normal force is (3/4) sin(phi) cos(phi) / (1 - (3/4) sin^2(phi)).
    Of an uneven block the `share` m R^2/I_o stands for 3/4.
    """
    lean = slenderness - abs(angle)
    return abs(share * math.sin(lean) * math.cos(lean) / (1 - share * math.sin(lean) ** 2))


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


INSTANTS = 20_000
"""Instants at which the largest acceleration in one direction is looked for."""


def _demand_towards(scene: Scene, ground: GroundMotion, side: int) -> float:
    """The same of accelerations with which a block leans to a side: those to the other one."""
    along, down = scene.gravity_vector[0], -scene.gravity_vector[-1]
    left = down - (ground.up.peak if ground.up else 0.0)
    motion, most = ground.along, 0.0
    if isinstance(motion, SampledMotion):
        most = float(np.max(-side * motion.value, initial=0.0))
    elif motion is not None:
        times: Array = np.arange(INSTANTS, dtype=np.float64) * (
            min(motion.stop, scene.time.end) / INSTANTS
        )
        most = float(np.max(-side * motion.acceleration(times)))
    wanted = max(0.0, side * along + max(0.0, most))
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
    motion of the ground is read here where it is not given. Of an uneven block each side has its
    own peak, and the one counts where it does more.
    """
    block, law = scene.blocks[0], resistance(scene)
    gravity, shape = -scene.gravity_vector[-1], block.shape
    friction = law.holds(gravity, slipped=False) / gravity
    if block.tilt != 0:
        side = 1 if block.tilt > 0 else -1
        square = shape.mass * shape.radius(side) ** 2
        share = square / shape.rotary_inertia_about_corner(side)
        needed = release_friction(block.tilt, shape.slenderness(side), share)
        if abs(block.tilt) > shape.slenderness(side):
            return "overturned"
        return "rock" if friction >= needed else "slide-rock"
    speed = block.velocity[0]
    if speed:
        # Friction at work, not what it could hold, decides whether the block trips over it.
        limit = gravity * shape.uplift(1 if speed > 0 else -1)
        return "slide" if law.slides(gravity, abs(speed)) <= limit else "slide-rock"
    ground = ground or read_ground(scene)
    if shape.is_even:
        return initial_mode(demand(scene, ground), friction, block.height / block.width)
    found = {
        side: initial_mode(
            _demand_towards(scene, ground, side),
            friction,
            1 / shape.uplift(side),
            shape.rotary_inertia / (shape.mass * shape.arm(side) ** 2),
        )
        for side in SIDES
    }
    return max(found.values(), key=("rest", "slide", "slide-rock", "rock").index)
