"""Where the fields of a run go: files of each time, or one file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from solver.fields.cells import one_cell
from solver.fields.hdf_file import NAME, HdfBody, HdfFile
from solver.fields.pvd import FieldsBefore, PvdIndex
from solver.fields.rigid_writer import RigidFieldWriter, nodal_fields
from solver.scene import Scene
from solver.types import Array

if TYPE_CHECKING:
    from solver.fields.body_functions import BodyFunctions


class RigidWriter(Protocol):
    """What takes the fields of a rigid body."""

    def write(self, time: float, displacement: Array, velocity: Array) -> None:
        """Write the motion of its corners relative to the ground at a time, s, (n, d)."""


class MeshedWriter(Protocol):
    """What takes the fields of a meshed body, which it was given as functions; collective."""

    def write(self, time: float) -> None:
        """Write the fields at a time, s."""

    def close(self) -> None:
        """Finish what belongs to the body alone."""


class Destination(Protocol):
    """The files of a run's fields."""

    def rigid(self, name: str, corners: Array) -> RigidWriter:
        """A writer for the next body, which is rigid, with its corners as it stands upright, m."""

    def meshed(self, name: str, functions: BodyFunctions) -> MeshedWriter:
        """A writer for the next body, which is meshed; collective."""

    def begin(self) -> None:
        """All bodies are known; an OSError is raised where it happens, after what ranks share."""

    def end_time(self, time: float) -> None:
        """All bodies have written their fields at a time, s."""

    def close(self) -> None:
        """Close the files."""


def open_destination(
    scene: Scene, folder: Path, before: FieldsBefore, *, writes: bool
) -> Destination:
    """The files that the scene wants, in the folder of the run; `writes` on one rank only."""
    if scene.output.fields == "vtkhdf":
        return OneFile(folder, before, writes=writes)
    return Pieces(folder, before, writes=writes)


class Pieces:
    """A file for each body and time, which `fields.pvd` lists."""

    def __init__(self, folder: Path, before: FieldsBefore, *, writes: bool):
        """Know `fields.pvd`, which `begin` writes."""
        self._folder, self._before, self._writes, self._count = folder, before, writes, 0
        self._index = PvdIndex(folder / "fields.pvd", writes=writes, until=before.until)

    def _next(self) -> int:
        """The number of the next body."""
        self._count += 1
        return self._count - 1

    def rigid(self, name: str, corners: Array) -> RigidFieldWriter:
        """A writer for the next body, which is rigid."""
        file, part = self._before.file(self._folder, name), self._next()
        return RigidFieldWriter(
            file, corners, index=self._index, part=part, name=name, writes=self._writes
        )

    def meshed(self, name: str, functions: BodyFunctions) -> MeshedWriter:
        """A writer for the next body, which is meshed; collective."""
        from solver.fields.meshed_writer import MeshedFieldWriter

        file, part = self._before.file(self._folder, name), self._next()
        return MeshedFieldWriter(file, functions, index=self._index, part=part, name=name)

    def begin(self) -> None:
        """Begin the index, or go on in it."""
        self._index.begin()

    def end_time(self, time: float) -> None:
        """The index lists each piece as it is written."""

    def close(self) -> None:
        """The index is complete after every piece."""


class OneFile:
    """One file for all bodies and times."""

    def __init__(self, folder: Path, before: FieldsBefore, *, writes: bool):
        """Know the file, which `begin` opens."""
        self._file, self._until = HdfFile(folder / NAME) if writes else None, before.until

    def rigid(self, name: str, corners: Array) -> RigidWriter:
        """A writer for the next body, which is rigid."""
        return _RigidBody(None if self._file is None else self._file.body(name, one_cell(corners)))

    def meshed(self, name: str, functions: BodyFunctions) -> MeshedWriter:
        """A writer for the next body, which is meshed; collective."""
        from solver.fields.hdf_writer import HdfFieldWriter

        return HdfFieldWriter(self._file, name, functions)

    def begin(self) -> None:
        """Begin the file, or go on in it."""
        if self._file is not None:
            self._file.open(self._until)

    def end_time(self, time: float) -> None:
        """Let what was written count."""
        if self._file is not None:
            self._file.end_time(time)

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            self._file.close()


class _RigidBody:
    """A rigid body in the one file; on ranks without the file it writes nothing."""

    def __init__(self, body: HdfBody | None):
        self._body = body

    def write(self, time: float, displacement: Array, velocity: Array) -> None:
        """Write the motion of the corners."""
        if self._body is not None:
            self._body.write(nodal_fields(displacement, velocity), {})
