"""A finished run, read back from its folder."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from solver.errors import SceneError
from solver.history.history import History
from solver.scene import Scene, load_scene

#: Name of the file that lists the fields.
FIELDS = "fields.pvd"


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """The files that a run left in its folder."""

    folder: Path
    scene: Scene
    history: History
    summary: dict[str, Any]

    @property
    def label(self) -> str:
        """Name of the run in pictures."""
        return self.folder.resolve().name

    @property
    def model(self) -> str:
        """Model of the run: finite elements, rigid blocks, or the name of a rigid-body answer."""
        return str(self.summary["model"])


def read_run(folder: Path) -> Run:
    """Read a run back; a folder that holds none is bad input."""
    for name in ("scene.toml", "history.csv", "summary.json"):
        if not (folder / name).is_file():
            raise SceneError(str(folder), f"no {name}", "the folder of a run")
    history = History.read(folder / "history.csv")
    if len(history) < 2:
        raise SceneError(str(folder / "history.csv"), f"{len(history)} rows", "two rows or more")
    try:
        summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    except ValueError as error:
        raise SceneError(str(folder / "summary.json"), str(error), "a summary") from None
    scene = load_scene(folder / "scene.toml")
    return Run(folder=folder, scene=scene, history=history, summary=summary)
