"""Ground motions given by a formula."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Sine:
    """a_g(t) = A sin(2 pi (t - start) / T) from `start` to `stop`, and zero outside."""

    amplitude: float
    """A, m/s^2."""
    period: float
    """T, s."""
    start: float
    """s."""
    stop: float
    """s."""

    @property
    def peak(self) -> float:
        """Largest |a_g|, m/s^2."""
        quarter = min(max(self.stop - self.start, 0.0), self.period / 4)
        return abs(self.amplitude) * math.sin(2 * math.pi * quarter / self.period)

    def acceleration(self, time: float) -> float:
        """Acceleration of the ground, m/s^2."""
        if not self.start <= time <= self.stop:
            return 0.0
        return self.amplitude * math.sin(2 * math.pi * (time - self.start) / self.period)
