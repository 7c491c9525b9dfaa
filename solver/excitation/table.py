"""Ground motions given by a file of two columns."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from solver.checking import shown
from solver.errors import SceneError

ROW = "two numbers, time and acceleration"


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """Samples of the ground's acceleration, linear between them and zero outside."""

    time: NDArray[np.float64]
    """s, increasing."""
    value: NDArray[np.float64]
    """m/s^2."""

    @property
    def peak(self) -> float:
        """Largest |a_g|, m/s^2."""
        return float(np.abs(self.value).max())

    def acceleration(self, time: float) -> float:
        """Acceleration of the ground, m/s^2."""
        return float(np.interp(time, self.time, self.value, left=0.0, right=0.0))


def read_table(file: Path, unit: float) -> Table:
    """Read times (s) and accelerations (multiples of `unit`, m/s^2).

    The columns are separated by commas, semicolons or blanks; lines before the first row that do
    not begin with a number are a header; blank lines and lines that begin with # are skipped.
    """
    try:
        lines = file.read_text(encoding="utf-8-sig", errors="replace").splitlines()
    except OSError as error:
        reason = (error.strerror or "unreadable").lower()
        raise SceneError("motion.file", f"{file} ({reason})", f"a file with {ROW}") from None
    rows: list[tuple[float, float]] = []
    for number, line in enumerate(lines, start=1):
        words = _split(line)
        if not words or words[0].startswith("#") or (not rows and _number(words[0]) is None):
            continue
        where, numbers = f"{file}: line {number}", [_number(word) for word in words]
        row = [number for number in numbers if number is not None and math.isfinite(number)]
        if len(words) != 2 or len(row) != 2:
            raise SceneError(where, shown(line.strip()), ROW)
        if rows and row[0] <= rows[-1][0]:
            raise SceneError(where, f"time {row[0]:g}", f"a time above {rows[-1][0]:g}")
        rows.append((row[0], row[1]))
    if len(rows) < 2:
        raise SceneError(str(file), f"{len(rows)} rows", f"two rows or more of {ROW}")
    time, value = np.array(rows).T
    return Table(time=time, value=value * unit)


def _split(line: str) -> list[str]:
    separator = next((sign for sign in ",;" if sign in line), None)
    return [word.strip() for word in line.split(separator)] if line.strip() else []


def _number(word: str) -> float | None:
    try:
        return float(word)
    except ValueError:
        return None
