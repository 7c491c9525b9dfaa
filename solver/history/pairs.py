"""The file `pairs.csv` beside a history: what pairs of bodies do to one another, row by row."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from solver.errors import SceneError, of_file
from solver.types import Array

NAME = "pairs.csv"
"""Name of the file."""

MEANING = {
    "time_s": "Time of the row of the history, s.",
    "first": "Name of a body.",
    "second": 'Name of a body that it has touched by then; "foundation" is never the first.',
    "normal_N": "Normal force between them, N; as all forces here the mean over the step.",
    "friction_N": "Friction on the first, N, along the first tangent.",
    "friction_second_N": "In space: along the second tangent, N.",
    "gap_m": "How far they are apart along the axis that separates them best, m; below 0: overlap.",
    "slip_m": "What the first has slipped over the second, as long as they touched, m.",
    "slip_second_m": "In space: along the second tangent, m.",
    "x_m": "Where they press on one another, the mean by the normal forces, m.",
    "y_m": "The same along y, m.",
    "z_m": "In space: along z, m.",
    "normal_x": "The mean unit normal, from the second to the first.",
    "normal_y": "The same along y.",
    "normal_z": "In space: along z.",
    "points": "Number of points that touch.",
}
"""Names of the columns with what they hold."""


def pair_columns(dimension: int) -> tuple[str, ...]:
    """Names of the columns, in their order."""
    spatial = ("friction_second_N", "slip_second_m", "z_m", "normal_z")
    return tuple(name for name in MEANING if dimension == 3 or name not in spatial)


class PairTable:
    """The rows that wait for the file, and the file."""

    def __init__(self, file: Path | None, names: Sequence[str], dimension: int):
        """Begin; `names` are those of the bodies by their numbers. Without a file rows vanish."""
        self._file, self._names, self._d = file, tuple(names), dimension
        self._waiting: list[str] = []

    def begin(self, until: float | None = None) -> None:
        """Write the head; or, where a run goes on after a time (s), keep the lines up to it."""
        if self._file is None:
            return
        lines = [",".join(pair_columns(self._d))]
        try:
            if until is not None:
                known = self._file.read_text(encoding="utf-8").splitlines(keepends=True)[1:]
                whole = (line for line in known if line.endswith("\n"))
                lines += [t.rstrip("\n") for t in whole if float(t.split(",", 1)[0]) <= until]
            self._file.write_text("\n".join(lines) + "\n", encoding="utf-8")
        except OSError as error:
            raise of_file(error, self._file) from error

    def add(self, times: Array, pairs: Array) -> None:
        """Rows of steps as `World.pairs` has them, whose numbers are places in `times`, s."""
        if self._file is None or not len(pairs):
            return
        names = self._names
        for row in pairs:
            numbers = ",".join(f"{value:.17g}" for value in row[4:])
            who = f"{names[int(row[1])]},{names[int(row[2])]}"
            self._waiting.append(f"{times[int(row[0])]:.17g},{who},{numbers},{int(row[3])}\n")

    def flush(self) -> None:
        """Write the rows that wait."""
        if self._file is None or not self._waiting:
            return
        with self._file.open("a", encoding="utf-8") as file:
            file.writelines(self._waiting)
        self._waiting.clear()


def force_on_first(known: Mapping[str, Array]) -> Array:
    """The force on the first body of a pair, by its columns, N, (rows, d)."""
    axes = "xyz" if "normal_z" in known else "xy"
    normal = np.stack([known[f"normal_{axis}"] for axis in axes], axis=1)
    force = known["normal_N"][:, None] * normal
    for name, along in zip(FRICTION, pair_tangents(normal).swapaxes(0, 1), strict=False):
        force += known[name][:, None] * along
    return np.asarray(force)


FRICTION = ("friction_N", "friction_second_N")
"""Columns of friction along the tangents of a pair."""


def pair_tangents(normal: Array) -> Array:
    """The tangents of pairs with mean unit normals (rows, d), (rows, d - 1, d).

    In the plane the normal turned clockwise.
    """
    if normal.shape[1] == 2:
        return np.stack([normal[:, 1], -normal[:, 0]], axis=1)[:, None]
    x, y, z, none = *normal.T, np.zeros(len(normal))
    along = np.stack([z, none, -x], axis=1)
    steep = np.stack([y, -x, none], axis=1)
    first = np.where((np.abs(y) < 0.9)[:, None], along, steep)
    first /= np.maximum(np.linalg.norm(first, axis=1), 1e-300)[:, None]
    return np.stack([first, np.cross(normal, first)], axis=1)


def kept_pairs(pairs: Array, kept: Array) -> Array:
    """The rows of those steps that are kept, by a mask over the steps."""
    return pairs[np.asarray(kept)[pairs[:, 0].astype(int)]] if len(pairs) else pairs


def read_pairs(file: Path) -> dict[tuple[str, str], dict[str, Array]]:
    """The columns with numbers of a file, by pairs of names; times before the first touch lack.

    Raises:
        SceneError: It cannot be read.
    """
    found: dict[tuple[str, str], list[list[float]]] = {}
    try:
        head, *lines = file.read_text(encoding="utf-8").splitlines()
        for line in lines:
            time, first, second, *values = line.split(",")
            found.setdefault((first, second), []).append([float(x) for x in (time, *values)])
        names = [name for name in head.split(",") if name not in ("first", "second")]
        return {
            pair: dict(zip(names, np.array(rows).T, strict=True)) for pair, rows in found.items()
        }
    except (OSError, ValueError) as error:
        raise SceneError(str(file), f"{error}", "a pairs.csv as it was written") from error
