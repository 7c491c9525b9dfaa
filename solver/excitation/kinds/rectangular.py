"""A constant acceleration for a while: kind = "rectangular"."""

from __future__ import annotations

from solver.excitation.pulses import Rectangular
from solver.scene.motion import G_UNIT, RectangularSpec


def signal(spec: RectangularSpec, end: float, where: str) -> Rectangular:
    """The acceleration from the start, for the duration."""
    stop = spec.start + spec.duration
    return Rectangular(amplitude=spec.amplitude_g * G_UNIT, start=spec.start, stop=stop)
