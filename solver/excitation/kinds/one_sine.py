"""One period of a sine: kind = "one_sine"."""

from __future__ import annotations

from solver.excitation.pulses import Sine
from solver.scene.motion import G_UNIT, OneSineSpec


def signal(spec: OneSineSpec, end: float, where: str) -> Sine:
    """One period that lasts as long as the spec says."""
    return Sine(
        amplitude=spec.amplitude_g * G_UNIT,
        start=spec.start,
        stop=spec.start + spec.duration,
        period=spec.duration,
    )
