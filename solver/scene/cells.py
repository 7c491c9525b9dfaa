"""Meshes in the plane and in space: which cells there are, and how many numbers count them."""

from __future__ import annotations

from typing import Protocol

from solver.errors import SceneError
from solver.scene.checking import is_open, shown
from solver.scene.ranges import Cell, Cells, Dimension

SHAPES: dict[Dimension, tuple[Cell, ...]] = {
    2: ("quadrilateral", "triangle"),
    3: ("hexahedron", "tetrahedron"),
}
"""Shapes of cells, the default first."""


class HasCells(Protocol):
    """What has cells; None stands for the default of the dimension."""

    @property
    def cells(self) -> Cells:
        """Numbers of cells."""

    @property
    def cell(self) -> Cell:
        """Their shape."""


def cells_of(spec: HasCells, dimension: Dimension, default: Cells) -> Cells:
    """The numbers of cells in a scene of this dimension; SceneError if they do not fit."""
    if is_open(spec.cells):
        return default
    if len(spec.cells) != dimension:
        allowed = (
            f"{dimension} values, each a whole number, cells >= 1, where dimension = {dimension}"
        )
        raise SceneError("cells", shown(spec.cells), allowed)
    return spec.cells


def cell_of(spec: HasCells, dimension: Dimension) -> Cell:
    """The shape of the cells in a scene of this dimension; SceneError if it does not fit."""
    shapes = SHAPES[dimension]
    if is_open(spec.cell):
        return shapes[0]
    if spec.cell not in shapes:
        allowed = f"{' or '.join(map(shown, shapes))} where dimension = {dimension}"
        raise SceneError("cell", shown(spec.cell), allowed)
    return spec.cell
