"""Rayleigh damping: the table `[damping]`, and that of a body."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from solver.errors import SceneError
from solver.scene.checking import OPEN, Checked, is_open
from solver.scene.ranges import NotNegative

DEFAULT_RATIO = 0.02
"""Ratio of critical damping at the first bending mode of a standing elastic block, by default."""

CANTILEVER = 3.516
"""omega H^2 over c sqrt(I/A) in the first bending mode of a cantilever (Euler and Bernoulli)."""


def bending_frequency(width: float, height: float, wave_speed: float) -> float:
    """Natural frequency (rad/s) of a standing block held at its base, in its first bending mode.

    That of a slender cantilever. Shear, which it leaves out, lowers the frequency of a block in
    plane stress: by 1 % where H/B is 8, by 4 % where it is 4, by 14 % where it is 2.

    Args:
        width: In the plane of bending, m.
        height: H, m.
        wave_speed: c = sqrt(E/rho), m/s.
    """
    return CANTILEVER / math.sqrt(12) * (width / height) * (wave_speed / height)


@dataclass(frozen=True, slots=True, kw_only=True)
class DampingSpec(Checked):
    """Rayleigh damping: `[damping]`, or `damping` of a body."""

    mass: NotNegative = 0.0
    """lambda_R, 1/s."""
    stiffness: NotNegative = OPEN
    """beta_R, s. Default: `0.0`; where `mass` is above 0, [that of elastic
    blocks](#default-damping)."""

    def __post_init__(self) -> None:
        """Check the values; beta_R stays open where lambda_R alone is given."""
        Checked.__post_init__(self)
        if is_open(self.stiffness) and not self.mass:
            object.__setattr__(self, "stiffness", 0.0)

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


def stiffness_damping(ratio: float, frequency: float) -> DampingSpec:
    """Stiffness-proportional damping that gives a ratio xi at a natural frequency, rad/s.

    beta_R = 2 xi/omega; infinite at a frequency of zero.
    """
    return DampingSpec(stiffness=2 * ratio / frequency if frequency else math.inf)
