"""The time loop of a run, whatever engine takes the steps."""

from __future__ import annotations

import gc
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from solver.excitation.motion import GroundMotion
from solver.fields.vtu import FieldsBefore
from solver.history.events import Event, Meeting
from solver.history.history import History
from solver.history.pairs import PairTable, kept_pairs
from solver.results.endings import Watch
from solver.results.events import Recorder
from solver.results.meetings import Contacts
from solver.resumable import Resumable
from solver.run.checkpoint import Checkpoint
from solver.run.files import Fields, RunFiles
from solver.run.interruption import Interruption
from solver.scene import Scene
from solver.types import Array


class ProgressReport(Protocol):
    """A display of progress."""

    def begin(self, time: float) -> None:
        """Set-up is over; steps begin at `time`."""

    def update(self, time: float, step: float, iterations: int) -> None:
        """A step of length `step` ended at `time`."""

    def close(self) -> None:
        """The run ended."""


TIME, STEP, ITERATIONS = range(3)
"""Places of time, step and iterations in the rows of every history."""

NO_PAIRS: Array = np.empty((0, 0))


@dataclass(frozen=True, slots=True, eq=False)
class Batch:
    """Steps that an engine has taken."""

    rows: Array
    """Their rows of the history, (steps, columns)."""
    met: Sequence[Meeting] = ()
    """Bodies that met in them."""
    happened: Sequence[Event] = ()
    """What happened to links."""
    pairs: Array = field(default_factory=NO_PAIRS.copy)
    """What pairs of bodies did to one another, as `World.pairs` has them, if that is told."""
    reason: str = ""
    """Reason why the run ends with them; empty where it goes on."""
    failed: bool = False
    """True if that is because a step found no solution."""


class Engine(Protocol):
    """The engine of a run: with meshed bodies, or with rigid ones alone."""

    description: str
    """Size of the problem, for the log."""
    remarks: Sequence[str]
    """Cautions about what could not begin as requested, in words."""

    steps: int
    """Number of steps that were taken."""

    @property
    def body_names(self) -> Sequence[str]:
        """Names of all bodies, by their numbers in pairs."""

    @property
    def time(self) -> float:
        """The time that the run has reached, s."""

    def first_row(self) -> Sequence[float] | NDArray[np.float64]:
        """The row of the history at t = 0."""

    def pairs(self) -> Array:
        """What pairs of bodies did in the last step, as `World.pairs` of one step, if it is told.

        At t = 0 in the instant after it, or nothing where no step has told of it; collective.
        """

    def open_fields(self, folder: Path, before: FieldsBefore) -> Fields:
        """Writer of the fields, after those that an earlier part of the run has left."""

    def saved(self) -> dict[str, Any]:
        """State of the run, for `resume`."""

    def resume(self, saved: Mapping[str, Any]) -> None:
        """Go on from where another engine of the same scene was saved; collective."""

    @property
    def done(self) -> bool:
        """True once no whole step is left up to the end."""

    def advance(self, context: RunContext, due: float) -> Batch:
        """One step or several, not beyond the snapshot that is due, s."""

    def rest(self, context: RunContext, *, completed: bool) -> Batch:
        """What is left where a run ends, with a last, shorter step if it is completed."""

    def contacts(self) -> Contacts | None:
        """The deepest overlap, and how exact contact is; None where the engine keeps no account."""

    def cost(self) -> dict[str, Any]:
        """Counts of steps, iterations and unknowns of the run, without its wall time."""


@dataclass(slots=True)
class RunContext(Resumable):
    """The scene of a run with its history and files, and the reasons to end it early."""

    CARRIED = ("watch", "recorder", "waiting")

    scene: Scene
    """The scene."""
    history: History
    """Takes the rows."""
    files: RunFiles
    """The folder of the run, if there is one."""
    interruption: Interruption
    """Signals and the limit of wall time."""
    progress: ProgressReport | None
    """A display."""
    ground: GroundMotion
    """Motion of the ground, which checkpoints belong to."""
    watch: Watch = field(init=False)
    """Looks for blocks that overturn or fall, where that ends the run."""
    recorder: Recorder = field(init=False)
    """Finds the events in the steps that are taken."""
    pairs: PairTable | None = None
    """Takes the rows of pairs of bodies, where the scene requests them."""
    waiting: tuple[Array, Array] | None = None
    """The last row and its pairs, where the history does not have them: they may be the end."""

    def __post_init__(self) -> None:
        """Begin without any event, and with nothing that ends the run."""
        self.watch = Watch(self.scene)
        self.recorder = Recorder(self.scene, self.history.columns)

    def begin(self, engine: Engine, resumed: Checkpoint | None) -> None:
        """Record the start, or go on from a checkpoint."""
        if resumed is None:
            first = np.array(engine.first_row())
            self.history.append(first)
            self.watch.look(first[None])
            self.recorder.add(first[None])
            return
        own, others = resumed.saved
        engine.resume(own)
        self.resume(others)
        self.files.log(f"resumed at t = {resumed.time:.6g} s")

    def loop(self, engine: Engine) -> tuple[str, str]:
        """Step to the end, and find all events; returns status and reason."""
        if self.progress is not None:
            self.progress.begin(engine.time)
        gc.freeze()  # what dolfinx and UFL have loaded is no garbage: 5 % of a small step
        try:
            ended = self._steps(engine)
            self.history.events = self.recorder.finish()
            self.files.flush()
        finally:
            gc.unfreeze()
        return ended

    def _steps(self, engine: Engine) -> tuple[str, str]:
        """Step to the end; returns status and reason."""
        files = self.files
        if self.scene.output.pairs:
            self.pairs = files.open_pairs(engine.body_names)
            if not engine.steps:
                self.pairs.add(np.zeros(1), engine.pairs())
        status, reason = "completed", ""
        due = files.next_snapshot(engine.time)
        while not (engine.done or reason):
            reason = self.stopped(engine.time)
            if reason:
                status = "interrupted"
                break
            status, reason = self._take(engine, engine.advance(self, due))
            if engine.time >= due * (1 - 1e-12):
                files.snapshot(engine.time)
                due = files.next_snapshot(engine.time)
            if not reason:
                self._keep(engine)
        if not reason or status == "interrupted":
            self._keep(engine, ends=True)
        ended = self._take(engine, engine.rest(self, completed=not reason))
        if not reason:
            status, reason = ended
        if self.waiting is not None:
            row, pairs = self.waiting
            self.history.append(row)
            self._tell_pairs(row[:1], pairs)
        files.snapshot(engine.time)
        return status, reason

    def stopped(self, now: float) -> str:
        """Reason why the run has to stop at a time (s); empty where it has not."""
        if not self.interruption.requested():
            return ""
        return f"stopped by {self.interruption.cause} at t = {now:.6g} s"

    def _take(self, engine: Engine, batch: Batch) -> tuple[str, str]:
        """Record steps; returns status and, where the run ends with them, the reason."""
        rows, pairs = batch.rows, batch.pairs
        self.recorder.add(rows, batch.met, batch.happened)
        if len(rows):
            number = np.arange(engine.steps - len(rows), engine.steps) + 1
            kept = number % self.scene.output.history_every == 0
            self.history.extend(rows[kept])
            self._tell_pairs(rows[:, TIME], kept_pairs(pairs, kept))
            last = kept_pairs(pairs, number == engine.steps)
            last[:, :1] = 0
            self.waiting = None if kept[-1] else (rows[-1], last)
            if self.progress is not None:
                time, step, iterations = rows[-1, : ITERATIONS + 1]
                self.progress.update(float(time), float(step), int(iterations))
        return "not converged" if batch.failed else "completed", batch.reason

    def _tell_pairs(self, times: Array, pairs: Array) -> None:
        """Write what pairs of bodies did in steps whose ends have times, s."""
        if self.pairs is not None:
            self.pairs.add(times, pairs)

    def _keep(self, engine: Engine, *, ends: bool = False) -> None:
        """Write what waits, and a checkpoint where one is due or the run ends for now."""
        if self.files.late:
            self.history.events = self.recorder.events
            self.files.flush()
        schedule = self.files.schedule
        if schedule.is_due(engine.steps) or (ends and schedule.wanted):
            self.files.keep(self.ground, engine.time, (engine.saved(), self.saved()))
