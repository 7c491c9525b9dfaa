"""A recorded accelerogram, a file of PEER, of two columns or of one: kind = "record"."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np

from solver.errors import SceneError, missing_key, not_applicable
from solver.excitation.baseline import corrected
from solver.excitation.header import refuse_milliseconds, unit_said
from solver.excitation.numbers import Row, number_in, read_lines, rows_of, split_header
from solver.excitation.sampled import SampledMotion, even_step
from solver.scene.checking import shown
from solver.scene.motion import RecordSpec
from solver.scene.units import UNITS
from solver.types import Array

EXPECTED = "an accelerogram: PEER's .AT2, two columns (time, acceleration), or one with dt"

COUNTED = "NPTS= number of values, DT= time between them in s"

TIMELESS = "files that do not say the time between their values"

SPIKE = 20.0
"""A sample more times as large as both beside it is refused unless the scene trusts the file."""

HEADER_LINES = 20
"""Number of lines among which a header of PEER names the number of values."""

FEWEST_TIMES = 5
"""Rows of several columns whose first one rises by about the same from row to row are those of a
table with times, where there are so many."""

_NUMBER = r"(\d*\.?\d+(?:[eEdD][-+]?\d+)?|\d+\.)"
_NPTS = re.compile(rf"NPTS\s*=\s*(\d+)\s*,?\s*DT\s*=\s*{_NUMBER}", re.IGNORECASE)
_NPTS_BEHIND = re.compile(rf"^\s*(\d+)\s*,?\s+{_NUMBER}\s*,?\s+NPTS\s*,\s*DT", re.IGNORECASE)


def signal(spec: RecordSpec, end: float, where: str) -> SampledMotion:
    """The samples of a recorded accelerogram; the arguments are those of all kinds."""
    return read_record(spec, where)


def read_record(spec: RecordSpec, where: str = "motion") -> SampledMotion:
    """The samples of a recorded accelerogram, the first one that is used at `spec.start`.

    Raises:
        SceneError: The file cannot be read, or is not what the scene says; names file and line.
    """
    lines = read_lines(spec.file, f"{where}.file", EXPECTED)
    counted = next(
        (i for i, line in enumerate(lines[:HEADER_LINES]) if "npts" in line.lower()), None
    )
    if counted is not None or spec.file.suffix.lower() == ".at2":
        header, step, rows = _peer(spec, where, lines, counted)
    else:
        header, step, rows = _columns(spec, where, lines)
    unit = UNITS[_unit(spec, where, header)]
    used = _cut(spec, where, sum(len(row.values) for row in rows), step)
    numbers = [row.line for row in rows for _ in row.values][used]
    values: Array = np.array([value for row in rows for value in row.values][used])
    if not spec.trust:
        _refuse_spike(spec, where, values, numbers)
    values = values * (unit * spec.scale)
    largest = f"line {numbers[int(np.argmax(np.abs(values)))]} of {spec.file}"
    values = corrected(values, spec.baseline)
    time = spec.start + step * np.arange(len(values))
    return SampledMotion(time=time, value=values, step=step, largest=largest)


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


def _peer(
    spec: RecordSpec, where: str, lines: list[str], counted: int | None
) -> tuple[list[str], float, list[Row]]:
    """Header, time between samples and rows of values of a file that says how many there are."""
    line = counted if counted is not None else min(3, len(lines) - 1)
    found = _NPTS.search(lines[line]) or _NPTS_BEHIND.search(lines[line])
    step = float(found[2].upper().replace("D", "E")) if found else 0.0
    if not found or not np.isfinite(step) or step <= 0 or int(found[1]) < 2:
        raise SceneError(f"{spec.file}: line {line + 1}", shown(lines[line].strip()), COUNTED)
    if spec.dt is not None:
        raise not_applicable(f"{where}.dt", f"{TIMELESS} ({spec.file} has DT= {step:g})")
    count, read = int(found[1]), 0
    expected = f"{count} values, NPTS of line {line + 1}"
    rows = rows_of(spec.file, lines[line + 1 :], "finite numbers", first=line + 2)
    for row in rows:
        read += len(row.values)
        if read > count:
            raise SceneError(f"{spec.file}: line {row.line}", "more values", expected)
    if read < count:
        got = f"the end of the file after {read} values"
        raise SceneError(f"{spec.file}: line {len(lines)}", got, expected)
    return lines[: line + 1], step, rows


def _columns(spec: RecordSpec, where: str, lines: list[str]) -> tuple[list[str], float, list[Row]]:
    """Header, time between samples and rows of a file of one column, of two, or of values.

    Of two columns the rows hold the values alone.
    """
    header, rest = split_header(lines)
    rows = rows_of(spec.file, rest, EXPECTED, first=len(header) + 1)
    numbers = sum(len(row.values) for row in rows)
    if numbers < 2 or (len(rows) == 1 and numbers == 2):  # a line of two is a time and one sample
        raise SceneError(f"{spec.file}: line {len(lines)}", "too few numbers", EXPECTED)
    width, last = len(rows[0].values), rows[-1]
    for row in rows:
        # The last line of values in reading order may be a short one.
        short = row is last and width > 2 and len(row.values) < width
        if len(row.values) != width and not short:
            got, wanted = f"a line of {len(row.values)}", f"{width} as in line {rows[0].line}"
            raise SceneError(f"{spec.file}: line {row.line}", got, wanted)
    if width == 2:
        if spec.dt is not None:
            reason = f"{TIMELESS} ({spec.file} has times in its first column)"
            raise not_applicable(f"{where}.dt", reason)
        refuse_milliseconds(spec.file, header)
        samples = [Row(row.line, row.words[1:], row.values[1:]) for row in rows]
        return header, _even(spec.file, rows), samples
    if _first_is_time(rows):
        got = f"{width} columns, the first of which is time"
        raise SceneError(f"{spec.file}: line {rows[0].line}", got, "time and one acceleration")
    if spec.dt is None:
        reason = f"(dt > 0, s): {spec.file} does not say the time between its values"
        raise missing_key(f"{where}.dt", reason)
    return header, spec.dt, rows


def _first_is_time(rows: list[Row]) -> bool:
    """Whether the first of several columns holds times, not every so-many-th acceleration."""
    if len(rows) < FEWEST_TIMES or len(rows[0].values) < 2:
        return False
    apart = np.diff([row.values[0] for row in rows])
    return bool(apart.min() > 0 and apart.max() < 2 * apart.min())


def _even(file: Path, rows: list[Row]) -> float:
    """Time between the samples of two columns; the same for all, as far as their digits tell."""
    time = np.array([row.values[0] for row in rows])
    even = even_step(time)
    if even is not None:
        return even
    steps, step = np.diff(time), float(time[-1] - time[0]) / (len(time) - 1)
    usual = float(np.median(steps))
    wrong = np.abs(steps - usual) > 1e-6 * abs(usual)
    unit = _last_digits([row.words[0] for row in rows])
    if step > 2 * np.max(unit):  # coarser digits would hide a sample that is missing
        line = np.polynomial.Polynomial.fit(np.arange(len(time)), time, 1, w=1 / unit)
        # Rounded times are off by half a unit of their last digit, the line by what that leaves.
        off = unit * min(1.0, 0.5 + 2 / math.sqrt(len(time)))
        beside = np.abs(time - line(np.arange(len(time)))) > off
        wrong = beside[1:]
        wrong[0] |= beside[0]  # between the first two
        # A row that is missing leaves twice the usual distance, and tilts the line besides.
        apart = steps - line.deriv()(0.0) > np.maximum(unit[1:] + unit[:-1], usual / 3)
        wrong = apart if apart.any() else wrong
        if not wrong.any():
            return float(line.deriv()(0.0))
    at = int(np.argmax(wrong))
    allowed = f"times equally far apart, {usual:.6g} s like most of them"
    if usual <= 0:
        at, allowed = int(np.argmax(steps <= 0)), "times that increase"
    got = f"time {rows[at + 1].words[0]}, {steps[at]:.6g} s after the last one"
    raise SceneError(f"{file}: line {rows[at + 1].line}", got, allowed)


def _last_digits(words: list[str]) -> Array:
    """What the last printed digit of each time stands for, s.

    Zeros at the end may have been left out: what counts is the largest number of decimals in the
    column, for large times the largest number of digits.
    """
    mantissas = [re.split("[eEdD]", word)[0].lstrip("+-") for word in words]
    exponents = [int(re.split("[eEdD]", f"{word}e0")[1]) for word in words]
    decimals = max(
        len(mantissa.partition(".")[2]) - exponent
        for mantissa, exponent in zip(mantissas, exponents, strict=True)
    )
    digits = max(len(mantissa.replace(".", "").lstrip("0")) for mantissa in mantissas)
    leading = [math.floor(math.log10(abs(number_in(word) or 0.0) or 1e-300)) for word in words]
    return np.maximum(10.0**-decimals, 10.0 ** (np.array(leading, dtype=float) + 1 - digits))


def _unit(spec: RecordSpec, where: str, header: list[str]) -> str:
    """Unit of the values, which the scene or the header has to say."""
    unit = unit_said(spec.file, header, spec.units, where)
    if unit is None:
        reason = f'("g", "m/s2", "cm/s2", ...): {spec.file} does not say it'
        raise missing_key(f"{where}.units", reason)
    return unit


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
