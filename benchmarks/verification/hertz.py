"""Contact of two elastic cylinders: Hertz, and Cattaneo and Mindlin for a tangential load.

They are parallel and in plane strain, with loads per metre of length. All formulas hold for small
strain, a/R << 1.

Sources: Johnson, Contact Mechanics (1985), chapters 4 (normal load), 5 (approach of cylinders) and
7 (tangential load); Cattaneo (1938); Mindlin (1949).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from solver.types import Array


def contact_modulus(*bodies: tuple[float, float]) -> float:
    """Contact modulus E*, Pa: 1/E* = sum of (1 - nu^2)/E over the bodies that deform.

    Args:
        bodies: Young's modulus E (Pa) and Poisson's ratio nu of each; a rigid body is left out.
    """
    return 1 / sum((1 - nu**2) / young for young, nu in bodies)


def contact_radius(*radii: float) -> float:
    """Relative radius R, m: 1/R = sum of 1/R_i.

    Args:
        radii: Radius R_i of each body, m; a plane is left out, or has the radius infinity.
    """
    return 1 / sum(1 / radius for radius in radii)


@dataclass(frozen=True, slots=True, kw_only=True)
class HertzLine:
    """Two cylinders, pressed together by P per metre."""

    load: float
    """P, N/m."""
    radius: float
    """R, m; see `contact_radius`."""
    modulus: float
    """E*, Pa; see `contact_modulus`."""

    @property
    def half_width(self) -> float:
        """Half-width of the contact a = sqrt(4 P R / (pi E*)), m."""
        return math.sqrt(4 * self.load * self.radius / (math.pi * self.modulus))

    @property
    def peak_pressure(self) -> float:
        """Largest pressure p_0 = 2 P / (pi a), Pa."""
        return 2 * self.load / (math.pi * self.half_width)

    def pressure(self, x: Array) -> Array:
        """Pressure p_0 sqrt(1 - x^2/a^2), Pa, at distance x (m) from the middle; 0 outside."""
        return self.peak_pressure * _ellipse(x, self.half_width)


def centre_approach(contact: HertzLine) -> float:
    """Approach of the centre of an elastic disc to rigid ground, m (Johnson 1985, Eq. 5.57).

    delta = P/(pi E*) [2 ln(4 R/a) - 1]; in line contact the approach depends on the point of the
    body that it is measured at.

    Args:
        contact: The normal contact; its R is the radius of the disc.
    """
    compliance = (2 * math.log(4 * contact.radius / contact.half_width) - 1) / math.pi
    return contact.load * compliance / contact.modulus


def stick_half_width(contact: HertzLine, tangential: float, friction: float) -> float:
    """Half-width of the stick zone c = a sqrt(1 - Q/(mu P)), m (Cattaneo 1938, Mindlin 1949).

    Args:
        contact: The normal contact, pressed first.
        tangential: Q, N/m, |Q| <= mu P.
        friction: mu.

    Raises:
        ValueError: Where |Q| > mu P.
    """
    return contact.half_width * math.sqrt(1 - _used(contact.load, tangential, friction))


def shear_traction(contact: HertzLine, tangential: float, friction: float, x: Array) -> Array:
    """Tangential traction of a line contact, Pa, at distance x (m) from the middle.

    q = mu p_0 [sqrt(1 - x^2/a^2) - (c/a) sqrt(1 - x^2/c^2)], the second root in the stick zone
    |x| < c only; it has the direction of Q.

    Args:
        contact: The normal contact, pressed first.
        tangential: Q, N/m, |Q| <= mu P.
        friction: mu.
        x: Distances, m.

    Raises:
        ValueError: Where |Q| > mu P.
    """
    a, c = contact.half_width, stick_half_width(contact, tangential, friction)
    full = friction * contact.pressure(x)
    held = friction * contact.peak_pressure * c / a * _ellipse(x, c) if c > 0 else 0.0
    return math.copysign(1, tangential) * (full - held)


def _used(load: float, tangential: float, friction: float) -> float:
    """Used share of friction |Q|/(mu P); a ValueError above 1."""
    used = abs(tangential) / (friction * load)
    if used > 1:
        raise ValueError(f"tangential load {tangential} beyond friction {friction * load}")
    return used


def _ellipse(x: Array, half: float) -> Array:
    """Half of the unit ellipse, sqrt(1 - x^2/a^2); 0 outside."""
    return np.sqrt(np.maximum(1 - (x / half) ** 2, 0.0))
