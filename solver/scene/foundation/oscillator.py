"""A rigid platform on a spring: kind = "oscillator"."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from solver.scene.checking import Checked, exactly_one
from solver.scene.foundation.base import Foundation, Lines, Platform
from solver.scene.ranges import Dimension, NotNegative, Positive


@dataclass(frozen=True, slots=True, kw_only=True)
class OscillatorSpec(Foundation):
    """A rigid platform on a horizontal spring: kind = "oscillator"."""

    kind: Literal["oscillator"] = "oscillator"
    """A rigid platform on a spring."""
    mass: Positive | None = None
    """Mass of the empty platform, kg. Default: this or `mass_ratio`."""
    mass_ratio: Positive | None = None
    """Mass of all blocks over that of the platform. Default: this or `mass`."""
    period: Positive | None = None
    """T of the empty platform, s. Default: this or `stiffness`."""
    stiffness: Positive | None = None
    """k of the spring, N/m. Default: this or `period`."""
    damping_ratio: NotNegative = 0.0
    """xi of the empty platform."""

    def __post_init__(self) -> None:
        """Check the values."""
        Checked.__post_init__(self)
        exactly_one(self, "mass", "mass_ratio")
        exactly_one(self, "period", "stiffness")

    @property
    def on_spring(self) -> bool:
        """An oscillator always is."""
        return True

    @property
    def depth(self) -> float | None:
        """A scene gives a platform no size: None."""
        return None

    def platform(self, carried: float) -> Platform:
        """The platform that carries blocks of mass `carried`, kg, in all."""
        return Platform.on_spring(
            self.mass or carried / (self.mass_ratio or math.nan),
            period=self.period,
            stiffness=self.stiffness,
            damping_ratio=self.damping_ratio,
        )

    def describe(self, dimension: Dimension, carried: float) -> Lines:
        """What `rockslip check` says of it."""
        return [("foundation", "rigid platform on a spring")]
