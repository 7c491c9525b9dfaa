"""Fields of a rigid body for ParaView, as one cell; without dolfinx or VTK, which take seconds."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from solver.fields.cells import in_space, one_cell
from solver.fields.piece import PieceWriter
from solver.fields.pvd import PvdIndex
from solver.types import Array


def nodal_fields(displacement: Array, velocity: Array) -> dict[str, Array]:
    """The fields of a rigid body at its corners, by the motion of these, (n, d), m and m/s.

    Contact pressure is zero: a rigid body has contact forces, but they have no place on it.
    """
    return {
        "displacement": in_space(displacement),
        "velocity": in_space(velocity),
        "contact_pressure": np.zeros(len(displacement)),
    }


class RigidFieldWriter:
    """Writes a rigid body beside `fields.pvd`, with the fields of an elastic one."""

    def __init__(
        self,
        file: Path,
        corners: Array,
        *,
        index: PvdIndex,
        part: int = 0,
        name: str = "",
        writes: bool = True,
    ):
        """Prepare what does not change.

        The file gives the pieces their names: `fields_NAME.pvd` makes `fields_NAME000000.vtu`.
        Corners are those of the body as it stands upright, m, (4, 2) or (8, 3), in VTK's order,
        which is that of `Block.corners`. The index lists the pieces, by the number and the name of
        the body.
        """
        self._folder, self._stem, self._part, self._name = file.parent, file.stem, part, name
        self._index, self._way = index, index.way_to(file.parent)
        self._writes, self._count = writes, 0
        self._piece = PieceWriter(one_cell(corners))

    def write(self, time: float, displacement: Array, velocity: Array) -> None:
        """Write the body at a time, s, by the motion of its corners relative to the ground, (n, d).

        Displacements, m, are places in the ground frame minus those where it stands upright.
        """
        if not self._writes:
            return
        name = f"{self._stem}{self._count:06d}.vtu"
        self._piece.write(self._folder / name, nodal_fields(displacement, velocity), {})
        self._index.add(time, self._way + name, self._part, self._name)
        self._count += 1
