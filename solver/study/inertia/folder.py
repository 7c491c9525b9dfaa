"""The folder of a study of inertia: the numbers of its runs, its tables, pictures and page."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from solver.study.folder import StudyFolder, finished, store

TABLE, TEXT, SUMMARY, PAGE = "inertia.csv", "inertia.md", "summary.json", "inertia.html"

FOLDER = StudyFolder(
    kind="study of inertia",
    same="the same scene",
    files=(TABLE, TEXT, SUMMARY, PAGE, "*.png"),
)

Runs = dict[str, list[float]]
"""Numbers of runs by their keys."""


def known_runs(folder: Path) -> Runs:
    """All runs that a folder holds."""
    runs: Runs = {}
    for row in finished(folder).values():
        runs |= row["runs"]
    return runs


def keep(folder: Path, outcome: Mapping[str, Any]) -> Runs:
    """Keep the runs of a task in a file of their own; returns them."""
    runs: Runs = outcome["runs"]
    name = hashlib.sha256(" ".join(sorted(runs)).encode()).hexdigest()[:20]
    store(folder, name, outcome)
    return runs
