"""The files that a run leaves in its folder, written as it goes."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, Literal, Protocol, TextIO

from solver.errors import OutputTrouble
from solver.excitation.motion import GroundMotion
from solver.fields.vtu import FieldsBefore
from solver.history.events import NAME as EVENTS
from solver.history.events import events_text
from solver.history.history import History
from solver.history.pairs import NAME as PAIRS
from solver.history.pairs import PairTable
from solver.parallel import Comm, Single, on_first_rank
from solver.results.summary import write_json, write_whole
from solver.run.checkpoint import NAME, Checkpoint, Schedule, write_checkpoint
from solver.run.folders import hold_folder, refuse_hidden, release_folder
from solver.scene import Scene, scene_to_toml

PAUSE = 1.0
"""Seconds for which rows may wait to be written."""


class Fields(Protocol):
    """Writer of the fields of a run; collective."""

    def write(self, time: float) -> None:
        """Write the fields as they are at a time (s)."""


class RunFiles:
    """Scene, history, log, fields and summary; nothing at all without a folder.

    Rank 0 writes all but the fields. Rows are written with every snapshot; on one rank they also
    wait no longer than a second, or until a step that takes longer is over. So a killed run leaves
    what it had.
    """

    def __init__(
        self,
        scene: Scene,
        folder: Path | None,
        comm: Comm,
        log: Callable[[str], None] | None,
        resumed: Checkpoint | None = None,
    ):
        """Open the folder and its log."""
        if folder is not None:
            refuse_hidden(folder)
        self._scene, self._folder, self._comm, self._also = scene, folder, comm, log
        self._resumed = resumed
        self.schedule = Schedule(scene.output.checkpoint if folder is not None else None, comm)
        self._own = folder if comm.rank == 0 else None
        """The folder on the rank that writes there."""
        self._history: History | None = None
        self._pairs: PairTable | None = None
        self._fields: Fields | None = None
        self._taken: float | None = None
        self._flushed = -math.inf
        self._began = time.perf_counter()
        self._log: TextIO | None = None
        self.output_seconds = 0.0
        on_first_rank(comm, self._open)

    def _open(self) -> None:
        """Make the folder, write what is run, begin the log."""
        if self._folder is None:
            return
        hold_folder(self._folder)
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            self._write_scene(self._folder / "scene.toml")
            mode: Literal["w", "a"] = "w" if self._resumed is None else "a"
            self._log = (self._folder / "run.log").open(mode, encoding="utf-8", buffering=1)
        except OSError as error:
            raise self._trouble(error) from error

    def _write_scene(self, file: Path) -> None:
        """Write what is run; the file of a run that goes on is the old one or the new one."""
        text = scene_to_toml(self._scene)
        if self._resumed is None or file.read_text(encoding="utf-8") != text:  # of another end
            write_whole(file, text)

    def __enter__(self) -> RunFiles:
        """The files are open already."""
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: object) -> None:
        """Write what is still in memory, whatever happened."""
        try:
            if error is None:
                self.flush()
            else:
                self.log(f"stopped by {kind.__name__ if kind else ''}: {error}")
                with suppress(OSError, OutputTrouble):
                    if self._comm.size == 1:
                        self.flush()
                    else:  # the other ranks may not be here
                        self._write_rows()
        finally:
            if self._log is not None:
                with suppress(OSError):
                    self._log.close()
            if self._own is not None:
                release_folder(self._own)

    def _write_rows(self) -> None:
        """Write the rows that are not in the file yet."""
        if self._history is not None:
            self._history.flush()
            if self._pairs is not None:
                self._pairs.flush()
            if self._own is not None and self._history.events is not None:
                write_whole(self._own / EVENTS, events_text(self._history.events))

    def _together(self, action: Callable[[], None]) -> None:
        """Write something, each rank its part, in time that counts as output; collective.

        Raises:
            OutputTrouble: One of them could not; on every rank alike.
        """
        began, trouble = time.perf_counter(), None
        try:
            action()
        except OSError as error:
            trouble = self._trouble(error)
        everyone = [trouble] if isinstance(self._comm, Single) else self._comm.allgather(trouble)
        self.output_seconds += time.perf_counter() - began
        found = next((one for one in everyone if one is not None), None)
        if found is not None:
            raise found

    def _trouble(self, error: OSError) -> OutputTrouble:
        """Error of the system, with the time up to which the history is written."""
        until = math.nan if self._history is None else self._history.written_to
        return OutputTrouble.of(error, "" if math.isnan(until) else f"up to t = {until:.6g} s")

    @property
    def history_file(self) -> Path | None:
        """File of the history on rank 0; None elsewhere, and without a folder."""
        return None if self._own is None else self._own / "history.csv"

    def open_history(self, columns: Sequence[str]) -> History:
        """The empty history of the run, with its file on rank 0; collective."""

        def begin() -> None:
            self._history = History(columns, self.history_file)

        if self._resumed is None or self._folder is None:
            self._together(begin)
        else:  # rank 0 has the file, the others take its rows
            rows, file = self._resumed.rows, self._folder / "history.csv"
            found = on_first_rank(self._comm, lambda: History.resumed(columns, file, rows))
            found.file = self.history_file
            self._history = found
        assert self._history is not None
        return self._history

    def open_pairs(self, names: Sequence[str]) -> PairTable:
        """The table of pairs of bodies, whose names are by their numbers; collective."""
        file = None if self._own is None else self._own / PAIRS
        self._pairs = table = PairTable(file, names, self._scene.dimension)
        until = None if self._resumed is None else self._resumed.time * (1 + 1e-12)
        self._together(lambda: table.begin(until))
        return table

    def log(self, line: str) -> None:
        """One line into run.log, with the seconds since the start, if there is room for it."""
        if self._log is not None:
            with suppress(OSError):
                self._log.write(f"{time.perf_counter() - self._began:10.3f} s  {line}\n")
        if self._also is not None:
            self._also(line)

    def start(self, fields: Callable[[Path, FieldsBefore], Fields], description: str) -> None:
        """Log the run; open and write the fields of t = 0 where they are requested."""
        self.log(description)
        folder, resumed, before = self._folder, self._resumed, FieldsBefore()
        if folder is None:
            return
        if resumed is not None:
            before = FieldsBefore(resumed.part, resumed.time * (1 + 1e-12))
            self._taken = resumed.time

        def begin() -> None:
            if resumed is not None and self._own is not None:
                # That of the part before, of which the run has read all by now.
                (self._own / "summary.json").unlink(missing_ok=True)
            if self._scene.output.fields != "none":
                self._fields = fields(folder, before)

        self._together(begin)
        if self._fields is not None:
            self.snapshot(0.0 if resumed is None else resumed.time)

    def next_snapshot(self, now: float) -> float:
        """The first time after `now` (s) at which a snapshot is due; never without a folder."""
        if self._folder is None:
            return math.inf
        every = self._scene.output.snapshot_time(self._scene.time.end)
        return (math.floor(now / every + 1e-9) + 1) * every

    def snapshot(self, now: float) -> None:
        """Write the fields at a time (s), once; collective."""
        if self._folder is None or self._taken == now:
            return
        fields, self._taken = self._fields, now
        if self._comm.size > 1 or fields is not None:
            self.flush()  # where there is no room for fields, there is for rows beside them
        if fields is not None:
            self._together(lambda: fields.write(now))

    @property
    def late(self) -> bool:
        """True if rows may have waited long to be written; never on several ranks."""
        files = self._folder is not None and self._comm.size == 1
        return files and time.perf_counter() - self._flushed >= PAUSE

    def flush(self) -> None:
        """Write the rows that wait; collective."""
        if self._folder is not None:
            self._together(self._write_rows)
            self._flushed = time.perf_counter()

    def keep(self, ground: GroundMotion, now: float, saved: Any) -> None:
        """Write a checkpoint of what was saved at a time, s; collective."""
        folder = self._folder
        if folder is None or self._history is None:
            return
        self.flush()
        part = 1 if self._resumed is None else self._resumed.part
        kept = Checkpoint(now, len(self._history), part, saved)
        self._together(
            lambda: write_checkpoint(folder / NAME, self._scene, ground, kept, self._comm)
        )

    def finish(self, summary: dict[str, Any], line: str) -> None:
        """Write the summary, after all rows and fields; collective."""
        self.log(line)

        def write() -> None:
            if self._own is not None:
                write_json(self._own / "summary.json", summary)

        self._together(write)
