"""The files that a run leaves in its folder, written as it goes."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

from solver.history.history import History
from solver.parallel import Comm
from solver.results.summary import write_json
from solver.run.folders import refuse_hidden
from solver.scene import Scene, scene_to_toml


class Fields(Protocol):
    """What writes the fields of a run; collective."""

    def write(self, time: float) -> None:
        """Write the fields as they are at a time (s)."""

    def close(self) -> None:
        """Finish the files."""


class RunFiles:
    """Scene, history, log, fields and summary; nothing at all without a folder.

    Rank 0 writes all but the fields. The history is flushed with every snapshot, so that a killed
    run leaves what it had.
    """

    def __init__(
        self,
        scene: Scene,
        folder: Path | None,
        comm: Comm,
        log: Callable[[str], None] | None,
    ):
        """Open the folder and its log."""
        if folder is not None:
            refuse_hidden(folder)
        self._scene, self._folder, self._comm, self._also = scene, folder, comm, log
        self._writes = folder is not None and comm.rank == 0
        self._history: History | None = None
        self._fields: Fields | None = None
        self._written: float | None = None
        self._began = time.perf_counter()
        self.output_seconds = 0.0
        if self._writes and folder is not None:
            folder.mkdir(parents=True, exist_ok=True)
            (folder / "scene.toml").write_text(scene_to_toml(scene), encoding="utf-8")
            self._log = (folder / "run.log").open("w", encoding="utf-8", buffering=1)
        comm.Barrier()

    def __enter__(self) -> RunFiles:
        """The files are open already."""
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: object) -> None:
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

    def start(self, history: History, fields: Callable[[Path], Fields], description: str) -> None:
        """Say what is being run; open and write the fields of t = 0 where they are asked for."""
        self._history = history
        self.log(description)
        if self._folder is not None and self._scene.output.fields == "vtk":
            began = time.perf_counter()
            self._fields = fields(self._folder)
            self._fields.write(0.0)
            self._written = 0.0
            self.output_seconds += time.perf_counter() - began

    def next_snapshot(self, now: float) -> float:
        """The first time after `now` (s) at which a snapshot is due; never without a folder."""
        if self._folder is None:
            return math.inf
        every = self._scene.output.every
        return (math.floor(now / every + 1e-9) + 1) * every

    def snapshot(self, now: float) -> None:
        """Write fields and history at a time (s), once."""
        if self._folder is None or self._written == now:
            return
        began = time.perf_counter()
        self._written = now
        if self._fields is not None:
            self._fields.write(now)
        if self._history is not None:
            self._history.flush()
        self.output_seconds += time.perf_counter() - began

    def finish(self, summary: dict[str, Any], line: str) -> None:
        """Write the summary."""
        self.log(line)
        if self._writes and self._folder is not None:
            write_json(self._folder / "summary.json", summary)
