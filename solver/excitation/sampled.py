"""Ground motions given by samples of the acceleration."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.polynomial import legendre

from solver.types import Array

Baseline = Literal["none", "constant", "linear", "quadratic"]

DEGREES: dict[Baseline, int] = {"constant": 0, "linear": 1, "quadratic": 2}
"""Degrees of the polynomials of time that are taken off."""

MOST_SAMPLES = 10**6
"""Largest number of samples after resampling."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SampledMotion:
    """Samples of the ground's acceleration, linear between them and zero before and after them."""

    time: Array
    """t_i, s, increasing, (n,) with n >= 2."""
    value: Array
    """a_i, m/s^2, (n,)."""
    step: float | None = None
    """Time between samples where it is the same for all, s."""
    largest: str = ""
    """Place of the largest sample, in words."""
    source: str = ""
    """The source in a file, in words; empty: the samples are of no file."""
    _speed: Array = field(init=False, repr=False)
    """Velocities at the samples, m/s, (n,): the integral of the broken line."""

    def __post_init__(self) -> None:
        """Integrate."""
        object.__setattr__(self, "_speed", running_integral(self.time, self.value))

    @property
    def peak(self) -> float:
        """Largest |a_g|, m/s^2."""
        return float(np.abs(self.value).max())

    @property
    def stop(self) -> float:
        """Time of the last sample, s."""
        return float(self.time[-1])

    @property
    def duration(self) -> float:
        """From the first to the last sample, s."""
        return float(self.time[-1] - self.time[0])

    def acceleration(self, time: Array | float) -> Any:
        """Acceleration of the ground a_g at one or many times, m/s^2."""
        return np.interp(time, self.time, self.value, left=0.0, right=0.0)

    def velocity(self, time: Array | float) -> Any:
        """Velocity of the ground at one or many times, m/s: exact, from rest."""
        first = np.clip(np.searchsorted(self.time, time, side="right") - 1, 0, len(self.time) - 2)
        length = self.time[first + 1] - self.time[first]
        since = np.clip(time - self.time[first], 0.0, length)
        slope = (self.value[first + 1] - self.value[first]) / length
        return self._speed[first] + since * (self.value[first] + since * slope / 2)

    @property
    def peak_velocity(self) -> float:
        """Largest |v_g|, m/s: at a sample, or where the acceleration passes zero between two."""
        a, b, speed = self.value[:-1], self.value[1:], self._speed
        turns = a * b < 0
        since = np.diff(self.time)[turns] * (a / np.where(turns, a - b, 1.0))[turns]
        between = speed[:-1][turns] + since * a[turns] / 2
        return float(np.abs(np.concatenate([speed, between])).max())

    def evenly_spaced(self, longest: float) -> tuple[Array, float]:
        """Samples at equal times, at most `longest` (s) apart, and the time between them, s.

        The motion between its samples is theirs, too. Samples that are equally far apart, and near
        enough, are left as they are, and are among them where others are needed between. More than
        `MOST_SAMPLES` are not made: then they are farther apart.
        """
        if self.step is not None:
            parts = math.ceil(self.step / longest * (1 - 1e-9))
            if parts <= 1:
                return self.value, self.step
            count = parts * (len(self.time) - 1)
        else:
            finest = min(float(np.diff(self.time).min()), longest)
            count = math.ceil(self.duration / finest * (1 - 1e-9))
        count = max(min(count, MOST_SAMPLES), len(self.time) - 1)
        times = np.linspace(self.time[0], self.time[-1], count + 1)
        return self.acceleration(times), self.duration / count


def running_integral(time: Array, values: Array) -> Array:
    """Integrals of what is linear between times (s), from the first one up to each of them."""
    parts = np.diff(time) * (values[1:] + values[:-1]) / 2
    return np.concatenate([[0.0], np.cumsum(parts)])


def even_step(time: Array) -> float | None:
    """The time between samples, s, where it is the same for all of them and positive."""
    step = float(time[-1] - time[0]) / (len(time) - 1)
    even = step > 0 and np.all(np.abs(np.diff(time) - step) <= 1e-6 * step)
    return step if even else None


def without_baseline(acceleration: Array, baseline: Baseline) -> Array:
    """Samples less the polynomial of time that makes the sum of their squared velocities least.

    After Berg and Housner (1961), who took off a parabola. The velocities are those of ground that
    is at rest at the first sample and whose acceleration (n >= 2 samples at equal distances) is
    linear between samples; at the last sample they become small, not exactly zero.
    "none" leaves the samples as they are.
    """
    if baseline == "none":
        return acceleration
    # No more coefficients than velocities that can be changed.
    degree = min(DEGREES[baseline], len(acceleration) - 2)
    powers = legendre.legvander(np.linspace(-1, 1, len(acceleration)), degree)
    unwanted, *_ = np.linalg.lstsq(_velocities(powers), _velocities(acceleration), rcond=None)
    return np.asarray(acceleration - powers @ unwanted)


def _velocities(acceleration: Array) -> Array:
    """Integrals from the first sample to each of the others, over the time between samples."""
    return np.asarray(np.cumsum((acceleration[1:] + acceleration[:-1]) / 2, axis=0))
