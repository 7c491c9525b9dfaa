"""Scenes with meshed bodies: the time loop over SNES."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from mpi4py import MPI

import numpy as np

from solver.build.assembly import Assembly, build, initial_state
from solver.errors import SceneError
from solver.excitation.motion import GroundMotion
from solver.fields.vtu import FieldsBefore
from solver.history.events import Meeting
from solver.history.history import scene_columns
from solver.parallel import any_rank
from solver.results.meetings import Contacts
from solver.resumable import Resumable
from solver.run.context import NO_PAIRS, Batch, RunContext
from solver.run.describe import damping_of_block
from solver.run.files import Fields
from solver.run.observer import Observer
from solver.run.pair_observer import PairObserver
from solver.scene import Scene
from solver.scheme.step_control import Ladder, Tolerance
from solver.stepping.contact_solve import StepFailed
from solver.stepping.local_error import Judge, LocalError
from solver.stepping.state import Exchange, State
from solver.types import Array


class _NextStep(NamedTuple):
    """A step that was looked ahead to: its start, its length (s), and what it gave."""

    start: State
    dt: float
    new: State
    exchange: Exchange


class MeshedRun(Resumable):
    """The engine of scenes with meshed bodies."""

    CARRIED = (
        *("state", "_stepper", "_ladder", "_judge", "_observer", "_pairs"),
        *("steps", "_iterations", "_damped", "_coarse"),
    )

    def __init__(
        self,
        scene: Scene,
        log: Callable[[str], None],
        ground: GroundMotion | None = None,
        *,
        petsc_options: Sequence[str] = (),
        comm: MPI.Intracomm = MPI.COMM_WORLD,
    ):
        """Mesh, set up, and find the start; read the motion of the ground where it is not given."""
        self._scene, self._log = scene, log
        self.assembly: Assembly = build(scene, ground, petsc_options=petsc_options, comm=comm)
        self._stepper = self.assembly.stepper
        self.state, remark = initial_state(scene, self.assembly)
        self.remarks: Sequence[str] = [remark] if remark else []
        names = scene_columns(scene)
        self._observer = Observer(self.assembly, self.state, names, scene.links)
        self._pairs: PairObserver | None = None
        told = scene.output.pairs or scene.output.fields != "none"
        if told or len(scene.blocks) > 1 or scene.blocks[0].position is not None:
            self._pairs = PairObserver(scene, self.assembly)
        self._last = Exchange(), scene.time.step
        """What the last step exchanged, and its length, s."""
        self.steps = self._iterations = 0
        self._damped = self._coarse = 0
        span = scene.time
        self._ladder = Ladder(span.step, span.end, span.smallest, span.largest)
        self._judge = None
        if scene.time.tolerance is not None:  # adaptive
            size = min(block.shape.half_diagonal for block in scene.blocks)
            error = LocalError(self._stepper.system, size)
            tolerance = Tolerance(scene.time.tolerance, scene.vibration_left)
            self._judge = Judge(error, tolerance, self.state)
        self._next: _NextStep | None = None
        points = sum(link.interface.count for link in self._stepper.links)
        self.description = (
            f"{self._stepper.system.unknowns} unknowns, ranks: {comm.size}, {points} contact points"
        )
        for block in scene.blocks:
            for _, text in damping_of_block(block, scene):
                log(f"damping of {block.name}: {text}")
        reduction = self.assembly.support.reduction
        if reduction is not None:
            unknowns, modes, nodes, left = reduction.in_words()
            log(f"foundation reduced to {unknowns}: modes {modes}, nodes {nodes}")
            log(f"modes left out {left}")

    def first_row(self) -> Array:
        """The row of the history at t = 0."""
        return self._observer.row(self.state, Exchange(), self._scene.time.step)

    def open_fields(self, folder: Path, before: FieldsBefore) -> Fields:
        """Writer of the fields, after those that an earlier part of the run has left."""
        from solver.fields.meshed_snapshots import Snapshots

        return Snapshots(self, folder, self._scene, before)

    @property
    def body_names(self) -> Sequence[str]:
        """Names of all bodies, by their numbers in pairs."""
        return () if self._pairs is None else self._pairs.names

    def pairs(self) -> Array:
        """What pairs of bodies did in the last step, as `World.pairs` of one step; collective."""
        assert self._pairs is not None
        return self._pairs.rows(self.state, *self._last)

    def saved(self) -> dict[str, Any]:
        """State of the run, for `resume`."""
        self._next = None  # solved anew, here as in a run that goes on from this
        return super().saved() | {"places": self._places}

    @property
    def _places(self) -> list[Array]:
        """Places of this rank's nodes in the undeformed mesh of each meshed body, (nodes, d), m."""
        return [body.nodes for body, _ in self._stepper.system.meshed]

    def resume(self, saved: Mapping[str, Any]) -> None:
        """Go on from where another engine of the same scene was saved; collective.

        Raises:
            SceneError: Gmsh or the partition is not that of the checkpoint.
        """
        same = all(map(np.array_equal, saved["places"], self._places))
        if any_rank(self._stepper.system.comm, not same):
            raise SceneError("--resume", "a checkpoint of another mesh", "that of this run")
        super().resume(saved)
        self._ladder.lead_to(self._scene.time.end)

    @property
    def time(self) -> float:
        """The time that the run has reached, s."""
        return self.state.time

    @property
    def done(self) -> bool:
        """True at the end."""
        return self._ladder.done

    def advance(self, context: RunContext, due: float) -> Batch:
        """One step, as long as convergence and accuracy allow."""
        ladder, judge = self._ladder, self._judge
        while True:
            step = ladder.step
            try:
                new, exchange = self._advance(self.state, step, ladder.then)
            except StepFailed as trouble:
                where = f"at t = {self.state.time:.6g} s with a step of {step:.3g} s"
                self._log(f"step rejected {where}: {trouble}")
                if ladder.reject():
                    continue
                return Batch(self._no_rows, reason=f"{where}: {trouble}", failed=True)
            coarse = judge is not None and not judge.accepts(new, step, self._following)
            if judge is not None and coarse and ladder.shorten(judge.halvings):
                continue
            ladder.accept(climb=judge is None or judge.climbs())
            self._coarse += coarse
            return self._take(context, new, exchange, step)

    def rest(self, context: RunContext, *, completed: bool) -> Batch:
        """The collisions that go on where the run ends."""
        return Batch(self._no_rows, () if self._pairs is None else self._pairs.rest())

    @property
    def _no_rows(self) -> Array:
        """No rows of the history."""
        return np.empty((0, len(self._observer.names)))

    def _advance(self, start: State, dt: float, end: float) -> tuple[State, Exchange]:
        """A step from a state to a time; one that was looked ahead to is not solved twice."""
        ahead, self._next = self._next, None
        if ahead and ahead.start is start and ahead.dt == dt:
            self._stepper.join(ahead.new.active)
            return ahead.new._replace(time=end), ahead.exchange
        return self._stepper.advance(start, dt, end)

    def _following(self, start: State, dt: float) -> State | None:
        """Look ahead to the state a step after another; None if the step fails.

        Active interfaces are those of the step before again: its row and fields are read by them.
        """
        try:
            new, exchange = self._stepper.advance(start, dt)
            self._next = _NextStep(start, dt, new, exchange)
        except StepFailed:
            return None
        finally:
            self._stepper.join(start.active)
        return new

    def _take(self, context: RunContext, new: State, exchange: Exchange, dt: float) -> Batch:
        """Go on from where a step of length dt (s) led."""
        self._damped += self.state.is_damped(dt)
        met: Sequence[Meeting] = ()
        if self._pairs is not None:
            met = self._pairs.step(self.state, new, exchange)
        happened = self._observer.link_events(self.state, new)
        self.state, self._last = new, (exchange, dt)
        pairs = self.pairs() if self._scene.output.pairs else NO_PAIRS
        self.steps += 1
        self._iterations += exchange.iterations
        rows = self._observer.row(new, exchange, dt)[None]
        ending = context.watch.look(rows)
        return Batch(rows, met, happened, pairs, "" if ending is None else ending.reason)

    def contacts(self) -> Contacts | None:
        """The deepest overlap of bodies that neither carries the other."""
        return None if self._pairs is None else self._pairs.contacts

    def cost(self) -> dict[str, Any]:
        """Counts of steps, iterations, factorizations and unknowns of the run."""
        stepper = self._stepper
        system = stepper.system
        bodies = [body for body, _ in system.meshed]
        return {
            "steps": self.steps,
            "rejected_steps": self._ladder.rejected,
            "damped_steps": self._damped,
            "coarse_steps": self._coarse,
            "newton_iterations": self._iterations,
            "factorizations": sum(body.factorizations for body in bodies),
            "linear_solvers": sorted({name for body in bodies for name in body.solvers}),
            "unknowns": system.unknowns,
            "ranks": system.comm.size,
            "local_problems_rescued": dict(stepper.local.fallbacks),
        }
