"""Caltech's and USC's Volume I, and CSMIP's of these years: pairs of time and acceleration."""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np

from solver.excitation.layouts.header import unit_of
from solver.excitation.layouts.text import NUMBER, Component, Stated, TextFile
from solver.excitation.sampled import even_step
from solver.scene.checking import shown
from solver.scene.motion import FileSpec

TITLE = "Caltech, USC Volume I"

REAL_LINES = 7
"""Lines of the header of reals, fifty of them in fields of ten characters."""

_UNITS = r"UNITS\s+(?:OF UNCOR DATA\s+)?ARE\s+SEC(?:ONDS)?\s+AND\s+(\S+)"
_COUNT = r"NO\. OF POINTS\s*=\s*(\d+)"
_LENGTH = rf"(?:DURATION|RECORD LENGTH)\s*=\s*({NUMBER})\s*SEC"


def recognised(text: TextFile) -> bool:
    """The title of uncorrected data, and the units of the pairs."""
    return (
        text.optional(r"uncorrected accelerogram data", [1]) is not None
        and text.optional(_UNITS) is not None
    )


def components(text: TextFile, spec: FileSpec) -> Iterator[Component]:
    """The components one after another; their samples need not be equally far apart."""
    begin = 1
    while units := text.optional(_UNITS, range(begin, len(text.lines) + 1)):
        among = range(begin, units.line + 1)
        count = text.count(_COUNT, "NO. OF POINTS", among)
        name = text.optional(r"^(?:COMP|Chan\s+\d+:)\s*(.*?)(?:\s{2,}|$)", reversed(among))
        values, lines = text.block(_reals(text, units.line), Stated(2 * count.value, count.line))
        text.nothing_after(lines[-1], count, whole=False)
        time, value = values.reshape(-1, 2).T
        at = int(np.argmax(np.diff(time) <= 0))
        if time[at + 1] <= time[at]:
            got = f"time {time[at + 1]:g} after {time[at]:g}"
            raise text.error(lines[2 * at + 2], got, "times that increase")
        length = text.optional(_LENGTH, among)
        if length and abs(float(length.value[1]) - (time[-1] - time[0])) > 0.01 * time[-1]:
            got, times = f"{length.value[1]} s", f"{time[0]:g} to {time[-1]:g} s of the values"
            raise text.error(length.line, got, times)
        yield Component(
            name=name.value[1] if name else "",
            values=value,
            lines=lines[1::2],
            units=(Stated(unit_of(units.value[1]), units.line),),
            time=time,
            even=even_step(time),
        )
        begin = lines[-1] + 1


def _reals(text: TextFile, line: int) -> int:
    """The number of the last line of the numeric headers: integers, then reals."""
    last = len(text.lines)
    while line < last and not re.fullmatch(r"[\s\d-]*\d[\s\d-]*", text.lines[line]):
        line += 1
    while line < last and "." not in text.lines[line]:
        line += 1
    if line + REAL_LINES >= last:
        got = shown(text.lines[last - 1].strip())
        raise text.error(last, got, "headers of integers and reals, then pairs of numbers")
    return line + REAL_LINES
