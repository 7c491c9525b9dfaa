"""The history of a run: one row a step, kept in memory and, if asked for, in a CSV file."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from solver.errors import SceneError

#: Columns of the run as a whole.
RUN_COLUMNS = (
    "time_s",
    "step_s",
    "newton_iterations",
    "contact_points_closed",
    "base.acceleration_m_s2",
)

#: Columns of each block, written `NAME.column`.
BLOCK_COLUMNS = (
    "angle_rad",
    "angular_velocity_rad_s",
    "slip_m",
    "gap_left_m",
    "gap_right_m",
    "penetration_m",
    "centre_x_m",
    "centre_y_m",
    "normal_force_N",
    "friction_force_N",
)

#: Stored energies: their sum is `energy.total_J`.
STORED_ENERGIES = ("kinetic", "strain", "gravity", "spring", "interface")

#: What has been dissipated since the start, each from its own formula.
DISSIPATED_ENERGIES = ("friction", "damping", "contact", "numerical")

ENERGY_COLUMNS = tuple(
    f"energy.{name}_J"
    for name in (*STORED_ENERGIES, "input", *DISSIPATED_ENERGIES, "total", "ledger_error")
)


def columns(blocks: Sequence[str]) -> tuple[str, ...]:
    """Names of all columns of the history of a scene with these blocks, in their order."""
    of_blocks = tuple(f"{block}.{column}" for block in blocks for column in BLOCK_COLUMNS)
    return RUN_COLUMNS + of_blocks + ENERGY_COLUMNS


class History:
    """A table that grows by rows; `history["time_s"]` is one of its columns.

    Rows reach the file by `flush`, with all their digits (%.17g), so that a history which is read
    back is the same to the last bit. What is not known is nan.
    """

    def __init__(self, columns: Sequence[str], file: Path | None = None):
        """Start an empty history, and its file.

        Args:
            columns: Names of the columns, the unit at the end of each name.
            file: CSV file to write, overwritten if it exists; None: memory only.
        """
        self.columns = tuple(columns)
        self.file = file
        self._index = {name: i for i, name in enumerate(self.columns)}
        if len(self._index) != len(self.columns):
            raise ValueError("two columns have the same name")
        self._rows: NDArray[np.float64] = np.empty((256, len(self.columns)))
        self._length = 0
        self._written = 0
        if file is not None:
            file.write_text(",".join(self.columns) + "\n", encoding="utf-8")

    def __len__(self) -> int:
        """Number of rows."""
        return self._length

    def __contains__(self, column: object) -> bool:
        """Whether there is a column of that name."""
        return column in self._index

    def __getitem__(self, column: str) -> NDArray[np.float64]:
        """One column, over all rows."""
        values: NDArray[np.float64] = self._rows[: self._length, self._index[column]]
        return values.copy()

    def append(self, row: Sequence[float] | NDArray[np.float64]) -> None:
        """Add a row: one value for each column, in their order."""
        if self._length == len(self._rows):
            self._rows = np.concatenate([self._rows, np.empty_like(self._rows)])
        # numpy would spread a single value over the row.
        if len(row) != len(self.columns):
            raise ValueError(f"got {len(row)} values for {len(self.columns)} columns")
        self._rows[self._length] = row
        self._length += 1

    def flush(self) -> None:
        """Write the rows that are not in the file yet."""
        if self.file is None or self._written == self._length:
            return
        new = self._rows[self._written : self._length]
        with self.file.open("a", encoding="utf-8") as stream:
            for row in new:
                stream.write(",".join(f"{value:.17g}" for value in map(float, row)) + "\n")
        self._written = self._length

    @classmethod
    def read(cls, file: Path) -> History:
        """The history in a CSV file; its numbers are those that were written."""
        where = str(file)
        try:
            with file.open(encoding="utf-8", newline="") as stream:
                table = csv.reader(stream)
                history = cls(next(table, []))
                for row in table:
                    history.append([float(value) for value in row])
        except OSError as error:
            raise SceneError(
                where, got=error.strerror or "no file", allowed="a history.csv"
            ) from error
        except ValueError as error:
            raise SceneError(where, got=f"{error}", allowed="a history.csv of numbers") from error
        return history
