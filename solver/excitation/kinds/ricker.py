"""A Ricker wavelet: kind = "ricker"."""

from __future__ import annotations

import math

from solver.excitation.pulses import Ricker
from solver.scene.motion import G_UNIT, RickerSpec

RICKER_PERIODS = 3.0
"""Duration of a Ricker wavelet in periods 1/f: at its ends it is 1e-8 of what it is at its peak."""


def signal(spec: RickerSpec, end: float, where: str) -> Ricker:
    """The wavelet of a frequency, or of the frequency that a duration stands for."""
    frequency = spec.frequency or RICKER_PERIODS / (spec.duration or math.nan)
    return Ricker(
        amplitude=spec.amplitude_g * G_UNIT,
        start=spec.start,
        stop=spec.start + RICKER_PERIODS / frequency,
        frequency=frequency,
    )
