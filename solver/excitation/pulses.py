"""Ground motions given by a formula, with their velocity in closed form.

Each lasts from `start` to `stop`, before which the ground is at rest and after which it keeps the
velocity that it has; a positive amplitude first pushes the ground towards +x.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np

from solver.types import Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Pulse(ABC):
    """Base of the pulses; the formulas take the time since the start, tau, s."""

    amplitude: float
    """A, m/s^2."""
    start: float
    """s."""
    stop: float
    """s, > start."""

    @property
    def peak(self) -> float:
        """Largest |a_g|, m/s^2."""
        return abs(self.amplitude)

    @property
    def duration(self) -> float:
        """From start to stop, s; 0 if it is over before it begins."""
        return max(self.stop - self.start, 0.0)

    @property
    def peak_velocity(self) -> float:
        """Largest |v_g|, m/s: where the acceleration changes its sign, or in the end."""
        times = [tau for tau in self._reversals if 0 < tau < self.duration]
        return max(abs(float(self._v(tau))) for tau in (*times, self.duration))

    @property
    def end_velocity(self) -> float:
        """v_g once it is over, m/s; what is round-off beside the largest counts as 0."""
        end = float(self._v(self.duration))
        return end if abs(end) > 1e-6 * self.peak_velocity else 0.0

    def acceleration(self, time: Array | float) -> Any:
        """Acceleration of the ground a_g at one or many times, m/s^2."""
        return self._a(time - self.start) * ((self.start <= time) & (time <= self.stop))

    def velocity(self, time: Array | float) -> Any:
        """Velocity of the ground at one or many times, m/s."""
        return self._v(np.clip(time - self.start, 0.0, self.duration))

    @property
    @abstractmethod
    def _reversals(self) -> tuple[float, ...]:
        """Times at which the acceleration changes its sign, s; of periodic ones the first."""

    @abstractmethod
    def _a(self, tau: Any) -> Any: ...

    @abstractmethod
    def _v(self, tau: Any) -> Any: ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Sine(Pulse):
    """a_g = A sin(w tau), w = 2 pi / T: one period, half of one, or many."""

    period: float
    """T, s."""

    @property
    def peak(self) -> float:
        """Largest |a_g|, m/s^2."""
        return abs(float(self._a(min(self.duration, self.period / 4))))

    @property
    def _reversals(self) -> tuple[float, ...]:
        return (self.period / 2,)

    def _a(self, tau: Any) -> Any:
        return self.amplitude * np.sin(2 * math.pi / self.period * tau)

    def _v(self, tau: Any) -> Any:
        w = 2 * math.pi / self.period
        return self.amplitude / w * (1 - np.cos(w * tau))


@dataclass(frozen=True, slots=True, kw_only=True)
class Rectangular(Pulse):
    """a_g = A."""

    @property
    def _reversals(self) -> tuple[float, ...]:
        return ()

    def _a(self, tau: Any) -> Any:
        return self.amplitude

    def _v(self, tau: Any) -> Any:
        return self.amplitude * tau


@dataclass(frozen=True, slots=True, kw_only=True)
class Ricker(Pulse):
    """a_g = A (1 - 2 b s^2) exp(-b s^2), b = (pi f)^2, s = time from the middle (Ricker 1943).

    A is the acceleration in the middle; before and after it the ground is pushed the other way,
    by at most 2 exp(-3/2) A = 0.446 A. The spectrum is highest at f.
    """

    frequency: float
    """f, 1/s."""

    @property
    def _reversals(self) -> tuple[float, ...]:
        apart = 1 / (math.sqrt(2) * math.pi * self.frequency)
        return tuple(self.duration / 2 + s for s in (-apart, apart))

    def _decay(self, tau: Any) -> tuple[float, Any, Any]:
        """b, s and exp(-b s^2)."""
        b, s = (math.pi * self.frequency) ** 2, tau - self.duration / 2
        return b, s, np.exp(-b * s**2)

    def _a(self, tau: Any) -> Any:
        b, s, decay = self._decay(tau)
        return self.amplitude * (1 - 2 * b * s**2) * decay

    def _v(self, tau: Any) -> Any:
        _, s, decay = self._decay(tau)
        _, first, small = self._decay(0.0)
        return self.amplitude * (s * decay - first * small)
