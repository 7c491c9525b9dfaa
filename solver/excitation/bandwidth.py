"""How fast a motion of the ground is: the frequencies that hold almost all of its power."""

from __future__ import annotations

import math

import numpy as np

from solver.excitation.motion import GroundMotion
from solver.types import Array

POWER = 0.999
"""Part of the integral of the squared acceleration that counts."""

FADED = 0.1
"""Part of the run over which a motion fades out that goes on after it."""

SAMPLES = 2000.0
"""Samples in a second."""

MOST_SAMPLES = 200_000
"""Samples at most."""


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
    accelerations = ground.accelerations(times)
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
