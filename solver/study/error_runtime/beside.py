"""Results of other programs for the same case: points that a picture shows beside ours."""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from pathlib import Path

from solver.errors import SceneError
from solver.scene.checking import shown

COLUMNS = ("program", "measure", "error", "seconds", "note")


@dataclass(frozen=True, slots=True, kw_only=True)
class Beside:
    """A point that another program reached.

    Attributes:
        program: Its name.
        measure: What was measured.
        error: Magnitude of the relative error; where it is a bound, the note says so.
        seconds: What it took, s; nan where nobody measured it.
        note: What else to know.
    """

    program: str
    measure: str
    error: float
    seconds: float
    note: str = ""


def read_beside(file: Path) -> list[Beside]:
    """Read points from a CSV file with the columns of `COLUMNS`; lines with # are comments."""
    try:
        text = file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "not UTF-8"
        raise SceneError("--beside", f"{file} ({reason.lower()})", "a CSV file") from None
    numbered = [
        (number, line)
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.startswith("#")
    ]
    found: list[Beside] = []
    for (number, line), row in zip(numbered, csv.reader(line for _, line in numbered), strict=True):
        words = [word.strip() for word in row]
        if number == numbered[0][0]:
            if tuple(words) != COLUMNS:
                raise SceneError(f"{file}: line {number}", shown(line), ",".join(COLUMNS))
            continue
        found.append(_point(f"{file}: line {number}", line, words))
    return found


def _point(where: str, line: str, words: list[str]) -> Beside:
    """One line of the file."""
    try:
        program, measure, error, seconds, note = words
        point = Beside(
            program=program,
            measure=measure,
            error=abs(float(error)),
            seconds=float(seconds) if seconds else math.nan,
            note=note,
        )
    except ValueError:
        allowed = f"{','.join(COLUMNS)}, with error and seconds numbers, seconds empty if not known"
        raise SceneError(where, shown(line), allowed) from None
    if not (math.isfinite(point.error) and (not seconds or point.seconds > 0)):
        raise SceneError(where, shown(line), "a finite error, and seconds > 0")
    return point
