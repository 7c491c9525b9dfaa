"""The files of the fields of a run, by the format that its scene selects."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Protocol

from solver.fields.part import Part, Values
from solver.fields.vtkhdf import NAME, HdfFile
from solver.fields.vtu import FieldsBefore, PvdFiles
from solver.scene import Scene


class BodyWriter(Protocol):
    """Takes the fields of a body; every rank that shares it calls every method."""

    def write(self, time: float, nodal: dict[str, Values], means: Mapping[str, Values]) -> None:
        """Write fields at the nodes and in the cells of the part, by their names, at a time, s."""


class FieldFiles(Protocol):
    """The files of a run's fields."""

    def body(self, name: str, part: Part) -> BodyWriter:
        """A writer for the next body; collective among the ranks that share it."""

    def begin(self) -> None:
        """All bodies are known; an OSError is raised where it happens, after what ranks share."""

    def end_time(self, time: float) -> None:
        """All bodies have written their fields at a time, s."""

    def close(self) -> None:
        """Finish the files of all bodies, and close them."""


def open_files(scene: Scene, folder: Path, before: FieldsBefore, *, writes: bool) -> FieldFiles:
    """The files in the folder of the run; `writes` on one rank only."""
    if scene.output.fields == "vtkhdf":
        return HdfFile(folder / NAME, writes=writes, until=before.until)
    return PvdFiles(folder, before, writes=writes)
