"""A recorded accelerogram: kind = "record"."""

from __future__ import annotations

import math

import numpy as np

from solver.errors import SceneError
from solver.excitation.baseline import corrected
from solver.excitation.layouts.table import read_motion
from solver.excitation.sampled import SampledMotion
from solver.scene.checking import shown
from solver.scene.motion import RecordSpec
from solver.types import Array

SPIKE = 20.0
"""A sample more times as large as both beside it is refused unless the scene trusts the file."""


def signal(spec: RecordSpec, end: float, where: str) -> SampledMotion:
    """The samples of a recorded accelerogram; the arguments are those of all kinds."""
    return read_record(spec, where)


def read_record(spec: RecordSpec, where: str = "motion") -> SampledMotion:
    """The samples of a recorded accelerogram, the first one that is used at `spec.start`.

    Raises:
        SceneError: The file cannot be read, or is not what the scene says; names file and line.
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
    values = corrected(values, spec.baseline)
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
