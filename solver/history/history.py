"""The history of a run: one row a step, kept in memory and, if asked for, in a CSV file."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from solver.errors import SceneError
from solver.scene import Scene

#: Columns of the run as a whole.
RUN_COLUMNS = (
    "time_s",
    "step_s",
    "newton_iterations",
    "contact_points_closed",
    "base.acceleration_m_s2",
)

#: Columns of each block in two dimensions, written `NAME.column`.
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

#: The same in three: `angle_rad` is the lean in the plane of motion, the others are vectors.
BLOCK_COLUMNS_3D = (
    "angle_rad",
    "angle_x_rad",
    "angle_y_rad",
    "angle_z_rad",
    "angular_velocity_x_rad_s",
    "angular_velocity_y_rad_s",
    "angular_velocity_z_rad_s",
    "slip_m",
    "slip_second_m",
    "gap_1_m",
    "gap_2_m",
    "gap_3_m",
    "gap_4_m",
    "penetration_m",
    "centre_x_m",
    "centre_y_m",
    "centre_z_m",
    "normal_force_N",
    "friction_force_N",
    "friction_force_second_N",
)

#: Columns of what carries the blocks, where it moves as a whole: along x, in 3-D also along y.
PLATFORM_COLUMNS = ("drift_m", "velocity_m_s", "acceleration_m_s2")
PLATFORM_COLUMNS_SECOND = ("drift_second_m", "velocity_second_m_s", "acceleration_second_m_s2")

#: Stored energies: their sum is `energy.total_J`.
STORED_ENERGIES = ("kinetic", "strain", "gravity", "spring", "interface")

#: What has been dissipated since the start, each from its own formula.
DISSIPATED_ENERGIES = ("friction", "damping", "contact", "numerical")

ENERGY_COLUMNS = tuple(
    f"energy.{name}_J"
    for name in (*STORED_ENERGIES, "input", *DISSIPATED_ENERGIES, "total", "ledger_error")
)

#: Rows that become text in one go.
CHUNK = 256


def columns(
    blocks: Sequence[str],
    *,
    dimension: int = 2,
    platform: bool = False,
    vertical: bool = False,
    second: bool = False,
) -> tuple[str, ...]:
    """Names of all columns of the history of a scene, in their order.

    Args:
        blocks: Names of the blocks.
        dimension: 2 or 3.
        platform: Whether what carries the blocks moves as a whole.
        vertical: Whether the ground also moves up and down.
        second: Whether the ground also moves along the second horizontal direction.
    """
    spatial = dimension == 3
    directions = [name for name, there in (("vertical", vertical), ("second", second)) if there]
    of_ground = [f"base.{name}_acceleration_m_s2" for name in directions]
    of_block = BLOCK_COLUMNS_3D if spatial else BLOCK_COLUMNS
    of_blocks = [f"{block}.{column}" for block in blocks for column in of_block]
    moving = PLATFORM_COLUMNS + (PLATFORM_COLUMNS_SECOND if spatial else ())
    of_platform = [f"platform.{column}" for column in moving if platform]
    return (*RUN_COLUMNS, *of_ground, *of_blocks, *of_platform, *ENERGY_COLUMNS)


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
    )


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
        # numpy would spread a single value over the row.
        if len(row) != len(self.columns):
            raise ValueError(f"got {len(row)} values for {len(self.columns)} columns")
        self._reserve(1)
        self._rows[self._length] = row
        self._length += 1

    def extend(self, rows: NDArray[np.float64]) -> None:
        """Add many rows at once, (n, number of columns)."""
        if rows.ndim != 2 or rows.shape[1] != len(self.columns):
            raise ValueError(f"got rows of shape {rows.shape} for {len(self.columns)} columns")
        self._reserve(len(rows))
        self._rows[self._length : self._length + len(rows)] = rows
        self._length += len(rows)

    def _reserve(self, more: int) -> None:
        """Make room for more rows; doubling keeps the copies few."""
        needed = self._length + more
        if needed > len(self._rows):
            room = np.empty((max(needed, 2 * len(self._rows)), len(self.columns)))
            room[: self._length] = self._rows[: self._length]
            self._rows = room

    def flush(self) -> None:
        """Write the rows that are not in the file yet."""
        if self.file is None or self._written == self._length:
            return
        line = ",".join(["%.17g"] * len(self.columns)) + "\n"
        with self.file.open("a", encoding="utf-8") as stream:
            for first in range(self._written, self._length, CHUNK):
                part = self._rows[first : min(first + CHUNK, self._length)]
                stream.write(line * len(part) % tuple(part.ravel().tolist()))
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
