"""A scene from beginning to end: build, start, step, record, write."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from mpi4py import MPI

import numpy as np

from geometry.arrangement import initial_position
from geometry.foundation import RigidFoundation
from geometry.mesh import block_mesh
from solver.contact.faces import ContactFaces
from solver.dynamics.generalized_alpha import GeneralizedAlpha
from solver.dynamics.state import Exchange, State
from solver.dynamics.step_control import Ladder
from solver.dynamics.stepper import StepFailed, Stepper
from solver.excitation.motion import base_motion
from solver.info import versions
from solver.interruption import Interruption
from solver.mechanics.elastic_body import Damping, ElasticBody
from solver.mechanics.material import Material
from solver.post.history import History, columns
from solver.post.observer import Observer
from solver.post.summary import summarise
from solver.run_files import RunFiles
from solver.scene import Scene

Log = Callable[[str], None]


class ProgressReport(Protocol):
    """What a progress display understands."""

    def update(self, time: float, step: float, iterations: int) -> None:
        """A step of length `step` ended at `time`."""

    def close(self) -> None:
        """The run ended."""


@dataclass(frozen=True, slots=True)
class Result:
    """What a run gives.

    Attributes:
        status: "completed", "not converged" or "interrupted".
        history: One row a step; `history["block.angle_rad"]` is a numpy array.
        summary: The content of summary.json.
    """

    status: str
    history: History
    summary: dict[str, Any]


def build(
    scene: Scene, *, petsc_options: Sequence[str] = (), comm: MPI.Intracomm = MPI.COMM_WORLD
) -> Stepper:
    """Mesh the block of a scene and set its solver up."""
    spec = scene.blocks[0]
    mesh = block_mesh(
        spec.shape, cells=spec.cells, cell=spec.cell, refinement=spec.refinement, comm=comm
    )
    material = Material(
        young=spec.young, poisson=spec.poisson, density=spec.shape.density, plane=scene.plane
    )
    given = scene.damping
    damping = None if given is None else Damping(mass=given.mass, stiffness=given.stiffness)
    body = ElasticBody(mesh.mesh, material, degree=spec.degree, damping=damping)
    contact = scene.contact
    faces = ContactFaces(
        body.space,
        mesh.facet_tags,
        material,
        RigidFoundation(),
        points=contact.points,
        gamma=contact.gamma,
        friction=contact.friction,
        theta=contact.theta,
    )
    motion = base_motion(scene.motion, scene.time.end)
    return Stepper(
        body,
        faces,
        GeneralizedAlpha(scene.time.rho_inf),
        gravity=np.array(scene.gravity_vector),
        base_acceleration=None
        if motion is None
        else lambda t: np.array([motion.acceleration(t), 0.0]),
        velocity_solve=contact.velocity_solve,
        petsc_options=petsc_options,
    )


def initial_state(scene: Scene, stepper: Stepper, log: Log) -> State:
    """Where the block stands at t = 0: in equilibrium where it begins closed, else unstressed."""
    spec, nodes = scene.blocks[0], stepper.body.nodes
    u = (initial_position(spec.shape, spec.offset, spec.tilt)(nodes) - nodes).ravel()
    if scene.time.initial == "static" and spec.tilt == 0.0:
        try:
            return stepper.static_start(u)
        except StepFailed as trouble:
            log(f"no static equilibrium ({trouble}): starting unstressed")
    return stepper.start(u, np.zeros_like(u))


def simulate(
    scene: Scene,
    *,
    folder: Path | None = None,
    petsc_options: Sequence[str] = (),
    progress: ProgressReport | None = None,
    log: Log | None = None,
    comm: MPI.Intracomm = MPI.COMM_WORLD,
) -> Result:
    """Run a scene; collective on `comm`.

    Args:
        scene: What to run.
        folder: Where to leave history, summary, fields; None: no files.
        petsc_options: Options for SNES, with prefix `rockslip_`, such as
            ("-rockslip_snes_monitor",).
        progress: A display; on every rank.
        log: Is told what happens, line by line, besides run.log.
        comm: Communicator.

    Returns:
        The result; a run that cannot go on or is interrupted returns what it has, and says so.
    """
    began = time.perf_counter()
    with (
        ExitStack() as stack,
        RunFiles(scene, folder, comm, log) as files,
        Interruption(comm) as interruption,
    ):
        if progress is not None:
            stack.callback(progress.close)
        stepper = build(scene, petsc_options=petsc_options, comm=comm)
        state = initial_state(scene, stepper, files.log)
        observer = Observer(stepper, state, scene.blocks[0].thickness)
        history = History(columns([b.name for b in scene.blocks]), files.history_file)
        files.start(stepper, state, history)
        history.append(observer.row(state, Exchange(), scene.time.step))
        run = _Run(scene, stepper, files, interruption, observer, history, progress)
        ready, written = time.perf_counter(), files.output_seconds
        status, reason = run.loop(state)
        loop = time.perf_counter() - ready - (files.output_seconds - written)
        cost = run.cost(ready - began - written, loop)
        summary = summarise(
            scene, history, status=status, cost=cost, versions=versions(), reason=reason
        )
        files.finish(summary, f"{status}{': ' if reason else ''}{reason}")
    return Result(status, history, summary)


@dataclass(slots=True)
class _Run:
    """The time loop and what it counts."""

    scene: Scene
    stepper: Stepper
    files: RunFiles
    interruption: Interruption
    observer: Observer
    history: History
    progress: ProgressReport | None
    steps: int = 0
    rejected: int = 0
    iterations: int = 0
    row: list[float] = field(default_factory=list)

    def loop(self, state: State) -> tuple[str, str]:
        """Step to the end; returns status and reason."""
        span = self.scene.time
        ladder = Ladder(span.step, span.end, span.smallest)
        status, reason = "completed", ""
        while not ladder.done:
            if self.interruption.requested():
                who = self.interruption.signal_name
                status, reason = "interrupted", f"stopped by {who} at t = {state.time:.6g} s"
                break
            step = ladder.step
            try:
                state, exchange = self.stepper.advance(state, step)
            except StepFailed as trouble:
                where = f"at t = {state.time:.6g} s with a step of {step:.3g} s"
                self.files.log(f"step rejected {where}: {trouble}")
                if ladder.reject():
                    continue
                status, reason = "not converged", f"{where}: {trouble}"
                break
            ladder.accept()
            state.time = ladder.time
            self._record(state, exchange, step)
        self.rejected = ladder.rejected
        self._last_row()
        self.files.snapshot(state, last=True)
        return status, reason

    def _record(self, state: State, exchange: Exchange, step: float) -> None:
        """Write down a step that succeeded."""
        self.steps += 1
        self.iterations += exchange.iterations
        self.row = self.observer.row(state, exchange, step)
        if self.steps % self.scene.output.history_every == 0:
            self._last_row()
        self.files.snapshot(state)
        if self.progress is not None:
            self.progress.update(state.time, step, exchange.iterations)

    def _last_row(self) -> None:
        """Append the row of the last step, once."""
        if self.row:
            self.history.append(self.row)
            self.row = []

    def cost(self, setup: float, loop: float) -> dict[str, Any]:
        """What the run took."""
        body, local = self.stepper.body, self.stepper.local
        rescues = Counter(local.rescues) + self.stepper.velocity_local.rescues
        return {
            "wall_s": loop,
            "setup_s": setup,
            "output_s": self.files.output_seconds,
            "steps": self.steps,
            "rejected_steps": self.rejected,
            "newton_iterations": self.iterations,
            "factorizations": body.factorizations,
            "unknowns": body.unknowns,
            "ranks": body.comm.size,
            "local_problems_rescued": dict(rescues),
        }
