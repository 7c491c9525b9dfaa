"""The interface between a run and its engine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from solver.excitation.motion import GroundMotion
from solver.fields.vtu import FieldsBefore
from solver.history.history import History
from solver.results.endings import Watch
from solver.results.events import Recorder
from solver.results.meetings import Contacts
from solver.run.files import Fields, RunFiles
from solver.run.interruption import Interruption
from solver.scene import Scene


class ProgressReport(Protocol):
    """A display of progress."""

    def begin(self, time: float) -> None:
        """Set-up is over; steps begin at `time`."""

    def update(self, time: float, step: float, iterations: int) -> None:
        """A step of length `step` ended at `time`."""

    def close(self) -> None:
        """The run ended."""


class Engine(Protocol):
    """The engine of a run: with meshed bodies, or with rigid ones alone."""

    description: str
    """Size of the problem, for the log."""
    remarks: Sequence[str]
    """Cautions about what could not begin as requested, in words."""

    def first_row(self) -> Sequence[float] | NDArray[np.float64]:
        """The row of the history at t = 0."""

    def open_fields(self, folder: Path, before: FieldsBefore) -> Fields:
        """Writer of the fields, after those that an earlier part of the run has left."""

    def saved(self) -> dict[str, Any]:
        """State of the run, for `resume`."""

    def resume(self, saved: dict[str, Any]) -> None:
        """Go on from where another engine of the same scene was saved; collective."""

    def loop(self, context: RunContext) -> tuple[str, str]:
        """Step to the end; returns status and reason."""

    def contacts(self) -> Contacts | None:
        """The deepest overlap, and how exact contact is; None where the engine keeps no account."""

    def cost(self) -> dict[str, Any]:
        """Counts of steps, iterations and unknowns of the run, without its wall time."""


@dataclass(slots=True)
class RunContext:
    """The scene of a run with its history and files, and the reasons to end it early."""

    scene: Scene
    """The scene."""
    history: History
    """Takes the rows."""
    files: RunFiles
    """The folder of the run, if there is one."""
    interruption: Interruption
    """Signals and the limit of wall time."""
    watch: Watch
    """Looks for blocks that overturn or fall, where that ends the run."""
    recorder: Recorder
    """Finds the events in the steps that are taken."""
    progress: ProgressReport | None
    """A display."""
    ground: GroundMotion
    """Motion of the ground, which checkpoints belong to."""

    def keep(self, engine: Engine, step: int, now: float, *, ends: bool = False) -> None:
        """Write what waits, and a checkpoint where one is due or the run is interrupted there."""
        if self.files.late:
            self.history.events = self.recorder.events
            self.files.flush()
        schedule = self.files.schedule
        if schedule.is_due(step) or (ends and schedule.wanted):
            saved = engine.saved(), self.watch.before, self.recorder.saved()
            self.files.keep(self.ground, now, saved)

    def show(self, now: float, step: float, iterations: int) -> None:
        """Tell the display of a finished step."""
        if self.progress is not None:
            self.progress.update(now, step, iterations)

    def stopped(self, now: float) -> str:
        """Reason why the run has to stop at a time (s); empty where it has not."""
        if not self.interruption.requested():
            return ""
        return f"stopped by {self.interruption.cause} at t = {now:.6g} s"
