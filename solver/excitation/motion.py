"""From what a scene says about the ground to its acceleration."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from solver.excitation.pulses import Rectangular, Ricker, Sine
from solver.scene import (
    HalfSineSpec,
    MotionSpec,
    OneSineSpec,
    RecordSpec,
    RectangularSpec,
    RickerSpec,
    Scene,
    SineSpec,
    StillSpec,
    SyntheticSpec,
    TableSpec,
)
from solver.scene.units import STANDARD_GRAVITY, UNITS
from solver.types import Array

RICKER_PERIODS = 3.0
"""Duration of a Ricker wavelet in periods 1/f: at its ends it is 1e-8 of what it is at its peak."""


class BaseMotion(Protocol):
    """A motion of the ground in one direction; positive accelerations point towards +x.

    The velocity is the exact integral of the acceleration: its change over a step is the impulse of
    the step whatever its length.
    """

    @property
    def peak(self) -> float:
        """Largest |a_g|, m/s^2."""

    @property
    def stop(self) -> float:
        """When the acceleration is over, s."""

    def acceleration(self, time: float) -> float:
        """Acceleration of the ground a_g, m/s^2."""

    def velocity(self, time: float) -> float:
        """Velocity of the ground, m/s."""

    def accelerations(self, times: Array) -> Array:
        """Accelerations of the ground at many times, m/s^2."""

    def velocities(self, times: Array) -> Array:
        """Velocities of the ground at many times, m/s."""


def base_motion(spec: MotionSpec | None, end: float, where: str = "motion") -> BaseMotion | None:
    """The horizontal motion of the ground in a run up to time `end` (s); None: it does not move.

    A motion in another direction, `spec.vertical` or `spec.second`, is read by the same function.

    Args:
        spec: What the scene says.
        end: s.
        where: Path of the table in the scene, for errors.
    """
    if spec is None or isinstance(spec, StillSpec):
        return None
    if isinstance(spec, TableSpec):
        from solver.excitation.table import read_table

        return read_table(spec.file, UNITS[spec.units] * spec.scale, where)
    if isinstance(spec, RecordSpec):
        from solver.excitation.records import read_record

        return read_record(spec, where)
    if isinstance(spec, SyntheticSpec):
        from solver.excitation.synthetic.suite_motion import synthetic_motion

        return synthetic_motion(spec)
    return _pulse(spec, end)


@dataclass(frozen=True, slots=True)
class GroundMotion:
    """The motion of the ground in all directions together."""

    parts: tuple[BaseMotion | None, ...]
    """Along x and y (3-D: x, y and z); None: no motion in this direction."""

    def acceleration(self, time: float) -> Array:
        """Acceleration of the ground, m/s^2, (d,)."""
        return np.array([part.acceleration(time) if part else 0.0 for part in self.parts])

    def mean(self, time: float, dt: float) -> Array:
        """Mean acceleration from a time on, m/s^2, (d,): what the velocity gains, over dt."""
        ends = (time, time + dt)
        speeds = [[p.velocity(t) if p else 0.0 for t in ends] for p in self.parts]
        return np.array([(after - before) / dt for before, after in speeds])

    def accelerations(self, times: Array) -> Array:
        """Accelerations of the ground at many times, m/s^2, (n, d)."""
        still = np.zeros_like(times)
        return np.stack([p.accelerations(times) if p else still for p in self.parts], axis=-1)

    def velocities(self, times: Array) -> Array:
        """Velocities of the ground at many times, m/s, (n, d)."""
        still = np.zeros_like(times)
        return np.stack([p.velocities(times) if p else still for p in self.parts], axis=-1)


def ground_motion(scene: Scene) -> GroundMotion | None:
    """The motion of the ground in all directions together; None when it does not move."""
    spec, end = scene.motion, scene.time.end
    if spec is None:
        return None
    second = [base_motion(spec.second, end, "motion.second")] if scene.dimension == 3 else []
    along, up = base_motion(spec, end), base_motion(spec.vertical, end, "motion.vertical")
    motion = GroundMotion((along, *second, up))
    return motion if any(motion.parts) else None


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
