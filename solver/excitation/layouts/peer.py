"""PEER's AT2 of all years: a line with NPTS and DT, then the values in reading order."""

from __future__ import annotations

import math

from solver.excitation.layouts.header import units_stated
from solver.excitation.layouts.text import NUMBER, Component, Stated, TextFile, number_in
from solver.scene.checking import shown
from solver.scene.motion import FileSpec

TITLE = "PEER AT2"

HEADER_LINES = 60
"""Number of lines among which a header names the number of values."""

COUNTED = "NPTS= number of values, DT= time between them in s"

_NPTS = rf"NPTS\s*=\s*(\d+)\s*,?\s*DT\s*=\s*({NUMBER})"
_BEHIND = rf"^\s*(\d+)\s*,?\s+({NUMBER})\s*,?\s+NPTS\s*,\s*DT"


def recognised(text: TextFile) -> bool:
    """A line with NPTS and DT, or the ending .AT2."""
    return _counted(text) is not None or text.path.suffix.lower() == ".at2"


def components(text: TextFile, spec: FileSpec) -> list[Component]:
    """The one accelerogram; of several lines with NPTS the last one counts (older headers kept)."""
    line = _counted(text) or min(4, len(text.lines))
    found = text.optional(_NPTS, [line]) or text.optional(_BEHIND, [line])
    step = number_in(found.value[2]) if found else None
    if not found or not step or not 0 < step < math.inf or int(found.value[1]) < 2:
        raise text.error(line, shown(text.lines[line - 1].strip()), COUNTED)
    count = Stated(int(found.value[1]), line)
    values, lines = text.block(line, count)
    text.nothing_after(lines[-1], count)
    units = tuple(units_stated(text.lines[:line]))
    return [Component(values=values, lines=lines, units=units, steps=(Stated(step, line),))]


def _counted(text: TextFile) -> int | None:
    """The number of the last line of the header with NPTS and DT."""
    found = None
    for line, content in enumerate(text.lines[:HEADER_LINES], start=1):
        if "npts" in content.lower() and "dt" in content.lower():
            found = line
    return found
