"""A motion from a file of two columns: kind = "table"."""

from __future__ import annotations

import numpy as np

from solver.errors import SceneError
from solver.excitation.header import refuse_milliseconds, unit_said
from solver.excitation.numbers import read_lines, rows_of, split_header
from solver.excitation.sampled import SampledMotion, even_step
from solver.scene.checking import shown
from solver.scene.motion import TableSpec
from solver.scene.units import UNITS

ROW = "two numbers, time and acceleration"


def signal(spec: TableSpec, end: float, where: str) -> SampledMotion:
    """Read times (s) and accelerations.

    The columns are separated by commas, semicolons or blanks; lines before the first row that do
    not begin with a number are a header; blank lines and lines that begin with # are skipped.

    Raises:
        SceneError: The file cannot be read, or is no such table; names file and line.
    """
    file = spec.file
    lines = read_lines(file, f"{where}.file", ROW)
    header, rest = split_header(lines)
    refuse_milliseconds(file, header)
    unit = UNITS[unit_said(file, header, spec.units, where) or "g"] * spec.scale
    rows = rows_of(file, rest, ROW, first=len(header) + 1)
    before = None
    for row in rows:
        place = f"{file}: line {row.line}"
        if len(row.values) != 2:
            raise SceneError(place, shown(lines[row.line - 1].strip()), ROW)
        if before is not None and row.values[0] <= before:
            raise SceneError(place, f"time {row.values[0]:g}", f"a time above {before:g}")
        before = row.values[0]
    if len(rows) < 2:
        raise SceneError(str(file), f"{len(rows)} rows", f"two rows or more of {ROW}")
    time, value = np.array([row.values for row in rows]).T
    largest = f"line {rows[int(np.argmax(np.abs(value)))].line} of {file}"
    return SampledMotion(time=time, value=value * unit, step=even_step(time), largest=largest)
