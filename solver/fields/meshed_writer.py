"""Fields of a meshed body for ParaView.

The mesh in the files is the undeformed block, upright at its place; mesh + displacement is where it
is in the ground frame, so "warp by vector" with factor 1 shows the block as it stands.
"""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import numpy as np
from dolfinx import fem

from solver.fields.body_functions import BodyFunctions
from solver.fields.cells import Cells
from solver.fields.function_arrays import cells_of, owned_cells, owned_nodes
from solver.fields.piece import COPIES, PieceWriter, Values, write_parts
from solver.fields.pvd import PvdIndex, entry_of, write_index
from solver.parallel import any_rank


class MeshedFieldWriter:
    """Writes the pieces of one body and lists them in the index; every rank calls every method.

    The functions are written as they are at the time of the call. The stress is the mean over each
    cell; the other fields have the degree of the displacement.
    """

    def __init__(
        self,
        file: Path,
        functions: BodyFunctions,
        *,
        index: PvdIndex,
        part: int = 0,
        name: str = "",
    ):
        """Prepare what does not change.

        The file gives the pieces their names: `fields_NAME.pvd` makes `fields_NAME000000.vtu`. On
        several ranks each has a piece of its own, and `fields_NAME000000.pvtu` opens all of them.
        When the writer is closed the file lists them, too: the body alone. The index lists the
        pieces of all bodies as they are written, by number and name of the body.
        """
        self._functions, self._comm = functions, functions.mesh.comm
        self._file, self._folder, self._stem, self._count = file, file.parent, file.stem, 0
        self._index, self._part, self._name = index, part, name
        self._way = index.way_to(file.parent)
        self._alone: list[bytes] = []
        """What the file is to list."""
        cells = cells_of(functions.space)
        self._piece = PieceWriter(cells)
        self._copies = None if self._comm.size == 1 else copies_of(functions.space, cells)

    def write(self, time: float) -> None:
        """Write the fields at a time (s).

        An OSError is raised where it happens, after all that ranks do together.
        """
        functions = self._functions
        functions.fill()
        for function in functions.all:
            function.x.scatter_forward()
        number, self._count = self._count, self._count + 1  # whatever follows
        trouble, piece = None, ""
        try:
            piece = self._write_piece(number)
        except OSError as error:
            trouble = error
        # Ranks may be killed at any time: what is listed has been written by all of them.
        complete = not any_rank(self._comm, trouble is not None)
        if trouble is not None:
            raise trouble
        if complete:
            self._index.add(time, self._way + piece, self._part, self._name)
            self._alone.append(entry_of(time, piece))

    def _write_piece(self, number: int) -> str:
        """Write the piece of this rank, and on the first of several what opens all pieces.

        Returns the name of what is to be opened.
        """
        nodal, means = self._functions.arrays()
        if self._copies is None:
            piece = f"{self._stem}{number:06d}.vtu"
            self._piece.write(self._folder / piece, nodal, means)
            return piece
        nodal[COPIES], means[COPIES] = self._copies
        whole = f"{self._stem}{number:06d}.pvtu"
        parts = [f"{self._stem}_p{rank}_{number:06d}.vtu" for rank in range(self._comm.size)]
        self._piece.write(self._folder / parts[self._comm.rank], nodal, means)
        if self._comm.rank == 0:
            write_parts(self._folder / whole, parts, nodal, means)
        return whole

    def close(self) -> None:
        """List the pieces of the body alone, if there is room for it."""
        if self._comm.rank == 0:
            with suppress(OSError):
                write_index(self._file, self._alone)


def copies_of(space: fem.FunctionSpace, known: Cells) -> tuple[Values, Values]:
    """Which of the nodes and cells that a rank knows are copies of another's: 1, else 0."""
    nodes = np.zeros(len(known.points), dtype=np.uint8)
    cells = np.zeros(len(known.nodes), dtype=np.uint8)
    nodes[owned_nodes(space) :] = cells[owned_cells(space) :] = 1
    return nodes, cells
