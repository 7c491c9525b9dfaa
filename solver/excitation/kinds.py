"""The kinds of ground motion: from the table of a scene to the motion along one direction."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np

from solver.errors import SceneError
from solver.excitation.layouts.table import read_motion
from solver.excitation.pulses import Rectangular, Ricker, Sine
from solver.excitation.sampled import SampledMotion, without_baseline
from solver.excitation.synthetic import synthetic_motion
from solver.scene.checking import shown
from solver.scene.motion import (
    G_UNIT,
    HalfSineSpec,
    MotionSpec,
    OneSineSpec,
    RecordSpec,
    RectangularSpec,
    RickerSpec,
    SineSpec,
    TableSpec,
)
from solver.types import Array

BEYOND_THE_END = 1e-9
"""Part of the time of a run by which a sine without an end goes on, lest the rounding of the last
step's time switch the motion off."""

RICKER_PERIODS = 3.0
"""Duration of a Ricker wavelet in periods 1/f: at its ends it is 1e-8 of what it is at its peak."""

SPIKE = 20.0
"""A sample more times as large as both beside it is refused unless the scene trusts the file."""


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
        """Time at which the acceleration is over, s."""

    def acceleration(self, time: Array | float) -> Any:
        """Acceleration of the ground a_g at one or many times, m/s^2."""

    def velocity(self, time: Array | float) -> Any:
        """Velocity of the ground at one or many times, m/s."""


def base_motion(spec: MotionSpec | None, end: float, where: str = "motion") -> BaseMotion | None:
    """The motion of the ground along one direction in a run up to time `end`, s; None: none.

    Errors name the path of the table in the scene, `where`.

    Raises:
        SceneError: A file cannot be read; names file and line.
    """
    return None if spec is None else KINDS[spec.kind](spec, end, where)


def _sine(spec: SineSpec, end: float, where: str) -> Sine:
    """So many periods of a sine, or one that lasts up to the end of the run, `end` (s)."""
    stop = end * (1 + BEYOND_THE_END)
    if spec.cycles is not None:
        stop = spec.start + spec.cycles * spec.period
    return Sine(
        amplitude=spec.amplitude_g * G_UNIT, start=spec.start, stop=stop, period=spec.period
    )


def _sine_pulse(spec: HalfSineSpec | OneSineSpec, periods: float) -> Sine:
    """Half a period or one of the duration of the spec."""
    return Sine(
        amplitude=spec.amplitude_g * G_UNIT,
        start=spec.start,
        stop=spec.start + spec.duration,
        period=spec.duration / periods,
    )


def _rectangular(spec: RectangularSpec, end: float, where: str) -> Rectangular:
    """The acceleration from the start, for the duration."""
    stop = spec.start + spec.duration
    return Rectangular(amplitude=spec.amplitude_g * G_UNIT, start=spec.start, stop=stop)


def _ricker(spec: RickerSpec, end: float, where: str) -> Ricker:
    """The wavelet of a frequency, or of the frequency that a duration stands for."""
    frequency = spec.frequency or RICKER_PERIODS / (spec.duration or math.nan)
    return Ricker(
        amplitude=spec.amplitude_g * G_UNIT,
        start=spec.start,
        stop=spec.start + RICKER_PERIODS / frequency,
        frequency=frequency,
    )


def read_table(spec: TableSpec, where: str = "motion") -> SampledMotion:
    """The samples at the times of a file, which need not be equally far apart.

    Raises:
        SceneError: The file cannot be read, or is no such table; names file and line.
    """
    read = read_motion(spec, where)
    # A layout may say only how far apart they are.
    even = np.asarray(np.arange(len(read.values)) * (read.step or 0.0), dtype=np.float64)
    time = even if read.time is None else read.time
    largest = f"line {read.lines[int(np.argmax(np.abs(read.values)))]} of {spec.file}"
    value = read.values * (read.unit * spec.scale)
    return SampledMotion(
        time=time, value=value, step=read.step, largest=largest, source=read.source
    )


def read_record(spec: RecordSpec, where: str = "motion") -> SampledMotion:
    """The samples of a recorded accelerogram, the first one that is used at `spec.start`.

    Raises:
        SceneError: The file cannot be read, or contradicts the scene; names file and line.
    """
    read = read_motion(spec, where)
    step = read.step
    assert step is not None  # of a record
    used = _cut(spec, where, len(read.values), step)
    values, numbers = read.values[used], read.lines[used]
    if not spec.trust:
        _refuse_spike(spec, where, values, numbers)
    values = values * (read.unit * spec.scale)
    largest = f"line {numbers[int(np.argmax(np.abs(values)))]} of {spec.file}"
    values = without_baseline(values, spec.baseline)
    time = spec.start + step * np.arange(len(values))
    return SampledMotion(time=time, value=values, step=step, largest=largest, source=read.source)


def _refuse_spike(spec: RecordSpec, where: str, values: Array, lines: list[int]) -> None:
    """Refuse a sample that stands alone: a decimal point that was lost, as a rule."""
    size = np.abs(values)
    beside = np.maximum(size[2:], size[:-2])
    # In what is weak anyway samples may well be many times their neighbours.
    alone = (size[1:-1] > SPIKE * beside) & (size[1:-1] > 0.5 * size.max())
    if alone.any():
        at = 1 + int(np.argmax(alone))
        raise SceneError(
            f"{spec.file}: line {lines[at]}",
            f"{values[at]:g} between samples of at most {beside[at - 1]:g}",
            f"at most {SPIKE:g} times those beside it, or {where}.trust = true",
        )


def _cut(spec: RecordSpec, where: str, count: int, step: float) -> slice:
    """The samples inside the window, of so many."""
    if spec.window is None:
        return slice(count)
    begin, end = spec.window
    length = step * (count - 1)
    first, last = math.ceil(begin / step - 1e-6), math.floor(end / step + 1e-6)
    if last >= count:
        allowed = f"times up to {length:.6g} s, the length of {spec.file}"
        raise SceneError(f"{where}.window", shown(spec.window), allowed)
    if last - first < 1:
        allowed = f"two samples or more, which are {step:g} s apart"
        raise SceneError(f"{where}.window", shown(spec.window), allowed)
    return slice(first, last + 1)


KINDS: dict[str, Callable[[Any, float, str], BaseMotion | None]] = {
    "none": lambda spec, end, where: None,
    "sine": _sine,
    "half_sine": lambda spec, end, where: _sine_pulse(spec, 0.5),
    "one_sine": lambda spec, end, where: _sine_pulse(spec, 1.0),
    "rectangular": _rectangular,
    "ricker": _ricker,
    "table": lambda spec, end, where: read_table(spec, where),
    "record": lambda spec, end, where: read_record(spec, where),
    "synthetic": lambda spec, end, where: synthetic_motion(spec),
}
"""The motion of each kind along one direction: of its table, the end of the run (s), and the path
of the table."""
