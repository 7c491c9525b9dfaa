"""Fields of a rigid body for ParaView, as one cell; without dolfinx or VTK, which take seconds."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from solver.fields.pvd import PvdIndex
from solver.types import Array

#: Numbers of corners of VTK's quadrilateral and hexahedron, and VTK's numbers of these cells.
CELL_TYPES = {4: 9, 8: 12}

PIECE = """\
<?xml version="1.0"?>
<VTKFile type="UnstructuredGrid" version="1.0">
  <UnstructuredGrid>
    <Piece NumberOfPoints="{count}" NumberOfCells="1">
      <Points>{points}</Points>
      <Cells>
        <DataArray type="Int32" Name="connectivity" format="ascii">{connectivity}</DataArray>
        <DataArray type="Int32" Name="offsets" format="ascii">{count}</DataArray>
        <DataArray type="UInt8" Name="types" format="ascii">{cell_type}</DataArray>
      </Cells>
      <PointData>{{}}{{}}{pressure}</PointData>
    </Piece>
  </UnstructuredGrid>
</VTKFile>
"""


class RigidFieldWriter:
    """Writes a rigid body beside `fields.pvd`, with the fields of an elastic one.

    Contact pressure is zero: a rigid body has contact forces, but they have no place on it.
    """

    def __init__(
        self,
        file: Path,
        corners: Array,
        *,
        index: PvdIndex | None = None,
        part: int = 0,
        name: str = "",
        writes: bool = True,
    ):
        """Prepare what does not change.

        The file gives the pieces their names: `fields_NAME.pvd` makes `fields_NAME000000.vtu`.
        Corners are those of the body in its own frame, m, (4, 2) or (8, 3), in VTK's order, which
        is that of `Block.corners`. The index lists the pieces, by the number and the name of the
        body; None: one of its own.
        """
        self._folder, self._stem, self._part, self._name = file.parent, file.stem, part, name
        self._index = PvdIndex(file, writes=writes) if index is None else index
        self._way = self._index.way_to(file.parent)
        self._writes, self._count = writes, 0
        count = len(corners)
        self._piece = PIECE.format(
            count=count,
            points=_array("", corners),
            connectivity=" ".join(map(str, range(count))),
            cell_type=CELL_TYPES[count],
            pressure=_array("contact_pressure", np.zeros(count)),
        )

    def write(self, time: float, displacement: Array, velocity: Array) -> None:
        """Write the body at a time, s, by the motion of its corners relative to the ground, (n, d).

        Displacements, m, are places in the ground frame minus those in the own frame.
        """
        if not self._writes:
            return
        name = f"{self._stem}{self._count:06d}.vtu"
        fields = _array("displacement", displacement), _array("velocity", velocity)
        (self._folder / name).write_text(self._piece.format(*fields), encoding="utf-8")
        self._index.add(time, self._way + name, self._part, self._name)
        self._count += 1


def _array(name: str, values: Array) -> str:
    """An array of a piece: numbers (n,), or vectors (n, 2 or 3), which VTK wants to be three."""
    components = 1 if values.ndim == 1 else 3
    if components == 3:
        values = np.pad(values, ((0, 0), (0, 3 - values.shape[1])))
    numbers = " ".join(f"{value:.17g}" for value in values.ravel().tolist())
    called = f'Name="{name}" ' if name else ""
    return (
        f'<DataArray type="Float64" {called}NumberOfComponents="{components}" format="ascii">'
        f"{numbers}</DataArray>"
    )
