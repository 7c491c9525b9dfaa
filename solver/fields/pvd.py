"""The index of the fields, `fields.pvd`: which piece shows which part at which time."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

HEAD = b'<?xml version="1.0"?>\n<VTKFile type="Collection" version="1.0">\n  <Collection>\n'
TAIL = b"  </Collection>\n</VTKFile>\n"


#: The folder of the pieces, beside the index.
PIECES = "fields"

ENTRY = re.compile(rb' *<DataSet timestep="([^"]+)"[^>]*/>\n')


def _pieces(file: Path, until: float) -> bytes:
    """The entries of an index up to a time, s."""
    found = ENTRY.finditer(file.read_bytes())
    return b"".join(entry[0] for entry in found if float(entry[1]) <= until)


def entry_of(time: float, piece: str, part: int = 0, name: str = "") -> bytes:
    """The entry of a piece, by its time, s, its way and the number and the name of its body."""
    called = f' name="{name}"' if name else ""
    where = f'timestep="{time:.17g}" part="{part}"{called}'
    return f'    <DataSet {where} file="{piece}" />\n'.encode()


def write_index(file: Path, entries: Sequence[bytes]) -> None:
    """Write an index of these entries."""
    file.write_bytes(HEAD + b"".join(entries) + TAIL)


@dataclass(frozen=True, slots=True)
class FieldsBefore:
    """What an earlier part of a run has left of the fields."""

    part: int = 1
    """Number of the part that is written now; names of pieces tell it from the second one on."""
    until: float | None = None
    """Time up to which earlier pieces stay, s; None: there are none."""

    def file(self, folder: Path, name: str) -> Path:
        """What the pieces of a body are named after, in a folder of their own, which is made."""
        part = f"-{self.part}" if self.part > 1 else ""
        (folder / PIECES).mkdir(exist_ok=True)
        return folder / PIECES / f"fields_{name}{part}.pvd"


class PvdIndex:
    """A .pvd file that is complete after every piece, so that a killed run can be looked at.

    Bodies are the parts of a time: ParaView and pyvista show those of one time together.
    """

    def __init__(self, file: Path, *, writes: bool = True, until: float | None = None):
        """Know the file, which `begin` writes; `writes` is False on all ranks but one.

        The pieces of an old file up to a time, s, stay in it; None: no piece does.
        """
        self._file, self._writes, self._until = file, writes, until
        self._end = len(HEAD)

    def begin(self) -> None:
        """Write an empty index, or what is kept of the old one."""
        if self._writes:
            until, there = self._until, self._file.is_file()
            kept = b"" if until is None or not there else _pieces(self._file, until)
            write_index(self._file, [kept])
            self._end = len(HEAD) + len(kept)

    def way_to(self, folder: Path) -> str:
        """What stands before the names of pieces in a folder: empty in that of the index."""
        way = folder.relative_to(self._file.parent).as_posix()
        return "" if way == "." else f"{way}/"

    def add(self, time: float, piece: str, part: int = 0, name: str = "") -> None:
        """List a piece by its way from the folder of the index.

        `part` is the number of the body, `name` what ParaView calls it. The time (s) is the same
        number for all parts.
        """
        if not self._writes:
            return
        entry = entry_of(time, piece, part, name)
        with self._file.open("r+b") as stream:
            stream.seek(self._end)
            stream.write(entry + TAIL)
        self._end += len(entry)
