"""Findings of a study of error against run time: errors, slopes, and what to use for a target.

Beside them, for the picture, what other programs reached for the same case.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.error_runtime.ladders import LadderFamily, Trial
from benchmarks.error_runtime.reference import Reference
from solver.errors import SceneError
from solver.scene.checking import shown

#: A slope is fitted to errors above this many times the floor of their reference.
CLEAR_OF_FLOOR = 2.0

#: Columns of a file with points of other programs.
COLUMNS = ("program", "measure", "error", "seconds", "note")


@dataclass(frozen=True, slots=True, kw_only=True)
class Beside:
    """A point that another program reached.

    Attributes:
        program: Its name.
        measure: What was measured.
        error: Magnitude of the relative error; where it is a bound, the note says so.
        seconds: What it took, s; nan where it was not measured.
        note: What else to know.
    """

    program: str
    measure: str
    error: float
    seconds: float
    note: str = ""


class Slope(NamedTuple):
    """Rates at which the error of a family falls: powers in log-log, nan below two points."""

    order: float
    """With the step or the size of the cells."""
    time: float
    """With the seconds of the loop."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Findings:
    """Everything that a study found.

    Attributes:
        title: What was studied.
        machine: Where.
        repeat: Times that each run was made.
        trials: The runs.
        left_out: Runs that would have taken too long, in words.
        references: By measure; measures without one are not judged.
        names: What measures are called, by measure; the first is the one that counts most.
        target: Relative error that is aimed at.
        others: What other programs reached.
    """

    title: str
    machine: str
    repeat: int
    trials: Sequence[Trial]
    left_out: Sequence[str]
    references: Mapping[str, Reference]
    names: Mapping[str, str]
    target: float = 0.01
    others: Sequence[Beside] = ()

    @property
    def families(self) -> list[LadderFamily]:
        """The families in which something was run, in their order."""
        return list({trial.family.name: trial.family for trial in self.trials}.values())

    def error(self, trial: Trial, measure: str) -> float:
        """Relative error of a run; nan where there is none, or the run itself is the reference."""
        value, reference = trial.outcome.measures.get(measure), self.references[measure]
        if value is None or not trial.outcome.completed:
            return math.nan
        error = reference.error(value)
        return math.nan if error == 0 and reference.uncertainty > 0 else error

    def line(self, family: LadderFamily, measure: str) -> list[tuple[Trial, float]]:
        """The runs of a family with their errors, those that have one."""
        own = [trial for trial in self.trials if trial.family.name == family.name]
        pairs = [(trial, self.error(trial, measure)) for trial in own]
        return [(trial, error) for trial, error in pairs if math.isfinite(error)]

    def slope(self, family: LadderFamily, measure: str) -> Slope:
        """The slopes of a family, over the errors that stand clear of the reference's floor."""
        clear = CLEAR_OF_FLOOR * self.references[measure].floor
        points = [(t, error) for t, error in self.line(family, measure) if error > max(clear, 0)]
        errors = [error for _, error in points]
        return Slope(
            order=_power([trial.rung.size for trial, _ in points], errors),
            time=_power([trial.loop_s for trial, _ in points], errors),
        )

    def cheapest(self, measure: str, *, own: bool = True) -> Trial | None:
        """The fastest run that reaches the target, as does everything finer in its family.

        Args:
            measure: Of what.
            own: Among the families that solve the scene as it is, or among those of other models.
        """
        enough: list[Trial] = []
        for family in self.families:
            if family.own != own:
                continue
            for trial, error in reversed(self.line(family, measure)):
                if error > self.target:
                    break
                enough.append(trial)
        return min(enough, key=lambda trial: trial.loop_s) if enough else None

    def sentence(self, measure: str) -> str:
        """Sentence that says what to use for the target, and what it takes."""
        reference, name = self.references[measure], self.names[measure]
        aim = f"For {100 * self.target:g} % error of the {name}"
        if reference.uncertainty > self.target:
            return (
                f"{aim} nothing can be said: the reference ({reference.source}) "
                f"is uncertain by {100 * reference.uncertainty:.2g} %."
            )
        best, other = self.cheapest(measure), self.cheapest(measure, own=False)
        text = f"{aim} no run is good enough" if best is None else f"{aim} use {_use(best)}"
        if other is not None:
            text += f" (with {_use(other)})"
        return f"{text}."


def _use(trial: Trial) -> str:
    """A run, and what it takes."""
    family = trial.family.name
    what = trial.rung.setting
    if family not in ("step", "mesh"):
        what = f"{family}, {what}"
    coarsest = ", the coarsest tried" if trial.rung is trial.family.rungs[0] else ""
    return f"{what}{coarsest}; it takes {trial.loop_s:.3g} s"


def _power(sizes: Sequence[float], errors: Sequence[float]) -> float:
    """The power of `sizes` that fits the errors best; nan without two different sizes."""
    x, y = np.log(sizes), np.log(errors)
    if len(x) < 2 or np.ptp(x) == 0:
        return math.nan
    return float(np.polyfit(x, y, 1)[0])


def read_beside(file: Path) -> list[Beside]:
    """Read points from a CSV file with the columns of `COLUMNS`; lines with # are comments."""
    try:
        text = file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "not UTF-8"
        raise SceneError("--beside", f"{file} ({reason.lower()})", "a CSV file") from None
    lines = ["" if line.startswith("#") else line.strip() for line in text.splitlines()]
    table = csv.reader(lines)
    found: list[Beside] = []
    names: list[str] = []
    for words in ([word.strip() for word in row] for row in table if row):
        where, line = f"{file}: line {table.line_num}", lines[table.line_num - 1]
        if names:
            found.append(_point(where, line, words))
        elif tuple(names := words) != COLUMNS:
            raise SceneError(where, shown(line), ",".join(COLUMNS))
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
