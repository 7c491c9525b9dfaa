"""The history of a run: one row a step, and, on request, a CSV file of them."""

from __future__ import annotations

import math
import os
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import IO

import numpy as np
from numpy.typing import NDArray

from solver.errors import SceneError, of_file
from solver.history.columns import columns
from solver.history.events import NAME as EVENTS
from solver.history.events import Event, read_events
from solver.scene import Scene
from solver.scene.checking import nearest

#: Rows that become text in one go.
CHUNK = 256

#: Rows of memory that are taken in one go. A table that doubles would be copied, and its old
#: copies stay with the process.
BLOCK = 4096


def scene_columns(scene: Scene) -> tuple[str, ...]:
    """Names of all columns of the history of a scene, in their order.

    The deck of a frame moves as a platform does: its columns are those of a platform.
    """
    motion = scene.motion
    return columns(
        [block.name for block in scene.blocks],
        dimension=scene.dimension,
        platform=scene.carrier_moves,
        vertical=motion is not None and motion.vertical is not None,
        second=motion is not None and motion.second is not None,
        structure=scene.foundation.structure(scene.dimension),
        links={link.name: not link.is_axial for link in scene.links},
        feet={block.name: block.shape.feet for block in scene.blocks},
    )


class History:
    """A table that grows by rows; `history["time_s"]` is one of its columns.

    Rows reach the file by `flush`, with all their digits (%.17g), so that a history which is read
    back is the same to the last bit. What is not known is nan. Rows that have reached the file lie
    in a nameless file beside it until they are read, so that long runs take no more memory than
    short ones; without a file all rows are kept in memory.
    """

    def __init__(self, columns: Sequence[str], file: Path | None = None):
        """Start an empty history and its CSV file, over an old one; None: in memory only."""
        self.columns = tuple(columns)
        self.file = file
        self._index = {name: i for i, name in enumerate(self.columns)}
        if len(self._index) != len(self.columns):
            raise ValueError("two columns have the same name")
        self._blocks: list[NDArray[np.float64]] = []
        self._shelf: IO[bytes] | None = None
        self._shelved = 0
        self._length = 0
        self._written = 0
        self.events: tuple[Event, ...] | None = None
        """Events that its run recorded, by their times; None: nothing was recorded."""
        if file is not None:
            try:
                file.write_text(",".join(self.columns) + "\n", encoding="utf-8")
            except OSError as error:
                raise of_file(error, file) from error

    def __len__(self) -> int:
        """Number of rows."""
        return self._length

    def __iter__(self) -> Iterator[str]:
        """The names of the columns, in their order."""
        return iter(self.columns)

    def __contains__(self, column: object) -> bool:
        """True if there is a column of that name."""
        return column in self._index

    def __getitem__(self, column: str) -> NDArray[np.float64]:
        """One column, over all rows.

        Raises:
            KeyError: There is no such column; names the nearest one.
        """
        if not isinstance(column, str):
            raise TypeError(f"a history is read by the name of a column, not by {column!r}")
        if column not in self._index:
            meant = nearest(column, self.columns)
            raise KeyError(f"{column}, no column{f', but {meant} is one' if meant else ''}")
        values, place = np.empty(self._length), self._index[column]
        for first, block in zip(range(0, self._length, BLOCK), self._blocks, strict=False):
            part = values[first : first + BLOCK]
            part[:] = block[: len(part), place]
        return values

    def append(self, row: Sequence[float] | NDArray[np.float64]) -> None:
        """Add a row: one value for each column, in their order."""
        # numpy would spread a single value over the row.
        if len(row) != len(self.columns):
            raise ValueError(f"got {len(row)} values for {len(self.columns)} columns")
        self._room()[0] = row
        self._length += 1

    def extend(self, rows: NDArray[np.float64]) -> None:
        """Add many rows at once, (n, number of columns)."""
        if rows.ndim != 2 or rows.shape[1] != len(self.columns):
            raise ValueError(f"got rows of shape {rows.shape} for {len(self.columns)} columns")
        while len(rows):
            room = self._room()[: len(rows)]
            room[:] = rows[: len(room)]
            self._length += len(room)
            rows = rows[len(room) :]

    def _room(self) -> NDArray[np.float64]:
        """The free rows of the last block, at least one."""
        number, used = divmod(self._length, BLOCK)
        if number == len(self._blocks):
            self._blocks.append(np.empty((BLOCK, len(self.columns))))
        return self._blocks[number][used:]

    def flush(self) -> None:
        """Write the rows that are not in the file yet."""
        if self.file is None or self._written == self._length:
            return
        line = ",".join(["%.17g"] * len(self.columns)) + "\n"
        with self.file.open("ab", buffering=0) as stream:
            while self._written < self._length:
                number, first = divmod(self._written, BLOCK)
                last = min(first + CHUNK, self._length - number * BLOCK)
                part = self._blocks[number][first:last]
                text = (line * len(part) % tuple(part.ravel().tolist())).encode()
                before = stream.tell()
                try:
                    rest = memoryview(text)
                    while rest:
                        rest = rest[stream.write(rest) :]
                except OSError as error:
                    # Whole rows stay, so that what is there can be read.
                    kept = text[: stream.tell() - before].rfind(b"\n") + 1
                    os.truncate(self.file, before + kept)
                    self._written += text.count(b"\n", 0, kept)
                    raise of_file(error, self.file) from error
                self._written += len(part)

        self._shelve()

    def _shelve(self) -> None:
        """Take full blocks that are in the file out of memory; they are read from disk again."""
        assert self.file is not None
        full = self._written // BLOCK
        try:
            if self._shelf is None and self._shelved < full:
                self._shelf = tempfile.TemporaryFile(dir=self.file.parent)
            while self._shelf is not None and self._shelved < full:
                block = self._blocks[self._shelved]
                self._shelf.write(block.tobytes())
                self._shelf.flush()
                place, shape = self._shelved * block.nbytes, block.shape
                on_disk = np.memmap(self._shelf, np.float64, "r", place, shape)
                self._blocks[self._shelved] = on_disk
                self._shelved += 1
        except OSError:  # no space for a second copy: the rows stay in memory
            self._shelved = sys.maxsize

    @classmethod
    def resumed(cls, columns: Sequence[str], file: Path, rows: int) -> History:
        """The first rows of the history in a CSV file, which goes on behind them.

        Raises:
            SceneError: It has fewer rows, or other columns.
        """
        history = cls.read(file)
        if len(history) < rows or history.columns != tuple(columns):
            got = f"{len(history)} rows"
            raise SceneError(str(file), got, f"the {rows} rows that the run goes on from")
        with file.open("rb") as stream:
            end = sum(len(stream.readline()) for _ in range(rows + 1))
        os.truncate(file, end)
        history.file, history._length, history._written = file, rows, rows
        return history

    @property
    def written_to(self) -> float:
        """The time up to which rows are in the file, s; nan without any."""
        return float(self["time_s"][self._written - 1]) if self._written else math.nan

    @classmethod
    def read(cls, file: Path) -> History:
        """The history in a CSV file; its numbers are those that were written.

        A last line without an end is one that a killed run had not written yet: it is left out.
        """
        where = str(file)
        try:
            text = file.read_text(encoding="utf-8")
            head, *lines = text[: text.rfind("\n") + 1].splitlines() or [""]
            history = cls(head.split(",") if head else ())
            if lines:
                history.extend(np.loadtxt(lines, delimiter=",", ndmin=2))
            if (beside := file.with_name(EVENTS)).is_file():
                history.events = read_events(beside)
        except OSError as error:
            raise SceneError(
                where, got=error.strerror or "no file", allowed="a history.csv"
            ) from error
        except ValueError as error:
            raise SceneError(where, got=f"{error}", allowed="a history.csv of numbers") from error
        return history
