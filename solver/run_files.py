"""The files that a run leaves in its folder, written as it goes."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import Any

from mpi4py import MPI

import numpy as np

from solver.dynamics.state import State
from solver.dynamics.stepper import Stepper
from solver.post.history import History
from solver.post.summary import write_json
from solver.scene import Scene, scene_to_toml


class RunFiles:
    """Scene, history, log, fields and summary; nothing at all without a folder.

    Rank 0 writes all but the fields. The history is flushed with every snapshot, so that a killed
    run leaves what it had.
    """

    def __init__(
        self,
        scene: Scene,
        folder: Path | None,
        comm: MPI.Intracomm,
        log: Callable[[str], None] | None,
    ):
        """Open the folder and its log."""
        self._scene, self._folder, self._comm, self._also = scene, folder, comm, log
        self._writes = folder is not None and comm.rank == 0
        self._history: History | None = None
        self._fields: Any = None
        self._last = self._written = 0.0
        self._began = time.perf_counter()
        self.output_seconds = 0.0
        if self._writes and folder is not None:
            folder.mkdir(parents=True, exist_ok=True)
            (folder / "scene.toml").write_text(scene_to_toml(scene), encoding="utf-8")
            self._log = (folder / "run.log").open("w", encoding="utf-8", buffering=1)
        comm.Barrier()

    def __enter__(self) -> RunFiles:
        """Nothing more to open."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Write what is still in memory, whatever happened."""
        if self._history is not None:
            self._history.flush()
        if self._fields is not None:
            self._fields.close()
        if self._writes:
            if error is not None:
                self.log(f"stopped by {kind.__name__ if kind else ''}: {error}")
            self._log.close()

    @property
    def history_file(self) -> Path | None:
        """Where rank 0 writes the history."""
        return self._folder / "history.csv" if self._writes and self._folder is not None else None

    def log(self, line: str) -> None:
        """One line into run.log, with the seconds since the start."""
        if self._writes:
            self._log.write(f"{time.perf_counter() - self._began:10.3f} s  {line}\n")
        if self._also is not None:
            self._also(line)

    def start(self, stepper: Stepper, state: State, history: History) -> None:
        """Write the fields of t = 0 and say what is being run."""
        began = time.perf_counter()
        self._history = history
        body = stepper.body
        self.log(
            f"{body.unknowns} unknowns, ranks: {body.comm.size}, "
            f"{stepper.interface.points.count} contact points"
        )
        if self._folder is not None and self._scene.output.fields == "vtk":
            from solver.post.snapshots import Snapshots

            self._fields = Snapshots(stepper, self._folder)
            self._fields.write(state)
        self.output_seconds += time.perf_counter() - began

    def snapshot(self, state: State, *, last: bool = False) -> None:
        """Write fields and history where it is time to, and at the end if not just done."""
        every = self._scene.output.every
        due = int(np.floor(state.time / every + 1e-9)) > int(np.floor(self._last / every + 1e-9))
        self._last = state.time
        if self._folder is None or not (due or (last and self._written != state.time)):
            return
        began = time.perf_counter()
        self._written = state.time
        if self._fields is not None:
            self._fields.write(state)
        if self._history is not None:
            self._history.flush()
        self.output_seconds += time.perf_counter() - began

    def finish(self, summary: dict[str, Any], line: str) -> None:
        """Write the summary."""
        self.log(line)
        if self._writes and self._folder is not None:
            write_json(self._folder / "summary.json", summary)
