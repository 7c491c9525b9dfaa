"""Measures of ground motions: spectra, peaks, intensity, duration, highest frequency.

Most are of equally spaced samples, linear between them, zero outside:

`acceleration` stands for the samples a_i, m/s^2, (m,); `step` for the time between them, s.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from solver.excitation.motion import GroundMotion
from solver.scene.motion import G_UNIT
from solver.types import Array

Samples = NDArray[np.float64]

PERIODS: Samples = 0.02 * 250.0 ** np.linspace(0.0, 1.0, 160)
"""Periods of the spectra that are drawn, s."""

DAMPING = 0.05
"""Damping of oscillators, over critical, where none is given."""

POWER = 0.999
"""Part of the integral of the squared acceleration that counts."""

FADED = 0.1
"""Part of the run over which a motion fades out that goes on after it."""

SAMPLES = 2000.0
"""Samples in a second."""

MOST_SAMPLES = 200_000
"""Samples at most."""

SAMPLES_A_PERIOD = 40
"""So many samples of the ground at least in the shortest period of a spectrum: the largest response
at samples is then below that between them by less than 0.4 %."""


def longest_spacing(periods: ArrayLike) -> float:
    """The longest time between samples of the ground for a spectrum at some periods, s."""
    return float(np.min(periods)) / SAMPLES_A_PERIOD


def response_spectrum(
    acceleration: Samples, step: float, periods: ArrayLike, damping: float = DAMPING
) -> Samples:
    """Pseudo-spectral acceleration PSA = (2 pi/T)^2 max |u|, m/s^2, one for each period T > 0, s.

    u'' + 2 xi w u' + w^2 u = -a(t), from rest and on through half a period after the last sample;
    a_i in m/s^2, 0 <= xi < 1 of critical. The recursion from sample to sample is exact (Nigam and
    Jennings 1969). The maximum is that of the samples, as in published spectra: below that between
    them by at most (pi step/T)^2/2.
    """
    samples = np.asarray(acceleration, dtype=float)
    wanted = np.atleast_1d(np.asarray(periods, dtype=float))
    return np.array([_largest(samples, step, 2 * math.pi / T, damping) for T in wanted])


def _largest(acceleration: Samples, step: float, frequency: float, damping: float) -> float:
    """w^2 max |u| of the oscillator of angular frequency w, 1/s."""
    from scipy.signal import lfilter

    forward, before, after = _advance(step, frequency, damping)
    # The displacement's own recursion, from x_n+1 = F x_n + b a_n + c a_n+1 by Cayley-Hamilton.
    rest = forward - np.trace(forward) * np.eye(2)
    numerator = [after[0], before[0] + rest[0] @ after, rest[0] @ before]
    denominator = [1.0, -np.trace(forward), np.linalg.det(forward)]
    free = np.zeros(math.ceil(math.pi / frequency / step) + 1)
    start = acceleration[0] * np.array([before[0], rest[0] @ before])
    later = np.concatenate((acceleration[1:], free))
    moved, _ = lfilter(numerator, denominator, later, zi=start)
    return frequency**2 * float(np.abs(moved).max())


def _advance(step: float, frequency: float, damping: float) -> tuple[Samples, Samples, Samples]:
    """F (2, 2), b (2,), c (2,) of (u, u')_n+1 = F (u, u')_n + b a_n + c a_n+1, exactly."""
    turning = frequency * math.sqrt(1 - damping**2)
    fading = damping * frequency
    decay = math.exp(-fading * step)
    sine, cosine = decay * math.sin(turning * step) / turning, decay * math.cos(turning * step)
    forward = np.array(
        [[cosine + fading * sine, sine], [-(frequency**2) * sine, cosine - fading * sine]]
    )
    # Under a = p + q t the particular solution is -(p + q t)/w^2 + 2 xi q/w^3.
    constant = np.array([-1 / frequency**2, 0.0])
    ramp_start = np.array([2 * damping / frequency**3, -1 / frequency**2])
    ramp_end = ramp_start + step * constant
    of_constant = constant - forward @ constant
    of_ramp = (ramp_end - forward @ ramp_start) / step
    return forward, of_constant - of_ramp, of_ramp


def velocity_and_displacement(acceleration: Samples, step: float) -> tuple[Samples, Samples]:
    """Velocity and displacement of the ground at the samples, m/s and m; exact from rest."""
    a = np.asarray(acceleration, dtype=float)
    velocity = np.concatenate(([0.0], np.cumsum(a[1:] + a[:-1]) * (step / 2)))
    moved = velocity[:-1] * step + (2 * a[:-1] + a[1:]) * (step**2 / 6)
    return velocity, np.concatenate(([0.0], np.cumsum(moved)))


def peak_ground(acceleration: Samples, step: float) -> tuple[float, float, float]:
    """PGA, m/s^2, PGV, m/s, and PGD, m: the largest sizes at the samples."""
    moved = velocity_and_displacement(acceleration, step)
    largest = [float(np.abs(values).max()) for values in (acceleration, *moved)]
    return largest[0], largest[1], largest[2]


def arias_intensity(acceleration: Samples, step: float) -> float:
    """I_A = pi/(2 g) times the integral of a^2, m/s, with g = 9.81 m/s^2 (Arias 1970)."""
    return float(accumulated_intensity(acceleration, step)[-1])


def accumulated_intensity(acceleration: Samples, step: float) -> Samples:
    """The Arias intensity of the motion up to every sample, m/s (Husid 1969)."""
    return math.pi / (2 * G_UNIT) * _squares(acceleration, step)


def significant_duration(
    acceleration: Samples, step: float, low: float = 0.05, high: float = 0.95
) -> float:
    """D: s from the time when the share `low` of the Arias intensity has come to that of `high`.

    With the defaults D5-95 (Trifunac and Brady 1975); 0 if the ground does not move.
    """
    grown = _squares(acceleration, step)
    if grown[-1] == 0:
        return 0.0
    times = step * np.arange(grown.size)
    first, last = np.interp(np.array([low, high]) * grown[-1], grown, times)
    return float(last - first)


def _squares(acceleration: Samples, step: float) -> Samples:
    """The integral of a^2 up to every sample, m^2/s^3; exact for the broken line."""
    a = np.asarray(acceleration, dtype=float)
    pieces = (a[:-1] ** 2 + a[:-1] * a[1:] + a[1:] ** 2) * (step / 3)
    return np.concatenate(([0.0], np.cumsum(pieces)))


def highest_frequency(ground: GroundMotion, end: float) -> float:
    """Frequency below which a motion has 99.9 % of its power in each direction, rad/s; 0: none.

    Of the motion up to the end of the run (s).
    """
    stops = [part.stop for part in ground.parts if part is not None]
    if not stops:
        return 0.0
    span = min(end, max(stops))
    count = min(MOST_SAMPLES, max(64, math.ceil(span * SAMPLES)))
    step = span / (count - 1)
    times: Array = step * np.arange(count, dtype=np.float64)
    accelerations = ground.acceleration(times)
    if max(stops) > end:  # the jump to zero at the end of the run is no part of the motion
        fading = np.minimum(1.0, np.linspace(1.0, 0.0, count) / FADED)
        accelerations *= 0.5 * (1 - np.cos(math.pi * fading))[:, None]
    spectrum = np.abs(np.fft.rfft(accelerations, axis=0)) ** 2
    within = np.cumsum(spectrum, axis=0)
    frequencies = 2 * math.pi * np.fft.rfftfreq(count, step)
    fastest = [
        frequencies[min(int(np.searchsorted(power, POWER * power[-1])), len(power) - 1)]
        for power in within.T
        if power[-1] > 0
    ]
    return float(max(fastest, default=0.0))
