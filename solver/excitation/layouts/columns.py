"""Plain text and CSV: columns of accelerations, with or without times in the first one."""

from __future__ import annotations

import itertools
import math
import re

import numpy as np

from solver.errors import SceneError
from solver.excitation.layouts.header import (
    counts_stated,
    names_milliseconds,
    steps_stated,
    unit_of_heading,
    units_stated,
)
from solver.excitation.layouts.text import (
    Component,
    Row,
    Stated,
    TextFile,
    number_in,
    rows_of,
    split_header,
)
from solver.excitation.sampled import even_step
from solver.scene.motion import FileSpec
from solver.types import Array

TITLE = "columns"

EXPECTED = "an accelerogram: a layout of docs/motions.md, or columns of numbers"

FEWEST_TIMES = 5
"""Rows of several columns whose first one rises by about the same from row to row are those of a
table with times, where there are so many."""

_TIME = re.compile(r"(?:t|time\w*|zeit|tiempo|temps|tempo|sec\w*|s)\b", re.IGNORECASE)
_INDEX = re.compile(
    r"(?:sample\w*|n|i|k|no\.?|nr\.?|num\w*|row|index|idx|id|point\w*|#)\s*$", re.IGNORECASE
)


def recognised(text: TextFile) -> bool:
    """Always: anything that is no other layout."""
    return True


def components(text: TextFile, spec: FileSpec) -> list[Component]:
    """The columns that hold accelerations, by their numbers in the file."""
    header, rest = split_header(text.lines)
    line = names_milliseconds(header)
    if line:
        raise text.error(line, "times in ms", "times in s")
    rows = rows_of(text.path, rest, EXPECTED, first=len(header) + 1)
    numbers = sum(len(row.values) for row in rows)
    if len(rows) < 2 or numbers < 2:
        quotes = ", numbers without quotes" if any('"' in line for line in text.lines) else ""
        raise text.error(len(text.lines), "too few numbers", f"{EXPECTED}{quotes}")
    width = len(rows[0].values)
    for row in rows:
        if len(row.values) != width:
            got, wanted = f"a line of {len(row.values)}", f"{width} as in line {rows[0].line}"
            order = "; values in reading order go one to a line" if width > 2 else ""
            raise text.error(row.line, got, f"{wanted}{order}")
    stated = list(counts_stated(header))
    if stated and len(rows) not in {count.value for count in stated}:
        got = f"{stated[0].value} samples in line {stated[0].line}"
        raise SceneError(str(text.path), got, f"{len(rows)}, the number of its rows")
    at, headings = _headings(header, width)
    names = [re.sub(r"\s*[(\[].*", "", heading) for heading in headings]
    dt = spec.dt if spec.kind == "record" else None
    first = _first_column(rows, names[0], spec)
    if first == "index" and (spec.column is None or dt is None):
        got = "row numbers in the first column"
        allowed = "times in s there, named so in a heading, or motion.dt and motion.column = 2"
        raise text.error(rows[0].line, got, allowed)
    time = np.array([row.values[0] for row in rows]) if first == "time" else None
    even = None
    if time is not None:
        even = _even(text, rows) if spec.kind == "record" else _rising(text, rows)
    units, steps = list(units_stated(header)), tuple(steps_stated(header))
    return [
        Component(
            name=names[k],
            number=k + 1,
            values=np.array([row.values[k] for row in rows]),
            lines=[row.line for row in rows],
            units=_units(units, at, headings[k]),
            steps=steps,
            time=time,
            even=even,
        )
        for k in range(0 if first == "values" else 1, width)
    ]


def _headings(header: list[str], width: int) -> tuple[int, list[str]]:
    """The headings of several columns, and the number of their line; 0: there are none."""
    lines = [i for i, line in enumerate(header, start=1) if line.strip("# \t")]
    last = header[lines[-1] - 1].strip().lstrip("#").strip() if lines else ""
    for separator in (r"\s*[,;]\s*", r"\t+|\s{2,}", r"\s+"):
        words = [word.strip().strip('"').strip() for word in re.split(separator, last)]
        if width > 1 and len(words) == width and not re.search("[:=]", last):
            return lines[-1], words
    return 0, [""] * width


def _units(stated: list[Stated[str]], at: int, heading: str) -> tuple[Stated[str], ...]:
    """The units of a column: that of its own heading, and what other lines state of all columns."""
    own = unit_of_heading(heading)
    others = tuple(said for said in stated if said.line != at)
    return others if own is None else (*others, Stated(own, at))


def _first_column(rows: list[Row], name: str, spec: FileSpec) -> str:
    """The contents of the first column: "time", "index" or "values"."""
    width = len(rows[0].values)
    if width == 1:
        return "values"
    if _INDEX.match(name):
        return "index"
    if _TIME.match(name) or spec.kind == "table":
        return "time"
    apart = np.diff([row.values[0] for row in rows])
    whole = all(row.words[0].lstrip("+").isdigit() for row in rows)
    if whole and len(rows) >= FEWEST_TIMES and bool((apart == 1).all()):
        return "index"
    even = len(rows) >= FEWEST_TIMES and apart.min() > 0 and apart.max() < 2 * apart.min()
    return "time" if even or (width == 2 and spec.dt is None) else "values"


def _rising(text: TextFile, rows: list[Row]) -> float | None:
    """The time between the samples of a table, where it is the same; they have to increase."""
    for before, row in itertools.pairwise(rows):
        if row.values[0] <= before.values[0]:
            got, allowed = f"time {row.values[0]:g}", f"a time above {before.values[0]:g}"
            raise text.error(row.line, got, allowed)
    return even_step(np.array([row.values[0] for row in rows]))


def _even(text: TextFile, rows: list[Row]) -> float:
    """Time between the samples of two columns; the same for all, within their printed digits."""
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
    raise text.error(rows[at + 1].line, got, allowed)


def _last_digits(words: list[str]) -> Array:
    """Value of the last printed digit of each time, s.

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
