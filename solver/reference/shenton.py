"""Initiation of motion of a rigid block: Shenton's (1996) criteria for rest, sliding and rocking.

r = H/B; A = horizontal acceleration of the base over gravity; mu = friction, static = dynamic.
"""

from __future__ import annotations

import math


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
