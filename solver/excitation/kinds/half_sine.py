"""Half a period of a sine: kind = "half_sine"."""

from __future__ import annotations

from solver.excitation.pulses import Sine
from solver.scene.motion import G_UNIT, HalfSineSpec


def signal(spec: HalfSineSpec, end: float, where: str) -> Sine:
    """Half a period that lasts as long as the spec says."""
    return Sine(
        amplitude=spec.amplitude_g * G_UNIT,
        start=spec.start,
        stop=spec.start + spec.duration,
        period=2 * spec.duration,
    )
