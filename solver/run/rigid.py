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
from solver.history.columns import positions
from solver.history.history import scene_columns
from solver.history.pairs import PairTable, kept_pairs
from solver.results.meetings import Contacts
from solver.rigid.system import Advance, RigidSystem
from solver.run.context import RunContext
from solver.scene import Scene
from solver.types import Array

#: Most steps between two times at which the run can be interrupted.
STEPS_AT_ONCE = 500

#: Wall time of steps at once above which there are fewer the next time, s; else there are more.
LONGEST_BATCH = 0.5


class RigidRun:
    """The engine of scenes with rigid bodies alone."""

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
        self._motion = ground or read_ground(scene)
        self._at_once = 1
        self._system = RigidSystem(scene)
        if scene.output.pairs or scene.output.fields != "none":
            self._system.tell_pairs(every=scene.output.pairs)
        # What the scene does not have gets no columns in its history.
        self._run_columns = positions("run", scene.dimension)
        self._columns = [self._system.columns.index(name) for name in scene_columns(scene)]
        self._steps = self._rejected = self._iterations = 0
        self._now = 0.0
        self._row: Array | None = None
        """The last row, unless the history holds it."""
        self._pairs: PairTable | None = None
        self._unsettled = 0
        self._largest_defect = 0.0
        self.description = f"{self._system.unknowns} unknowns, {len(scene.blocks)} rigid blocks"

    def first_row(self) -> Array:
        """The row of the history at t = 0."""
        ground = tuple(self._motion.acceleration(0.0))
        return self._system.row(self._scene.time.step, ground)[self._columns]

    def open_fields(self, folder: Path, before: FieldsBefore) -> RigidSnapshots:
        """Writer of the fields, after those that an earlier part of the run has left."""
        return RigidSnapshots(self._system, folder, self._scene, writes=self._writes, before=before)

    def saved(self) -> dict[str, Any]:
        """State of the run, for `resume`."""
        return {
            "system": self._system.saved(),
            "counts": (self._steps, self._rejected, self._iterations),
            "row": self._row,
            "unsettled": (self._unsettled, self._largest_defect),
        }

    def resume(self, saved: dict[str, Any]) -> None:
        """Go on from where another engine of the same scene was saved."""
        self._system.restore(saved["system"])
        self._steps, self._rejected, self._iterations = saved["counts"]
        self._now, self._row = self._steps * self._scene.time.step, saved["row"]
        self._unsettled, self._largest_defect = saved["unsettled"]

    def loop(self, context: RunContext) -> tuple[str, str]:
        """Step to the end; returns status and reason."""
        span = self._scene.time
        total = math.floor(span.end / span.step + 1e-9)
        status, reason = "completed", ""
        if self._scene.output.pairs:
            self._pairs = context.files.open_pairs(self._system.body_names)
            if not self._steps:
                self._pairs.add(np.zeros(1), self._system.pairs)
        while self._steps < total and not reason:
            reason = context.stopped(self._steps * span.step)
            if reason:
                status = "interrupted"
                context.keep(self, self._steps, self._steps * span.step, ends=True)
                break
            began = time.perf_counter()
            status, reason = self._piece(context, self._next_stop(context, total))
            slow = context.interruption.anywhere(time.perf_counter() - began > LONGEST_BATCH)
            more = max(1, self._at_once // 4) if slow else 2 * self._at_once
            self._at_once = min(more, STEPS_AT_ONCE)
            if not reason:
                context.keep(self, self._steps, self._steps * span.step)
        if not reason:
            context.keep(self, self._steps, self._steps * span.step, ends=True)
            status, reason = self._rest(context)
        if self._row is not None:
            context.history.append(self._row)
            self._row = None
            self._tell_pairs(np.array([self._now]), self._system.pairs)
        context.files.snapshot(self._now)
        return status, reason

    def _next_stop(self, context: RunContext, total: int) -> int:
        """Number of the step at which a snapshot is due next, or the run can be interrupted."""
        step, first = self._scene.time.step, self._steps
        due = context.files.next_snapshot(first * step) / step * (1 - 1e-12)
        kept = context.files.schedule.next_step(first)
        return math.ceil(min(max(due, first + 1), first + self._at_once, total, kept))

    def _piece(self, context: RunContext, stop: int) -> tuple[str, str]:
        """Run up to step number `stop`; returns status and, where the run ends, the reason."""
        step, first = self._scene.time.step, self._steps
        saved = self._system.saved() if context.watch.ends_runs else None
        outcome = self._steps_to(stop)
        status, reason = "completed", ""
        found = context.watch.look(outcome.rows[:, self._columns]) if len(outcome.rows) else None
        if found is not None and saved is not None:
            # Once more, up to the step with which the run ends: the bodies have to stand there.
            self._system.restore(saved)
            outcome, reason = self._steps_to(first + 1 + found.row), found.reason
        elif outcome.failure:
            status, reason = "not converged", outcome.failure
        self._keep(context, outcome)
        self._report(context, outcome)
        due = context.files.next_snapshot(first * step)
        if self._steps * step >= due * (1 - 1e-12):
            context.files.snapshot(self._steps * step)
        return status, reason

    def _steps_to(self, stop: int) -> Advance:
        """The steps up to number `stop`."""
        step, first = self._scene.time.step, self._steps
        ground = self._shaking(np.arange(first, stop + 1, dtype=np.float64) * step)
        outcome = self._advance(stop - first, step, ground)
        count = len(outcome.rows)
        outcome.rows[:, self._run_columns.time_s] = np.arange(first + 1, first + 1 + count) * step
        return outcome

    def _shaking(self, times: Array) -> tuple[Array, Array] | None:
        """Accelerations of the ground at times, s, and mean ones between them; None: at rest."""
        if not self._motion.moves:
            return None
        return self._motion.acceleration(times), self._motion.means(times)

    def _rest(self, context: RunContext) -> tuple[str, str]:
        """A last, shorter step where the end is no multiple of the step."""
        span = self._scene.time
        reached = self._steps * span.step
        rest = span.end - reached
        if rest <= span.smallest * (1 - 1e-9):
            return "completed", ""
        outcome = self._advance(1, rest, self._shaking(np.array([reached, span.end])))
        outcome.rows[:, self._run_columns.time_s] = span.end
        self._keep(context, outcome)
        self._report(context, outcome)
        if outcome.failure:
            return "not converged", outcome.failure
        found = context.watch.look(outcome.rows[:, self._columns])
        return "completed", "" if found is None else found.reason

    def _keep(self, context: RunContext, outcome: Advance) -> None:
        """Append the rows that the history holds; another one waits, since it may be the last."""
        rows = outcome.rows[:, self._columns]
        # What was met in a step that was not finished is no part of the run.
        reached = self._now if not len(rows) else float(outcome.rows[-1, self._run_columns.time_s])
        met = [m for m in outcome.met if m.time_s <= reached * (1 + 1e-9)]
        context.recorder.add(rows, met, outcome.events)
        number = np.arange(self._steps + 1, self._steps + 1 + len(rows))
        kept = number % self._scene.output.history_every == 0
        context.history.extend(rows[kept])
        self._steps += len(rows)
        if len(rows):
            self._now = float(outcome.rows[-1, self._run_columns.time_s])
            self._row = None if kept[-1] else rows[-1]
            times, pairs = outcome.rows[:, self._run_columns.time_s], outcome.pairs
            self._tell_pairs(times, kept_pairs(pairs, kept))
        self._unsettled += outcome.unsettled
        self._largest_defect = max(self._largest_defect, self._system.largest_defect)

    def _tell_pairs(self, times: Array, pairs: Array) -> None:
        """Write pairs at times, s, where they are told."""
        if self._pairs is not None:
            self._pairs.add(times, pairs)

    def _advance(self, count: int, step: float, ground: tuple[Array, Array] | None) -> Advance:
        """Run so many steps of length `step`; `ground`: accelerations at their ends, mean ones."""
        accelerations, mean = ground or (None, None)
        smallest = min(self._scene.time.smallest, step)
        return self._system.advance(count, step, accelerations, smallest, mean)

    def _report(self, context: RunContext, outcome: Advance) -> None:
        """Count, and log steps that were halved."""
        run = self._run_columns
        self._rejected += outcome.rejected
        self._iterations += int(outcome.rows[:, run.newton_iterations].sum())
        if outcome.rejected:
            self._log(f"{outcome.rejected} steps halved before t = {self._system.time:.6g} s")
        if len(outcome.rows):
            last = outcome.rows[-1]
            iterations = int(last[run.newton_iterations])
            context.show(float(last[run.time_s]), float(last[run.step_s]), iterations)

    def contacts(self) -> Contacts:
        """The deepest overlap, and the steps without a solution, of the whole run."""
        return Contacts(self._system.deepest, self._unsettled, self._largest_defect)

    def cost(self) -> dict[str, Any]:
        """Counts of steps, iterations and unknowns of the run."""
        return {
            "steps": self._steps,
            "rejected_steps": self._rejected,
            "newton_iterations": self._iterations,
            "factorizations": 0,
            "unknowns": self._system.unknowns,
            "ranks": self._ranks,
            "local_problems_rescued": self._system.rescued,
        }
