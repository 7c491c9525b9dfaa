"""A finished run, read back from its folder."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from solver.errors import SceneError, Statement, hidden_by_in_env
from solver.history.history import History, scene_columns
from solver.history.pairs import NAME as PAIRS
from solver.history.pairs import read_pairs
from solver.results.summary import summarise
from solver.scene import Scene, parse_scene, read_text
from solver.types import Array

UNFINISHED = "unfinished"
"""Status of a run that left no summary."""

#: Name of the file that a run's fields are opened by.
FIELDS = "fields.pvd"


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """The files that a run left in its folder."""

    folder: Path
    scene: Scene
    history: History
    summary: dict[str, Any]

    @property
    def fields(self) -> Path | None:
        """The file of the fields, if there are any."""
        file = self.folder / FIELDS
        return file if file.is_file() else None

    def pairs(self) -> dict[tuple[str, str], dict[str, Array]]:
        """The columns of pairs.csv by pairs of names; none where the run did not write it."""
        file = self.folder / PAIRS
        return read_pairs(file) if file.is_file() else {}

    def neighbours(self) -> dict[tuple[str, str], dict[str, Array]]:
        """The pairs of blocks of which neither carries the other."""
        blocks = {block.name: block for block in self.scene.blocks}
        return {
            (one, other): known
            for (one, other), known in self.pairs().items()
            if {one, other} <= blocks.keys() and blocks[one].is_beside(blocks[other])
        }

    @property
    def label(self) -> str:
        """Name of the run in pictures; beside others `labels` gives it."""
        return self.folder.resolve().name

    @property
    def model(self) -> str:
        """Model of the run: finite elements, rigid blocks, or the name of a rigid-body answer."""
        return str(self.summary["model"])


def labels(runs: Sequence[Run]) -> list[str]:
    """Names of runs beside one another: those of their folders, and of those above if alike."""
    parts = [run.folder.resolve().parts for run in runs]
    for depth in range(1, max(map(len, parts), default=0) + 1):
        names = ["/".join(part[-depth:]) for part in parts]
        if len(set(names)) == len(set(parts)):
            return names
    return [str(run.folder) for run in runs]


def read_run(folder: str | Path) -> Run:
    """Read a run back; a folder that holds none is bad input.

    A run that was killed, or still goes on, has no summary: it is made from the history.

    Raises:
        RockslipError: There is no run in the folder, or it cannot be read.
    """
    folder = Path(folder)
    for name in ("scene.toml", "history.csv"):
        if not (folder / name).is_file():
            hidden = hidden_by_in_env(folder)
            if hidden:
                raise Statement(str(folder), hidden)
            raise SceneError(str(folder), f"no {name}", "the folder of a run")
    # What the run has left stays of use where the record that shook it is elsewhere by now.
    text = read_text(folder / "scene.toml")
    scene = parse_scene(text, folder=folder, source="scene.toml", needs_files=False)
    history = History.read(folder / "history.csv")
    missing = [name for name in scene_columns(scene) if name not in history]
    if missing:
        raise SceneError(str(folder / "history.csv"), f"no column {missing[0]}", "all of its scene")
    if len(history) < 2:
        raise SceneError(str(folder / "history.csv"), f"{len(history)} rows", "two rows or more")
    if (folder / "summary.json").is_file():
        summary = _read_summary(folder / "summary.json", scene)
    else:
        history.events = None  # of what had been written, not of all rows
        reason = "killed, or still going on: made from the history"
        nothing: dict[str, Any] = {}
        summary = summarise(
            scene, history, status=UNFINISHED, cost=nothing, versions=nothing, reason=reason
        )
    return Run(folder=folder, scene=scene, history=history, summary=summary)


def _read_summary(file: Path, scene: Scene) -> dict[str, Any]:
    """The content of a summary.json, in which what the program reads is there."""
    allowed = "a summary (without the file one is made from the history)"
    try:
        summary = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise SceneError(str(file), str(error), allowed) from None
    try:
        entries = [summary["model"], summary["status"], summary["energy"]["ledger_error_fraction"]]
        for block in scene.blocks:
            own = summary["blocks"][block.name]
            entries += [own["peak_angle_rad"], own["peak_angle_over_alpha"]]
            entries += [own["overturned_at_s"], own["fell_at_s"], own["impacts"], own["peaks"]]
            entries += [entry["time_s"] for entry in (*own["impacts"], *own["peaks"])]
    except KeyError as error:
        raise SceneError(str(file), f"no {error.args[0]}", allowed) from None
    except (TypeError, IndexError):
        raise SceneError(str(file), "entries of other types", allowed) from None
    return dict(summary)
