"""Fields as pieces in VTK's XML, a body at one time each, and `fields.pvd`, which lists them.

Numbers stand in the pieces as they are in memory, in base64. dolfinx's own files of this kind hold
text of 16 digits, which takes twenty times as long, and say nothing where a disk is full; VTK's own
writer would have to be installed, and imported.
"""

from __future__ import annotations

import re
import struct
import sys
from base64 import b64encode
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from solver.errors import of_file
from solver.fields.part import Part, Values
from solver.parallel import any_rank

TYPES = {"f8": "Float64", "i8": "Int64", "u1": "UInt8"}
"""VTK's names of the types of numbers, by numpy's."""

COPIES = "vtkGhostType"
"""VTK's name of the array in which copies of another rank's nodes and cells are not 0."""

HEAD = (
    '<?xml version="1.0"?>\n'
    f'<VTKFile type="{{kind}}" version="1.0" byte_order="{sys.byteorder.capitalize()}Endian" '
    'header_type="UInt64">\n'
)
END = "</VTKFile>\n"

INDEX_HEAD = b'<?xml version="1.0"?>\n<VTKFile type="Collection" version="1.0">\n  <Collection>\n'
INDEX_TAIL = b"  </Collection>\n</VTKFile>\n"

#: The folder of the pieces, beside the index.
PIECES = "fields"

ENTRY = re.compile(rb' *<DataSet timestep="([^"]+)"[^>]*/>\n')


class PieceWriter:
    """Writes the pieces of a mesh, which is the same in all of them."""

    def __init__(self, part: Part):
        """Prepare what does not change."""
        count, per_cell = part.nodes.shape
        sizes = f'NumberOfPoints="{len(part.points)}" NumberOfCells="{count}"'
        topology: dict[str, Values] = {
            "connectivity": part.nodes.ravel(),
            "offsets": np.arange(1, count + 1, dtype=np.int64) * per_cell,
            "types": np.full(count, part.kind, dtype=np.uint8),
        }
        self._before = b"".join(
            [
                HEAD.format(kind="UnstructuredGrid").encode(),
                f"<UnstructuredGrid>\n<Piece {sizes}>\n".encode(),
                *_section("Points", {"points": part.points}),
                *_section("Cells", topology),
            ]
        )
        self._after = f"</Piece>\n</UnstructuredGrid>\n{END}".encode()

    def write(self, file: Path, nodal: Mapping[str, Values], means: Mapping[str, Values]) -> None:
        """Write fields at the nodes and in the cells, by their names."""
        fields = *_section("PointData", nodal), *_section("CellData", means)
        _write(file, b"".join([self._before, *fields, self._after]))


def write_parts(
    file: Path, parts: Sequence[str], nodal: Mapping[str, Values], means: Mapping[str, Values]
) -> None:
    """Write what VTK opens instead of the pieces of all ranks, with fields as in one of them.

    Args:
        file: Where to.
        parts: Names of the pieces.
        nodal: Fields at the nodes.
        means: Fields in the cells.
    """
    lines = [HEAD.format(kind="PUnstructuredGrid"), '<PUnstructuredGrid GhostLevel="1">\n']
    for place, fields in (("PPointData", nodal), ("PCellData", means)):
        declared = [f"<PDataArray {_declared(*field)}/>\n" for field in fields.items()]
        lines += [f"<{place}>\n", *declared, f"</{place}>\n"]
    points = _declared("points", np.empty((0, 3)))
    lines.append(f"<PPoints>\n<PDataArray {points}/>\n</PPoints>\n")
    lines += [f'<Piece Source="{part}"/>\n' for part in parts]
    _write(file, "".join([*lines, "</PUnstructuredGrid>\n", END]).encode())


def _write(file: Path, content: bytes) -> None:
    """Write a file; errors name it, whenever they happen."""
    try:
        file.write_bytes(content)
    except OSError as error:
        raise of_file(error, file) from error


def _section(place: str, arrays: Mapping[str, Values]) -> list[bytes]:
    """A section of a piece, with its arrays."""
    written = [_array(name, values) for name, values in arrays.items()]
    return [f"<{place}>\n".encode(), *written, f"</{place}>\n".encode()]


def _array(name: str, values: Values) -> bytes:
    """An array of a piece: how many bytes there are, and the bytes."""
    numbers = b64encode(struct.pack("=Q", values.nbytes) + values.tobytes())
    declared = f'<DataArray {_declared(name, values)} format="binary">'
    return b"%s%s</DataArray>\n" % (declared.encode(), numbers)


def _declared(name: str, values: Values) -> str:
    """Type, name and components of an array."""
    components = 1 if values.ndim == 1 else values.shape[1]
    kind = TYPES[values.dtype.str[1:]]
    return f'type="{kind}" Name="{name}" NumberOfComponents="{components}"'


def entry_of(time: float, piece: str, part: int = 0, name: str = "") -> bytes:
    """The entry of a piece, by its time, s, its path and the number and the name of its body."""
    called = f' name="{name}"' if name else ""
    where = f'timestep="{time:.17g}" part="{part}"{called}'
    return f'    <DataSet {where} file="{piece}" />\n'.encode()


@dataclass(frozen=True, slots=True)
class FieldsBefore:
    """Fields that an earlier part of a run has left."""

    part: int = 1
    """Number of the part that is written now; names of pieces contain it from the second one on."""
    until: float | None = None
    """Time up to which earlier pieces stay, s; None: there are none."""


class PvdFiles:
    """A file for each body and time, which `fields.pvd` lists.

    It is complete after every piece, so that a killed run can be looked at. Bodies are the parts of
    a time: ParaView and pyvista show those of one time together.
    """

    def __init__(self, folder: Path, before: FieldsBefore, *, writes: bool):
        """Take the folder of the run; `writes` is False on all ranks but one."""
        self._folder, self._before, self._writes = folder, before, writes
        self._file, self._end = folder / "fields.pvd", 0
        self._series: list[PieceSeries] = []

    def body(self, name: str, part: Part) -> PieceSeries:
        """A writer for the next body."""
        again = f"-{self._before.part}" if self._before.part > 1 else ""
        stem = f"fields_{name}{again}"
        writes = self._writes or part.comm.size > 1
        pieces, number = self._folder / PIECES, len(self._series)
        self._series.append(PieceSeries(self, pieces, stem, part, number, name, writes))
        return self._series[-1]

    def begin(self) -> None:
        """Write an empty index, or what is kept of the old one."""
        if not self._writes:
            return
        (self._folder / PIECES).mkdir(exist_ok=True)
        until, kept = self._before.until, b""
        if until is not None and self._file.is_file():
            found = ENTRY.finditer(self._file.read_bytes())
            kept = b"".join(entry[0] for entry in found if float(entry[1]) <= until)
        self._file.write_bytes(INDEX_HEAD + kept + INDEX_TAIL)
        self._end = len(INDEX_HEAD) + len(kept)

    def add(self, time: float, piece: str, part: int = 0, name: str = "") -> None:
        """List a piece by its name.

        `part` is the number of the body, `name` that which ParaView shows. The time (s) is the same
        number for all parts.
        """
        if not self._writes:
            return
        entry = entry_of(time, f"{PIECES}/{piece}", part, name)
        with self._file.open("r+b") as stream:
            stream.seek(self._end)
            stream.write(entry + INDEX_TAIL)
        self._end += len(entry)

    def end_time(self, time: float) -> None:
        """Do nothing: the index lists each piece as it is written."""

    def close(self) -> None:
        """List the pieces of each body alone; the index of all is complete after every piece."""
        for series in self._series:
            series.close()


class PieceSeries:
    """Writes the pieces of one body and lists them; every rank that shares it calls every method.

    On several ranks each has a piece of its own, and a `.pvtu` opens all of them.
    """

    def __init__(
        self, index: PvdFiles, folder: Path, stem: str, part: Part, number: int, name: str,
        writes: bool,
    ):  # fmt: skip
        """Prepare what does not change; the stem and a number are the names of the pieces."""
        self._index, self._folder, self._stem, self._writes = index, folder, stem, writes
        self._part, self._number, self._name = part, number, name
        self._count = 0
        self._alone: list[bytes] = []
        """Entries of the body's own index."""
        self._piece = PieceWriter(part)

    def write(self, time: float, nodal: dict[str, Values], means: Mapping[str, Values]) -> None:
        """Write the fields at a time (s).

        An OSError is raised where it happens, after all that ranks do together.
        """
        if not self._writes:
            return
        number, self._count = self._count, self._count + 1  # whatever follows
        trouble, piece = None, ""
        try:
            piece = self._write_piece(number, nodal, means)
        except OSError as error:
            trouble = error
        # Ranks may be killed at any time: what is listed has been written by all of them.
        complete = not any_rank(self._part.comm, trouble is not None)
        if trouble is not None:
            raise trouble
        if complete:
            self._index.add(time, piece, self._number, self._name)
            self._alone.append(entry_of(time, piece))

    def _write_piece(
        self, number: int, nodal: Mapping[str, Values], means: Mapping[str, Values]
    ) -> str:
        """Write the piece of this rank, and on the first of several what opens all pieces.

        Returns the name of what is to be opened.
        """
        part, comm = self._part, self._part.comm
        if comm.size == 1:
            piece = f"{self._stem}{number:06d}.vtu"
            self._piece.write(self._folder / piece, nodal, means)
            return piece
        nodal = {**nodal, COPIES: _copies(len(part.points), part.own_points)}
        means = {**means, COPIES: _copies(len(part.nodes), part.own_cells)}
        whole = f"{self._stem}{number:06d}.pvtu"
        parts = [f"{self._stem}_p{rank}_{number:06d}.vtu" for rank in range(comm.size)]
        self._piece.write(self._folder / parts[comm.rank], nodal, means)
        if comm.rank == 0:
            write_parts(self._folder / whole, parts, nodal, means)
        return whole

    def close(self) -> None:
        """List the pieces of the body alone, if there is room for it."""
        if self._writes and self._part.comm.rank == 0:
            with suppress(OSError):
                content = INDEX_HEAD + b"".join(self._alone) + INDEX_TAIL
                (self._folder / f"{self._stem}.pvd").write_bytes(content)


def _copies(count: int, own: int | None) -> Values:
    """1 for each of the copies of others', which stand behind a rank's own, else 0."""
    return (np.arange(count) >= (count if own is None else own)).astype(np.uint8)
