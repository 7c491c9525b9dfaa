"""A sine: kind = "sine"."""

from __future__ import annotations

from solver.excitation.pulses import Sine
from solver.scene.motion import G_UNIT, SineSpec

BEYOND_THE_END = 1e-9
"""Part of the time of a run by which a sine without an end goes on, lest the rounding of the last
step's time switch the motion off."""


def signal(spec: SineSpec, end: float, where: str) -> Sine:
    """So many periods of a sine, or one that lasts up to the end of the run, `end` (s)."""
    stop = end * (1 + BEYOND_THE_END)
    if spec.cycles is not None:
        stop = spec.start + spec.cycles * spec.period
    return Sine(
        amplitude=spec.amplitude_g * G_UNIT, start=spec.start, stop=stop, period=spec.period
    )
