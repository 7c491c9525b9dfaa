"""Pieces of the fields: a body, or a rank's part of it, at one time, in VTK's XML.

Numbers stand in them as they are in memory, in base64. dolfinx's own files of this kind hold text
of 16 digits, which takes five times as long, and say nothing where a disk is full; VTK's own writer
would have to be installed, and imported.
"""

from __future__ import annotations

import struct
import sys
from base64 import b64encode
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solver.errors import of_file
from solver.fields.cells import Cells

Values = NDArray[Any]
"""Numbers of nodes or of cells, (n,) or (n, components)."""

TYPES = {"f8": "Float64", "i8": "Int64", "u1": "UInt8"}
"""VTK's names of the types of numbers, by numpy's."""

COPIES = "vtkGhostType"
"""What VTK calls the array that says which nodes and cells are copies of another rank's: those
that are not 0."""

HEAD = (
    '<?xml version="1.0"?>\n'
    f'<VTKFile type="{{kind}}" version="1.0" byte_order="{sys.byteorder.capitalize()}Endian" '
    'header_type="UInt64">\n'
)
END = "</VTKFile>\n"


class PieceWriter:
    """Writes the pieces of a mesh, which is the same in all of them."""

    def __init__(self, cells: Cells):
        """Prepare what does not change."""
        count, per_cell = cells.nodes.shape
        sizes = f'NumberOfPoints="{len(cells.points)}" NumberOfCells="{count}"'
        topology: dict[str, Values] = {
            "connectivity": cells.nodes.ravel(),
            "offsets": np.arange(1, count + 1, dtype=np.int64) * per_cell,
            "types": np.full(count, cells.kind, dtype=np.uint8),
        }
        self._before = b"".join(
            [
                HEAD.format(kind="UnstructuredGrid").encode(),
                f"<UnstructuredGrid>\n<Piece {sizes}>\n".encode(),
                *_section("Points", {"points": cells.points}),
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
    """What an array is."""
    components = 1 if values.ndim == 1 else values.shape[1]
    kind = TYPES[values.dtype.str[1:]]
    return f'type="{kind}" Name="{name}" NumberOfComponents="{components}"'
