"""The mesh of a frame, a deck on columns."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

from mpi4py import MPI

import numpy as np

from geometry.foundation import Frame
from geometry.gmsh_model import MeshedBody
from geometry.mesh import grid_mesh
from geometry.tags import FacetTag
from solver.types import Array, Mask


@dataclass(frozen=True, slots=True, kw_only=True)
class FrameCells:
    """Numbers of cells along the parts of a frame, each >= 1."""

    bay: int = 8
    """Along the deck from column to column."""
    bay_across: int | None = None
    """Across the plane of motion from column to column, in space; None: as `bay`."""
    column: int = 2
    """Across a column, in space in both directions."""
    deck: int = 2
    """Over the height of the deck."""
    storey: int = 12
    """Along a column."""


def frame_mesh(
    frame: Frame,
    *,
    dimension: int = 2,
    cells: FrameCells | None = None,
    cell: str | None = None,
    comm: MPI.Intracomm = MPI.COMM_WORLD,
) -> MeshedBody:
    """Mesh a frame with its origin at the centre of the deck's top; collective.

    It has x in [-W/2, W/2], in space y in [-t/2, t/2], the deck from -h to 0 and the columns below
    it: in the plane a portal, in space a deck on four columns, with one bay. `cell` is as in
    `block_mesh`.
    """
    cells = cells or FrameCells()
    deck, up = frame.deck, [cells.storey, cells.deck] * (len(frame.below) + 1)
    columns = [(deck.width, frame.column_width, frame.bays, cells.bay)]
    if dimension == 3:
        across = cells.bay_across or cells.bay
        columns.append((deck.thickness, frame.column_thickness or frame.column_width, 1, across))
    lines, where = [], []
    for length, column, bays, bay in columns:
        counts = [cells.column, *([bay, cells.column] * bays)]
        line = _refined(_column_breaks(length, column, bays), counts)
        lines.append((line - line[::-1]) / 2)  # symmetric to the last digit
        where.append(_every_second(counts))
    lines.append(_refined(frame.levels, up))
    # All boxes of decks; below them those where every direction has a column.
    in_columns = np.logical_and.reduce(np.meshgrid(*where, indexing="ij"))
    there = in_columns[..., None] | ~_every_second(up)
    return grid_mesh("frame", lines, cell, comm, there=there, lowest=FacetTag.FEET)


def _column_breaks(length: float, column: float, bays: int) -> Array:
    """Places along the deck where columns begin and end, from -length/2 to length/2."""
    begin = np.linspace(-length / 2, length / 2 - column, bays + 1)
    return np.column_stack([begin, begin + column]).ravel()


def _every_second(counts: list[int]) -> Mask:
    """True in the cells of the first, the third, ... part of a line."""
    return np.repeat(np.arange(len(counts)) % 2 == 0, counts)


def _refined(breaks: Array, counts: list[int]) -> Array:
    """Lines between breaks, by the numbers of cells between them."""
    parts = [
        np.linspace(a, b, cells, endpoint=False)
        for (a, b), cells in zip(pairwise(breaks), counts, strict=True)
    ]
    return np.concatenate([*parts, breaks[-1:]])
