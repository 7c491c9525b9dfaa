"""Meshes in the plane and in space: which cells there are, how many, and the size they make."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Protocol

from solver.errors import SceneError
from solver.scene.checking import is_open, shown
from solver.scene.quantities import Cell, Cells, Dimension

SHAPES: dict[Dimension, tuple[Cell, ...]] = {
    2: ("quadrilateral", "triangle"),
    3: ("hexahedron", "tetrahedron"),
}
"""Shapes of cells, the default first."""


CELLS_OF_A_BOX = {"quadrilateral": 1, "triangle": 2, "hexahedron": 1, "tetrahedron": 5}
"""Number of cells into which one box of a structured mesh is divided."""


class HasCells(Protocol):
    """A body with cells; None stands for the default of the dimension."""

    @property
    def cells(self) -> Cells:
        """Numbers of cells."""

    @property
    def cell(self) -> Cell:
        """Their shape."""


class HasMesh(HasCells, Protocol):
    """A body with a structured mesh, nothing left open."""

    @property
    def degree(self) -> int:
        """Polynomial degree of the displacement."""


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


def refined(cells: Cells, times: Callable[[int], int]) -> Cells:
    """Other numbers of cells; `times` maps each old number to a new one."""
    if len(cells) == 2:
        return times(cells[0]), times(cells[1])
    return times(cells[0]), times(cells[1]), times(cells[2])


def box_nodes(body: HasMesh) -> int:
    """Number of nodes of the structured mesh of a box."""
    nodes = math.prod(body.degree * count + 1 for count in body.cells)
    if body.cell == "tetrahedron" and body.degree == 2:
        nodes -= math.prod(body.cells)  # no edge passes through the middle of a box
    return nodes


def default_cell_size(extents: Sequence[float]) -> float:
    """Length of the edges of the cells of a shape by default, m, by the sides of the box around it.

    A tenth of their geometric mean, in space an eighth, but at most a fourth of the shortest one,
    in space half of it; three digits of that.
    """
    parts, least = (10, 4) if len(extents) == 2 else (8, 2)
    mean = math.prod(extents) ** (1 / len(extents))
    return float(f"{min(mean / parts, min(extents) / least):.3g}")


def simplices(
    content: float, surface: float, size: float, degree: int, dimension: Dimension
) -> tuple[int, int]:
    """About how many cells and nodes Gmsh makes of a convex shape.

    Args:
        content: Its area, m2, or volume, m3.
        surface: Length of its outline, m, or area of its surface, m2.
        size: Length of the edges of the cells, m.
        degree: Of the displacement.
        dimension: Of space.
    """
    if dimension == 2:
        cells, outside = 2.4 * content / size**2, surface / size
        nodes = 1 + (cells + outside) / 2
        edges = (3 * cells + outside) / 2
    else:
        cells, outside = 4.8 * content / size**3 + surface / size**2, 2.4 * surface / size**2
        nodes = 1 + cells / 5.5 + outside / 4
        edges = nodes + cells + outside / 2
    return max(round(cells), 1), max(round(nodes + (edges if degree == 2 else 0)), dimension + 1)


def box_mesh_size(body: HasMesh, dimension: Dimension) -> str:
    """Size of the structured mesh of a box, in words."""
    count = math.prod(body.cells) * CELLS_OF_A_BOX[body.cell]
    return mesh_size_in_words(count, body.cell, body.degree, box_nodes(body), dimension)


def mesh_size_in_words(cells: int, cell: Cell, degree: int, nodes: int, dimension: int) -> str:
    """Size of a mesh: cells of which kind and degree, nodes, unknowns."""
    plural = {"hexahedron": "hexahedra", "tetrahedron": "tetrahedra"}.get(cell, f"{cell}s")
    return f"{cells} {plural} of degree {degree}, {nodes} nodes, {dimension * nodes} unknowns"
