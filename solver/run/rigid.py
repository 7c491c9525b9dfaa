"""Scenes whose bodies are all rigid: the time loop, in the plane and in space.

Many steps at a time run in compiled code, up to the next snapshot. Nothing here needs dolfinx,
PETSc or Gmsh.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from solver.excitation.motion import GroundMotion, read_ground
from solver.fields.rigid_snapshots import RigidSnapshots
from solver.fields.vtu import FieldsBefore
from solver.results.endings import Ending
from solver.results.meetings import Contacts
from solver.resumable import Resumable
from solver.rigid.system import Advance, RigidSystem
from solver.run.context import ITERATIONS, TIME, Batch, RunContext
from solver.scene import Scene
from solver.types import Array

#: Most steps between two times at which the run can be interrupted.
STEPS_AT_ONCE = 500

#: Wall time of steps at once above which there are fewer the next time, s; else there are more.
LONGEST_BATCH = 0.5


class RigidRun(Resumable):
    """The engine of scenes with rigid bodies alone."""

    CARRIED = (
        *("_system", "steps", "time", "_rejected", "_iterations", "_unsettled", "_largest_defect"),
    )

    remarks: Sequence[str] = ()

    def __init__(
        self,
        scene: Scene,
        log: Callable[[str], None],
        ground: GroundMotion | None = None,
        *,
        writes: bool = True,
        ranks: int = 1,
    ):
        """Set up at t = 0; the motion of the ground is read here where it is not given.

        All ranks compute the same; `writes` is False on all but one.
        """
        self._scene, self._log, self._writes, self._ranks = scene, log, writes, ranks
        self._span = scene.time
        self._motion = ground or read_ground(scene)
        self._at_once = 1
        self._system = RigidSystem(scene)
        if scene.output.pairs or scene.output.fields != "none":
            self._system.tell_pairs(every=scene.output.pairs)
        self.body_names = self._system.body_names
        self.steps, self.time = 0, 0.0
        self._rejected = self._iterations = self._unsettled = 0
        self._largest_defect = 0.0
        self.description = f"{self._system.unknowns} unknowns, {len(scene.blocks)} rigid blocks"

    def first_row(self) -> Array:
        """The row of the history at t = 0."""
        return self._system.row(self._scene.time.step, tuple(self._motion.acceleration(0.0)))

    def pairs(self) -> Array:
        """What pairs of bodies did in the last step, as `World.pairs` of one step."""
        return self._system.pairs

    def open_fields(self, folder: Path, before: FieldsBefore) -> RigidSnapshots:
        """Writer of the fields, after those that an earlier part of the run has left."""
        return RigidSnapshots(self._system, folder, self._scene, writes=self._writes, before=before)

    @property
    def _total(self) -> int:
        """Number of whole steps up to the end."""
        return math.floor(self._span.end / self._span.step + 1e-9)

    @property
    def done(self) -> bool:
        """True once all whole steps are taken."""
        return self.steps >= self._total

    def advance(self, context: RunContext, due: float) -> Batch:
        """Steps up to the snapshot that is due, s, or to where the run can be interrupted."""
        began, first = time.perf_counter(), self.steps
        saved = self._system.saved() if context.watch.ends_runs else None
        outcome = self._steps_to(self._next_stop(context, due))
        ending = context.watch.look(outcome.rows) if len(outcome.rows) else None
        if ending is not None and saved is not None:
            # Once more, up to the step with which the run ends: the bodies have to stand there.
            self._system.resume(saved)
            outcome = self._steps_to(first + 1 + ending.row)
        batch = self._batch(outcome, ending)
        slow = context.interruption.anywhere(time.perf_counter() - began > LONGEST_BATCH)
        more = max(1, self._at_once // 4) if slow else 2 * self._at_once
        self._at_once = min(more, STEPS_AT_ONCE)
        return batch

    def rest(self, context: RunContext, *, completed: bool) -> Batch:
        """A last, shorter step where the end is no multiple of the step."""
        end, left = self._span.end, self._span.end - self.time
        if not completed or left <= self._span.smallest * (1 - 1e-9):
            return Batch(np.empty((0, len(self._system.columns))))
        outcome = self._advance(left, np.array([self.time, end]))
        ending = None if outcome.failure else context.watch.look(outcome.rows)
        return self._batch(outcome, ending)

    def _next_stop(self, context: RunContext, due: float) -> int:
        """Number of the step at which a snapshot is due, s, or the run can be interrupted."""
        first, snapshot = self.steps, due / self._span.step * (1 - 1e-12)
        kept = context.files.schedule.next_step(first)
        return math.ceil(min(max(snapshot, first + 1), first + self._at_once, self._total, kept))

    def _steps_to(self, stop: int) -> Advance:
        """The steps up to number `stop`."""
        numbers = np.arange(self.steps, stop + 1, dtype=np.float64)
        return self._advance(self._span.step, numbers * self._span.step)

    def _advance(self, step: float, times: Array) -> Advance:
        """Steps of a length, s, whose ends have times, that of their start first."""
        ground = mean = None
        if self._motion.moves:
            ground, mean = self._motion.acceleration(times), self._motion.means(times)
        smallest = min(self._span.smallest, step)
        outcome = self._system.advance(len(times) - 1, step, ground, smallest, mean)
        outcome.rows[:, TIME] = times[1 : 1 + len(outcome.rows)]
        return outcome

    def _batch(self, outcome: Advance, ending: Ending | None) -> Batch:
        """Count steps that were taken, log those that were halved, and hand over what they left."""
        rows = outcome.rows
        self.steps += len(rows)
        if len(rows):
            self.time = float(rows[-1, TIME])
        self._rejected += outcome.rejected
        self._iterations += int(rows[:, ITERATIONS].sum())
        self._unsettled += outcome.unsettled
        self._largest_defect = max(self._largest_defect, self._system.largest_defect)
        if outcome.rejected:
            self._log(f"{outcome.rejected} steps halved before t = {self._system.time:.6g} s")
        # What was met in a step that was not finished is no part of the run.
        met = [m for m in outcome.met if m.time_s <= self.time * (1 + 1e-9)]
        reason = ending.reason if ending else outcome.failure or ""
        failed = ending is None and outcome.failure is not None
        return Batch(rows, met, outcome.events, outcome.pairs, reason, failed=failed)

    def contacts(self) -> Contacts:
        """The deepest overlap, and the steps without a solution, of the whole run."""
        return Contacts(self._system.deepest, self._unsettled, self._largest_defect)

    def cost(self) -> dict[str, Any]:
        """Counts of steps, iterations and unknowns of the run."""
        return {
            "steps": self.steps,
            "rejected_steps": self._rejected,
            "newton_iterations": self._iterations,
            "factorizations": 0,
            "unknowns": self._system.unknowns,
            "ranks": self._ranks,
            "local_problems_rescued": self._system.rescued,
        }
