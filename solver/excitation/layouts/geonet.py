"""GeoNet V1A and V2A (New Zealand): text, ten rows of ten numbers, values in mm/s2."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from solver.excitation.layouts.text import NUMBER, Component, Stated, TextFile
from solver.scene.motion import FileSpec
from solver.types import Array

TITLE = "GeoNet"

ROWS = 10
"""Rows of ten numbers between the text and the values."""

_TITLE = r"(un)?corrected accelerogram"
_STATED = rf"(?:units of\s+({NUMBER})\s*mm/s/s\s+)?at (?:intervals of\s+)?({NUMBER})\s*s(?:ec)?\b"
_DATA = rf"^(?:Raw readings|Instrument corrected data).*{_STATED}"


def recognised(text: TextFile) -> bool:
    """The title, and the line about readings."""
    among = range(1, min(len(text.lines), 30) + 1)
    return text.optional(_TITLE, [1]) is not None and text.optional(_DATA, among) is not None


def components(text: TextFile, spec: FileSpec) -> Iterator[Component]:
    """The components one after another; velocities and displacements are passed over."""
    begin = 1
    while title := text.optional(_TITLE, range(begin, len(text.lines) + 1)):
        following = text.optional(_TITLE, range(title.line + 1, len(text.lines) + 1))
        within = range(title.line, following.line if following else len(text.lines) + 1)
        data = text.required(_DATA, "Raw readings or Instrument corrected data", within)
        last = data.line
        while last < len(text.lines) and any(c.isalpha() for c in text.lines[last]):
            last += 1
        head, rows = _numbers(text, last)
        among = range(title.line, last + 1)
        raw = title.value[1] is not None
        count = Stated(int(head[3, 0 if raw else 3]), rows[3])
        step = Stated(float(head[6, 4 if raw else 5]), rows[6])
        stated = text.optional(r"Number of points\s+(\d+)", among)
        if stated:
            text.agree(Stated(int(stated.value[1]), stated.line), count, "number of points")
        text.agree(Stated(float(data.value[2]), data.line), step, "interval")
        name = text.optional(r"^Component\s+(\S+)", among)
        values, lines = text.block(rows[-1], count)
        factor = float(data.value[1] or 1.0)
        yield Component(
            name=name.value[1] if name else "",
            values=values * factor,
            lines=lines,
            units=(Stated("mm/s2", data.line),),
            steps=(step,),
            notes=() if factor == 1.0 else (f"readings times {factor:g} mm/s2",),
        )
        begin = lines[-1] + 1
        for others in () if raw else (head[3, 4], head[3, 5]):
            if others > 0:
                begin = text.block(begin - 1, Stated(int(others), rows[3]))[1][-1] + 1
        text.nothing_after(begin - 1, count, whole=False)


def _numbers(text: TextFile, after: int) -> tuple[Array, list[int]]:
    """The rows of numbers above the values, (10, 10), and their lines."""
    rows = range(after + 1, after + ROWS + 1)
    if rows[-1] > len(text.lines):
        raise text.error(len(text.lines), "the end of the file", f"{ROWS} rows of numbers")
    head = [text.row(line) for line in rows]
    for line, row in zip(rows, head, strict=True):
        if len(row) != 10:
            raise text.error(line, f"{len(row)} numbers in a row of the header", "10")
    counts = head[3][:6]
    if any(count != int(count) or not 0 <= count < 1e9 for count in counts) or head[6][4] <= 0:
        raise text.error(rows[3], "numbers that are no counts", "a header of 10 rows of 10 numbers")
    return np.array(head), list(rows)
