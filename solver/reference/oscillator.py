"""The damped linear oscillator under a load that is linear in time."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class LinearOscillator:
    """u'' + 2 d u' + w2 u = load, in closed form for loads that are linear in time."""

    w2: float
    """Stiffness over mass, 1/s^2."""
    d: float
    """Half of the damping over mass, 1/s."""

    def after(
        self, drift: float, velocity: float, load: float, slope: float, tau: float
    ) -> tuple[float, float]:
        """Drift (m) and velocity (m/s) after a time tau (s).

        Args:
            drift: At the start, m.
            velocity: At the start, m/s.
            load: At the start, over the mass, m/s^2.
            slope: Of the load, m/s^3.
            tau: s.
        """
        w2, d = self.w2, self.d
        steady = slope / w2
        level = (load - 2 * d * steady) / w2
        u, v = drift - level, velocity - steady
        root, fade = w2 - d * d, math.exp(-d * tau)
        if root > 0:
            turn = math.sqrt(root)
            c, s = math.cos(turn * tau), math.sin(turn * tau) / turn
        elif root < 0:
            turn = math.sqrt(-root)
            c, s = math.cosh(turn * tau), math.sinh(turn * tau) / turn
        else:
            c, s = 1.0, tau
        moved = fade * (u * (c + d * s) + v * s)
        return level + steady * tau + moved, steady + fade * (v * (c - d * s) - w2 * u * s)
