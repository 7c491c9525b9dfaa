"""Initiation of motion of a rigid block: Shenton's (1996) criteria for rest, sliding and rocking.

r = H/B; A = horizontal acceleration of the base over gravity; mu = friction, static = dynamic.
"""

from __future__ import annotations

import math

from geometry.block import Block


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
    """Whether the mode changes where A and mu change by no more than a part `band` of themselves.

    Arguments as those of `initial_mode`.
    """
    factors = (1 - band, 1.0, 1 + band)
    modes = {
        initial_mode(a * acceleration, f * friction, slenderness_ratio)
        for a in factors
        for f in factors
    }
    return len(modes) > 1
