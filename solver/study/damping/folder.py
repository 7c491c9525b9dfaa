"""The folder of a study of damping: rows and angles of its cases."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from solver.study.folder import CASES, StudyFolder, store
from solver.study.tables import write
from solver.types import Array

FOLDER = StudyFolder(
    kind="study of damping",
    same="the same scene and block",
    files=(
        *("damping.csv", "damping.md", "damping*.png", "histories_*.png"),
        *("calibration.csv", "calibration.md", "calibration.png", "calibrated.toml"),
        "summary.json",
    ),
)

HEADING = "time_s,angle_rad"
"""First line of the file of an angle."""


def keep(folder: Path, name: str, outcome: Mapping[str, Any]) -> dict[str, Any]:
    """Keep a case, its angle in a file of its own; returns its row."""
    row = dict(outcome)
    angle = row.pop("angle", None)
    if angle is not None:
        lines = [HEADING, *(f"{time:.6f},{value:.9g}" for time, value in angle)]
        write(folder / CASES / f"{name}.csv", "\n".join(lines) + "\n")
    store(folder, name, row)
    return row


def kept_angle(folder: Path, name: str) -> tuple[Array, Array]:
    """Times (s) and angles (rad) of a case."""
    file = folder / CASES / f"{name}.csv"
    found = np.loadtxt(file, delimiter=",", skiprows=1, ndmin=2)
    return found[:, 0], found[:, 1]
