"""A scene from beginning to end: build, start, step, record, write."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from solver.errors import missing_key
from solver.excitation.motion import GroundMotion, read_ground
from solver.excitation.sampled import SampledMotion
from solver.history.history import History, scene_columns
from solver.info import versions
from solver.parallel import Comm, Single, on_first_rank, world
from solver.results.cautions import cautions_of_input
from solver.results.report import told_lines
from solver.results.summary import summarise
from solver.run.checkpoint import read_checkpoint
from solver.run.context import Engine, ProgressReport, RunContext
from solver.run.files import RunFiles
from solver.run.folders import renew_folder
from solver.run.interruption import Interruption
from solver.run.twin import horizon_beside, refuse_without_twin
from solver.scene import Scene
from solver.scene.checking import shown

Log = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class Result:
    """Result of a run."""

    status: str
    """"completed", "not converged" or "interrupted"."""
    history: History
    """One row a step; `history["block.angle_rad"]` is a numpy array."""
    summary: dict[str, Any]
    """The content of summary.json."""


def engine_for(
    scene: Scene,
    ground: GroundMotion,
    files: RunFiles,
    petsc_options: Sequence[str],
    comm: Comm,
) -> Engine:
    """The engine that a scene needs, set up and at its start."""
    if scene.is_rigid:  # then dolfinx, PETSc and Gmsh stay out of it
        from solver.run.rigid import RigidRun

        return RigidRun(scene, files.log, ground, writes=comm.rank == 0, ranks=comm.size)
    from solver.run.meshed import MeshedRun

    assert not isinstance(comm, Single)
    return MeshedRun(scene, files.log, ground, petsc_options=petsc_options, comm=comm)


def simulate(
    scene: Scene,
    *,
    folder: str | Path | None = None,
    petsc_options: Sequence[str] = (),
    progress: ProgressReport | None = None,
    log: Log | None = None,
    seconds: float | None = None,
    comm: Comm | None = None,
    ground: GroundMotion | None = None,
    resume: bool = False,
) -> Result:
    """Run a scene; collective on all ranks of `comm`.

    Args:
        scene: What to run.
        folder: Where to leave history, summary, fields, in place of those of an earlier run; None:
            no files.
        petsc_options: Options for SNES, with prefix `rockslip_`, such as
            ("-rockslip_snes_monitor",).
        progress: A display; on every rank.
        log: Called with each line of the log, which run.log gets as well.
        seconds: Wall time after which the run is stopped between two steps; None: never.
        comm: Communicator; None: all ranks of the command.
        ground: Motion of the ground, as it was read; None: it is read here, by rank 0, before
            anything is written.
        resume: Go on from the checkpoint in the folder, of this scene or one with an earlier end.

    Returns:
        The result; a run that cannot go on or is interrupted returns what it has, and says so.

    Raises:
        TypeError: `scene` is not a `Scene`.
        RockslipError: The request cannot be run, or its results cannot be written.
    """
    began = time.perf_counter()
    folder = None if folder is None else Path(folder)
    _refuse(scene, folder, petsc_options, resume=resume)
    if comm is None:
        comm = world(meshed=not scene.is_rigid)
    if ground is None:
        ground = read_ground(scene, comm)
    resumed = None
    if folder is not None and resume:
        resumed = read_checkpoint(folder, scene, ground, comm)
    elif folder is not None:
        on_first_rank(comm, partial(renew_folder, folder))
    with (
        ExitStack() as stack,
        RunFiles(scene, folder, comm, log, resumed) as files,
        Interruption(comm, seconds) as interruption,
    ):
        if progress is not None:
            stack.callback(progress.close)
        engine = engine_for(scene, ground, files, petsc_options, comm)
        history = files.open_history(scene_columns(scene))
        context = RunContext(scene, history, files, interruption, progress, ground)
        cautions = [*engine.remarks, *cautions_of_input(scene, ground)]
        for where, part in zip(scene.directions, ground.parts, strict=True):
            if isinstance(part, SampledMotion) and part.source:
                files.log(f"{where}: {part.source}")
        for text in cautions:
            files.log(f"caution: {text}")
        context.begin(engine, resumed)
        files.start(engine.open_fields, engine.description)
        ready, written = time.perf_counter(), files.output_seconds
        status, reason = context.loop(engine)
        stepped = time.perf_counter() - ready - (files.output_seconds - written)
        cost = {
            "wall_s": stepped,
            "setup_s": ready - began - written,
            "output_s": files.output_seconds,
            **engine.cost(),
        }
        summary = summarise(
            scene,
            history,
            status=status,
            cost=cost,
            versions=versions(),
            reason=reason,
            cautions=cautions,
            ground=ground,
            contacts=engine.contacts(),
        )
        if scene.output.twin and status == "completed":
            until = None if seconds is None else began + seconds
            twin = partial(_twin, comm=comm, until=until, petsc_options=petsc_options)
            summary["horizon"] = horizon_beside(scene, history, twin)
        for line in told_lines(summary):
            files.log(line)
        files.finish(summary, f"{status}{': ' if reason else ''}{reason}")
    return Result(status, history, summary)


def _refuse(scene: Scene, folder: Path | None, options: Sequence[str], *, resume: bool) -> None:
    """Refuse what cannot be run, before anything is written."""
    if not isinstance(scene, Scene):
        raise TypeError(f"simulate takes a Scene, as of load_scene(file), not {shown(scene)}")
    if resume and folder is None:
        raise missing_key("folder", "(that of the run that goes on)")
    if scene.output.twin:
        refuse_without_twin(scene)
    if options:
        from solver.stepping.nonlinear import check_options

        check_options(options)


def _twin(
    scene: Scene, *, comm: Comm, until: float | None, petsc_options: Sequence[str]
) -> tuple[str, History]:
    """Status and history of a twin, without files, up to a time of the performance counter, s."""
    left = None if until is None else until - time.perf_counter()
    alike: dict[str, Any] = {"comm": comm, "petsc_options": petsc_options}
    run = simulate(scene, seconds=left, **alike)
    return run.status, run.history
