"""From what a scene says about the ground to its acceleration."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from solver.excitation.pulses import Rectangular, Ricker, Sine
from solver.scene import Scene
from solver.specs import (
    HalfSineSpec,
    MotionSpec,
    OneSineSpec,
    RectangularSpec,
    RickerSpec,
    SineSpec,
    StillSpec,
    TableSpec,
)

STANDARD_GRAVITY = 9.81
"""What "g" means in amplitudes and tables, m/s^2, whatever the gravity of the scene is."""

UNITS = {"g": STANDARD_GRAVITY, "m/s2": 1.0, "cm/s2": 0.01}

RICKER_PERIODS = 3.0
"""Duration of a Ricker wavelet in periods 1/f: at its ends it is 1e-8 of what it is at its peak."""

GroundMotion = Callable[[float], NDArray[np.float64]]
"""Acceleration of the ground, m/s^2, along x and y (3-D: x, y and z), at a time in s."""


class BaseMotion(Protocol):
    """A motion of the ground in one direction; positive accelerations point towards +x."""

    @property
    def peak(self) -> float:
        """Largest |a_g|, m/s^2."""

    def acceleration(self, time: float) -> float:
        """Acceleration of the ground a_g, m/s^2."""


def base_motion(spec: MotionSpec | None, end: float) -> BaseMotion | None:
    """The horizontal motion of the ground in a run up to time `end` (s); None: it does not move.

    A motion in another direction, `spec.vertical` or `spec.second`, is read by the same function.
    """
    if spec is None or isinstance(spec, StillSpec):
        return None
    if isinstance(spec, TableSpec):
        from solver.excitation.table import read_table

        return read_table(spec.file, UNITS[spec.units] * spec.scale)
    return _pulse(spec, end)


def ground_motion(scene: Scene) -> GroundMotion | None:
    """The motion of the ground in all directions together; None when it does not move."""
    spec, end = scene.motion, scene.time.end
    if spec is None:
        return None
    second = [base_motion(spec.second, end)] if scene.dimension == 3 else []
    parts = [base_motion(spec, end), *second, base_motion(spec.vertical, end)]
    moving = [(axis, part.acceleration) for axis, part in enumerate(parts) if part is not None]
    if not moving:
        return None

    def acceleration(time: float) -> NDArray[np.float64]:
        value = np.zeros(len(parts))
        for axis, along in moving:
            value[axis] = along(time)
        return value

    return acceleration


def _pulse(
    spec: SineSpec | HalfSineSpec | OneSineSpec | RectangularSpec | RickerSpec, end: float
) -> Sine | Rectangular | Ricker:
    """The motion that a formula gives."""
    start, amplitude = spec.start, spec.amplitude_g * STANDARD_GRAVITY
    if isinstance(spec, SineSpec):
        # A hair beyond the end, lest the rounding of the last step's time switch the motion off.
        stop = end * (1 + 1e-9) if spec.cycles is None else start + spec.cycles * spec.period
        return Sine(amplitude=amplitude, start=start, stop=stop, period=spec.period)
    if isinstance(spec, RickerSpec):
        frequency = spec.frequency or RICKER_PERIODS / (spec.duration or np.nan)
        stop = start + RICKER_PERIODS / frequency
        return Ricker(amplitude=amplitude, start=start, stop=stop, frequency=frequency)
    stop = start + spec.duration
    if isinstance(spec, RectangularSpec):
        return Rectangular(amplitude=amplitude, start=start, stop=stop)
    period = spec.duration * (2 if isinstance(spec, HalfSineSpec) else 1)
    return Sine(amplitude=amplitude, start=start, stop=stop, period=period)
