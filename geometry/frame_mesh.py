"""The mesh of a frame, a deck on columns, and of other unions of boxes of a coarse grid."""

from __future__ import annotations

from dataclasses import dataclass, fields
from itertools import pairwise, product

from mpi4py import MPI

import gmsh
import numpy as np

from geometry.foundation import Frame
from geometry.gmsh_model import CELLS, MeshedBody, make, split_into_simplices
from geometry.tags import ALL_CELLS, FacetTag
from solver.types import Array

Box = tuple[int, ...]
"""A box of the coarse grid, by its place along each direction."""


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

    def __post_init__(self) -> None:
        """Refuse numbers that leave no cells."""
        for field in fields(self):
            count = getattr(self, field.name)
            if count is not None and count < 1:
                raise ValueError(
                    f"FrameCells.{field.name}: got {count}, allowed a whole number >= 1"
                )


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
    if dimension not in (2, 3) or (dimension == 3 and frame.bays != 1):
        raise ValueError(
            f"frame_mesh: got dimension {dimension} with {frame.bays} bays, allowed 2, or 3 with 1"
        )
    cells = cells or FrameCells()
    along_x = column_breaks(frame.deck.width, frame.column_width, frame.bays)
    lines, counts = [along_x], [alternate_counts(frame.bays, cells.bay, cells.column)]
    if dimension == 3:
        column = frame.column_thickness or frame.column_width
        lines.append(column_breaks(frame.deck.thickness, column, 1))
        counts.append(alternate_counts(1, cells.bay_across or cells.bay, cells.column))
    lines.append(frame.levels)
    counts.append([cells.storey, cells.deck] * (len(frame.below) + 1))
    # All boxes of decks; below them those where every direction has a column.
    boxes = [
        place
        for place in product(*(range(len(count)) for count in counts))
        if place[-1] % 2 == 1 or all(index % 2 == 0 for index in place[:-1])
    ]
    return boxes_mesh(lines, counts, boxes, carries=len(counts[-1]) - 1, cell=cell, comm=comm)


def column_breaks(length: float, column: float, bays: int) -> Array:
    """Places along the deck where columns begin and end, from -length/2 to length/2."""
    bay = (length - (bays + 1) * column) / bays
    if not bay > 0:
        raise ValueError(
            f"frame_mesh: {bays + 1} columns of {column} m do not fit below {length} m"
        )
    begin = np.arange(bays + 1) * (column + bay) - length / 2
    breaks = np.column_stack([begin, begin + column]).ravel()
    symmetric: Array = (breaks - breaks[::-1]) / 2
    return symmetric


def alternate_counts(bays: int, bay: int, column: int) -> list[int]:
    """Numbers of cells of column, bay, column, ..."""
    return [column, *([bay, column] * bays)]


def boxes_mesh(
    lines: list[Array],
    counts: list[list[int]],
    boxes: list[Box],
    *,
    carries: int,
    cell: str | None = None,
    comm: MPI.Intracomm = MPI.COMM_WORLD,
) -> MeshedBody:
    """Mesh a union of boxes of a coarse grid, which stands on its lowest boxes; collective.

    The grid has lines along x, in space along y, and upwards, m, with numbers of cells between
    them; boxes are given by their places along each direction. Blocks stand on the tops of the
    boxes whose place upwards is `carries`. `cell` is as in `block_mesh`.
    """
    dimension = len(lines)
    if cell not in (None, *CELLS[dimension]):
        raise ValueError(f"boxes_mesh: got cell {cell!r}, allowed one of {CELLS[dimension]}")
    simplices = cell == CELLS[dimension][1]
    builder = _Boxes(lines, counts, carries)
    return make("boxes", lambda: _mesh_boxes(builder, boxes, simplices), dimension, comm)


def _mesh_boxes(builder: _Boxes, boxes: list[Box], simplices: bool) -> None:
    """Mesh a union of boxes in the current Gmsh model, tags included."""
    lines, counts = builder.lines, builder.counts
    solids = [builder.solid(place) for place in boxes]
    gmsh.model.geo.synchronize()
    dimension = len(lines)
    gmsh.model.addPhysicalGroup(dimension, solids, ALL_CELLS)
    for tag, faces in builder.outside(boxes).items():
        gmsh.model.addPhysicalGroup(dimension - 1, faces, tag)
    gmsh.model.mesh.generate(dimension)
    if simplices:
        split_into_simplices(
            [_refined(line, count) for line, count in zip(lines, counts, strict=True)]
        )


def _refined(line: Array, count: list[int]) -> Array:
    """The lines of the fine grid between those of the coarse one."""
    parts = [
        np.linspace(a, b, cells, endpoint=False)
        for (a, b), cells in zip(pairwise(line), count, strict=True)
    ]
    return np.concatenate([*parts, line[-1:]])


class _Boxes:
    """Transfinite boxes of a coarse grid that share points, lines and faces where they touch."""

    def __init__(self, lines: list[Array], counts: list[list[int]], carries: int):
        """Take the coarse grid, the numbers of cells between its lines, and which layer carries."""
        self.lines, self.counts, self.dimension = lines, counts, len(lines)
        self.carries = carries
        self._made: dict[tuple[Box, Box], int] = {}

    def solid(self, place: Box) -> int:
        """The box itself: a surface in the plane, a volume in space."""
        return self._part(place, (1,) * self.dimension)

    def _part(self, low: Box, span: Box) -> int:
        """The part of the coarse grid from `low` on that spans one cell in the marked directions.

        Made where it does not exist yet: a point spans no direction, a line one.
        """
        key = low, span
        if key not in self._made:
            make = (self._point, self._line, self._surface, self._volume)[sum(span)]
            self._made[key] = make(low, span)
        return self._made[key]

    def _point(self, low: Box, _: Box) -> int:
        """A node of the coarse grid."""
        place = [float(line[index]) for line, index in zip(self.lines, low, strict=True)]
        return int(gmsh.model.geo.addPoint(*place, *[0.0] * (3 - self.dimension)))

    def _line(self, low: Box, span: Box) -> int:
        """A line with nodes at equal distances."""
        direction = span.index(1)
        ends = [self._part(end, (0,) * self.dimension) for end in (low, _next(low, direction))]
        line = int(gmsh.model.geo.addLine(*ends))
        nodes = self.counts[direction][low[direction]] + 1
        gmsh.model.geo.mesh.setTransfiniteCurve(line, nodes)
        return line

    def _surface(self, low: Box, span: Box) -> int:
        """A rectangle of quadrilaterals."""
        geo = gmsh.model.geo
        first, second = (k for k in range(self.dimension) if span[k])
        alone = [
            tuple(int(k == chosen) for k in range(self.dimension)) for chosen in (first, second)
        ]
        loop = [
            self._part(low, alone[0]),
            self._part(_next(low, first), alone[1]),
            -self._part(_next(low, second), alone[0]),
            -self._part(low, alone[1]),
        ]
        surface = int(geo.addPlaneSurface([geo.addCurveLoop(loop)]))
        geo.mesh.setTransfiniteSurface(surface)
        geo.mesh.setRecombine(2, surface)
        return surface

    def _volume(self, low: Box, span: Box) -> int:
        """A box of hexahedra."""
        geo = gmsh.model.geo
        shell = [self._part(*face) for direction in range(3) for face in _faces(low, direction)]
        volume = int(geo.addVolume([geo.addSurfaceLoop(shell)]))
        geo.mesh.setTransfiniteVolume(volume)
        return volume

    def outside(self, boxes: list[Box]) -> dict[FacetTag, list[int]]:
        """The faces that belong to one box only, by their direction and what they are."""
        present, found = set(boxes), dict[FacetTag, list[int]]()
        for place, direction, up in product(boxes, range(self.dimension), (False, True)):
            across = _next(place, direction, 1 if up else -1)
            if across not in present:
                face = _faces(place, direction)[up]
                tag = self._tag(place, direction, up)
                found.setdefault(tag, []).append(self._part(*face))
        return found

    def _tag(self, place: Box, direction: int, up: bool) -> FacetTag:
        """The side that a face points to; the undersides of the lowest boxes are feet."""
        if direction == self.dimension - 1:
            down = FacetTag.BOTTOM if place[-1] else FacetTag.FEET
            top = FacetTag.TOP if place[-1] == self.carries else FacetTag.FREE
            return top if up else down
        sides = ((FacetTag.LEFT, FacetTag.RIGHT), (FacetTag.FRONT, FacetTag.BACK))
        return sides[direction][up]


def _next(place: Box, direction: int, step: int = 1) -> Box:
    """The place one step further in one direction."""
    return tuple(index + step * (k == direction) for k, index in enumerate(place))


def _faces(place: Box, direction: int) -> tuple[tuple[Box, Box], tuple[Box, Box]]:
    """Lower and upper face of a box across one direction: where they begin, what they span."""
    span = tuple(int(k != direction) for k in range(len(place)))
    return (place, span), (_next(place, direction), span)
