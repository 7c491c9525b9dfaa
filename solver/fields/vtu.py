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
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from solver.errors import of_file
from solver.fields.part import Part, Values

TYPES = {"f8": "Float64", "i8": "Int64", "u1": "UInt8"}
"""VTK's names of the types of numbers, by numpy's."""

HEAD = (
    '<?xml version="1.0"?>\n'
    '<VTKFile type="UnstructuredGrid" version="1.0" header_type="UInt64" '
    f'byte_order="{sys.byteorder.capitalize()}Endian">\n<UnstructuredGrid>\n'
)
TAIL = b"</Piece>\n</UnstructuredGrid>\n</VTKFile>\n"

INDEX_HEAD = b'<?xml version="1.0"?>\n<VTKFile type="Collection" version="1.0">\n  <Collection>\n'
INDEX_TAIL = b"  </Collection>\n</VTKFile>\n"

#: The folder of the pieces, beside the index.
PIECES = "fields"

ENTRY = re.compile(rb' *<DataSet timestep="([^"]+)"[^>]*/>\n')


class PieceWriter:
    """Writes the pieces of a mesh, which is the same in all of them."""

    def __init__(self, points: Values, nodes: Values, kind: int):
        """Prepare what does not change; arguments as in `Part`, of all ranks together."""
        count, per_cell = nodes.shape
        sizes = f'NumberOfPoints="{len(points)}" NumberOfCells="{count}"'
        topology: dict[str, Values] = {
            "connectivity": nodes.ravel(),
            "offsets": np.arange(1, count + 1, dtype=np.int64) * per_cell,
            "types": np.full(count, kind, dtype=np.uint8),
        }
        self._before = b"".join(
            [
                f"{HEAD}<Piece {sizes}>\n".encode(),
                *_section("Points", {"points": points}),
                *_section("Cells", topology),
            ]
        )

    def write(self, file: Path, nodal: Mapping[str, Values], means: Mapping[str, Values]) -> None:
        """Write fields at the nodes and in the cells, by their names."""
        fields = *_section("PointData", nodal), *_section("CellData", means)
        try:
            file.write_bytes(b"".join([self._before, *fields, TAIL]))
        except OSError as error:
            raise of_file(error, file) from error  # errors name it, whenever they happen


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
        """Take the folder of the run; `writes` on the first rank only."""
        self.pieces, self.writes = folder / PIECES, writes
        self._before, self._bodies = before, 0
        self._file, self._end = folder / "fields.pvd", 0

    def body(self, name: str, part: Part) -> PieceSeries:
        """A writer for the next body; collective among the ranks that share it."""
        again = f"-{self._before.part}" if self._before.part > 1 else ""
        number, self._bodies = self._bodies, self._bodies + 1
        return PieceSeries(self, part, number, name, f"fields_{name}{again}")

    def begin(self) -> None:
        """Write an empty index, or what is kept of the old one."""
        if not self.writes:
            return
        self.pieces.mkdir(exist_ok=True)
        until, kept = self._before.until, b""
        if until is not None and self._file.is_file():
            found = ENTRY.finditer(self._file.read_bytes())
            kept = b"".join(entry[0] for entry in found if float(entry[1]) <= until)
        self._file.write_bytes(INDEX_HEAD + kept + INDEX_TAIL)
        self._end = len(INDEX_HEAD) + len(kept)

    def add(self, time: float, number: int, name: str, piece: str) -> None:
        """List a piece of a body by its time, s, which is the same number for all bodies."""
        where = f'timestep="{time:.17g}" part="{number}" name="{name}"'
        entry = f'    <DataSet {where} file="{PIECES}/{piece}" />\n'.encode()
        with self._file.open("r+b") as stream:
            stream.seek(self._end)
            stream.write(entry + INDEX_TAIL)
        self._end += len(entry)


class PieceSeries:
    """Writes the pieces of one body and lists them; every rank that shares it calls every method.

    The first rank writes what it gathers from all.
    """

    def __init__(self, index: PvdFiles, part: Part, number: int, name: str, stem: str):
        """Take the first mesh; the stem and a number are the names of the pieces."""
        self._index, self._number, self._name = index, number, name
        self._stem, self._count = stem, 0
        self.renew(part)

    def renew(self, part: Part) -> None:
        """Take the mesh of the pieces from here on."""
        self._part = part
        mesh = part.gathered(part.points), part.gathered(part.nodes)
        self._piece = PieceWriter(*mesh, part.kind) if self._index.writes else None

    def write(self, time: float, nodal: Mapping[str, Values], means: Mapping[str, Values]) -> None:
        """Write fields at the nodes and in the cells of the part, by their names, at a time, s.

        An OSError is raised where it happens, after all that ranks do together.
        """
        nodal, means = (
            {name: self._part.gathered(own) for name, own in fields.items()}
            for fields in (nodal, means)
        )
        if self._piece is None:
            return
        piece, self._count = f"{self._stem}{self._count:06d}.vtu", self._count + 1
        self._piece.write(self._index.pieces / piece, nodal, means)
        self._index.add(time, self._number, self._name, piece)
