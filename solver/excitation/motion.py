"""From what a scene says about the ground to its acceleration."""

from __future__ import annotations

from typing import Protocol

from solver.excitation.pulses import Sine
from solver.specs import MotionSpec, SineSpec

STANDARD_GRAVITY = 9.81
"""What "g" means in amplitudes and tables, m/s^2, whatever the gravity of the scene is."""

UNITS = {"g": STANDARD_GRAVITY, "m/s2": 1.0, "cm/s2": 0.01}


class BaseMotion(Protocol):
    """A horizontal motion of the ground; positive accelerations point towards +x."""

    @property
    def peak(self) -> float:
        """Largest |a_g|, m/s^2."""

    def acceleration(self, time: float) -> float:
        """Acceleration of the ground a_g, m/s^2."""


def base_motion(spec: MotionSpec | None, end: float) -> BaseMotion | None:
    """The motion of the ground in a run up to time `end` (s); None when it does not move."""
    if spec is None:
        return None
    if isinstance(spec, SineSpec):
        # A hair beyond the end, lest the rounding of the last step's time switch the motion off.
        last = end * (1 + 1e-9) if spec.cycles is None else spec.start + spec.cycles * spec.period
        amplitude = spec.amplitude_g * STANDARD_GRAVITY
        return Sine(amplitude=amplitude, period=spec.period, start=spec.start, stop=last)
    from solver.excitation.table import read_table

    return read_table(spec.file, UNITS[spec.units] * spec.scale)
