"""Rayleigh damping: the table `[damping]`, and that of a body."""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from solver.errors import SceneError
from solver.scene.checking import OPEN, Checked, is_open
from solver.scene.material import Material, Plane
from solver.scene.quantities import Delay, Rate

DEFAULT_RATIO = 0.02
"""Ratio of critical damping at the first bending mode of a standing elastic block, by default."""

SLIDING_RATIO = 0.22
"""Ratio of critical damping at the sway of a squat block, over its coefficient of friction, above
which its steady sliding does not flutter.

The largest of a linearisation for H/B 0.1 to 1.2, Poisson's ratio 0 to 0.45 and friction 0.2 to 1
(docs/damping.md). From H/B 0.6 blocks need less, and from 1.6 none.
"""

NEEDS_NONE = 1.6
"""H/B from which steady sliding needs no damping."""

CANTILEVER = 3.51602
"""omega H^2 over c sqrt(I/A) in the first bending mode of a cantilever (Euler and Bernoulli)."""

BISECTIONS = 60
"""Halvings of an interval that bring a root to round-off."""


def restraint(plane: Plane, across: float, height: float) -> float:
    """Part of the strain across its plane of bending that a held block is kept from, 0 to 1.

    0 in plane stress, 1 in plane strain. In space the base restrains it, over about half of what
    the block measures across: the frequency of the finite elements is met within 2 % so.
    """
    if plane == "solid":
        return across / (across + height / 2)
    return 1.0 if plane == "strain" else 0.0


def cantilever_frequency(width: float, height: float, material: Material, held: float) -> float:
    """Natural frequency (rad/s) of a standing block held at its base, in its first bending mode.

    That of Timoshenko's beam: the least root of the characteristic equation of a cantilever, with
    shear and rotatory inertia (Huang 1961, J. Appl. Mech. 28), and the coefficient of shear of a
    rectangle that Kaneko recommends (1975, J. Phys. D 8). The finite elements are met within 2 %
    for H/B 0.25 to 10.

    Args:
        width: B, in the plane of bending, m.
        height: H, m.
        material: E, nu and rho.
        held: Restraint across that plane, 0 for plane stress to 1 for plane strain.
    """
    poisson = material.poisson / (1 - held * material.poisson)
    young = material.young / (1 - held * material.poisson**2)
    shear = 5 * (1 + poisson) / (6 + 5 * poisson) * material.shear
    r = width / height / math.sqrt(12)
    s = r * math.sqrt(young / shear)

    def equation(b: float) -> float:
        """Left side of the characteristic equation at b = omega H sqrt(rho/E)/r."""
        root = cmath.sqrt((r * r - s * s) ** 2 + 4 / b**2)
        alpha, beta = (b * cmath.sqrt((root + sign * (r * r + s * s)) / 2) for sign in (-1, 1))
        even = ((b * (r * r - s * s)) ** 2 + 2) * cmath.cosh(alpha) * cmath.cos(beta)
        odd = b * (r * r + s * s) / cmath.sqrt(1 - (b * r * s) ** 2)
        return (2 + even - odd * cmath.sinh(alpha) * cmath.sin(beta)).real

    # Bending alone and shear alone are stiffer than both together.
    low, high = 0.0, min(CANTILEVER, math.pi / (2 * s))
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        low, high = (middle, high) if equation(middle) > 0 else (low, middle)
    return high * r * math.sqrt(young / material.density) / height


@dataclass(frozen=True, slots=True, kw_only=True)
class DampingSpec(Checked):
    """Rayleigh damping: `[damping]`, or `damping` of a body."""

    mass: Rate = 0.0
    """lambda_R, 1/s."""
    stiffness: Delay = OPEN
    """beta_R, s. Default: `0.0`; where `mass` is above 0, [that of elastic
    blocks](#default-damping)."""

    def resolved(self) -> Iterator[tuple[str, Any]]:
        """beta_R, which stays open where lambda_R alone is given."""
        if is_open(self.stiffness) and not self.mass:
            yield "stiffness", 0.0

    def closed(self, stiffness: float) -> DampingSpec:
        """The damping with this beta_R, s, where that is open."""
        return replace(self, stiffness=stiffness) if is_open(self.stiffness) else self

    def ratio(self, frequency: float) -> float:
        """Ratio of critical damping of a mode by its natural frequency, rad/s."""
        return (self.mass / frequency + self.stiffness * frequency) / 2

    def left(self, frequency: float, time: float) -> float:
        """The share of a mode of a natural frequency, rad/s, that is left of it after a time, s."""
        return math.exp(-self.ratio(frequency) * frequency * time)


def refuse_both_dampings(ratio: float | None, damping: DampingSpec | None) -> None:
    """Refuse a body whose damping is given twice, by a ratio and by a table of its own.

    Raises:
        SceneError: It is.
    """
    if ratio is not None and damping is not None:
        raise SceneError("damping_ratio", "both damping_ratio and damping", "one of the two")


def sliding_ratio(friction: float, slenderness: float) -> float:
    """Ratio of critical damping at its sway with which a block of a H/B slides without flutter."""
    return SLIDING_RATIO * friction * min(1.0, max(0.0, NEEDS_NONE - slenderness))


def stiffness_damping(ratio: float, frequency: float) -> DampingSpec:
    """Stiffness-proportional damping that gives a ratio xi at a natural frequency, rad/s.

    beta_R = 2 xi/omega; infinite at a frequency of zero.
    """
    return DampingSpec(stiffness=2 * ratio / frequency if frequency else math.inf)
