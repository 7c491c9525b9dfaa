"""Meshes in the plane and in space: which cells there are, how many, and the size they make."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

from geometry.block import Block
from geometry.tags import FINER
from solver.errors import SceneError
from solver.scene.checking import shown
from solver.scene.quantities import Cell, Cells, Dimension

if TYPE_CHECKING:
    from geometry.cells import Cells as MeshCells

SHAPES: dict[Dimension, tuple[Cell, ...]] = {
    2: ("quadrilateral", "triangle"),
    3: ("hexahedron", "tetrahedron"),
}
"""Shapes of cells, the default first."""


CELLS_OF_A_BOX = {"quadrilateral": 1, "triangle": 2, "hexahedron": 1, "tetrahedron": 5}
"""Number of cells into which one box of a structured mesh is divided."""


def cells_in(
    cells: Cells | None, cell: Cell | None, dimension: Dimension, default: Cells
) -> dict[str, Any]:
    """Numbers and shape of cells in a scene of this dimension, by their keys.

    Raises:
        SceneError: They do not fit.
    """
    shapes = SHAPES[dimension]
    if cell is not None and cell not in shapes:
        allowed = f"{' or '.join(map(shown, shapes))} where dimension = {dimension}"
        raise SceneError("cell", shown(cell), allowed)
    return {"cells": cells or default, "cell": cell or shapes[0]}


def refined(cells: Cells, times: Callable[[int], int]) -> Cells:
    """Other numbers of cells; `times` maps each old number to a new one."""
    if len(cells) == 2:
        return times(cells[0]), times(cells[1])
    return times(cells[0]), times(cells[1]), times(cells[2])


def default_cell_size(extents: Sequence[float]) -> float:
    """Length of the edges of the cells of a shape by default, m, by the sides of the box around it.

    A tenth of their geometric mean, in space an eighth, but at most a fourth of the shortest one,
    in space half of it; three digits of that.
    """
    parts, least = (10, 4) if len(extents) == 2 else (8, 2)
    mean = math.prod(extents) ** (1 / len(extents))
    return float(f"{min(mean / parts, min(extents) / least):.3g}")


def mesh_size_in_words(cells: int, cell: Cell, degree: int, nodes: int, dimension: int) -> str:
    """Size of a mesh: cells of which kind and degree, nodes, unknowns."""
    plural = {"hexahedron": "hexahedra", "tetrahedron": "tetrahedra"}.get(cell, f"{cell}s")
    return f"{cells} {plural} of degree {degree}, {nodes} nodes, {dimension * nodes} unknowns"


class MeshSize(NamedTuple):
    """The size of the mesh of an elastic body, as it is known before there is one."""

    kind: Cell
    """Shape of its cells."""
    degree: int
    """Polynomial degree of the displacement."""
    cells: int
    """Number of its cells."""
    nodes: int
    """Number of its nodes."""
    nodes_below: int
    """Number of the nodes at its bottom."""
    corner_cell: tuple[float, ...]
    """Edges along the axes of its smallest cells, of a box those at the bottom corners, m, (d,)."""
    fineness: float
    """Cells over a length, 1/m."""
    words: str = "{}"
    """What to say of it besides its numbers, which stand for {}."""

    def __str__(self) -> str:
        """Its size in words."""
        d = len(self.corner_cell)
        said = mesh_size_in_words(self.cells, self.kind, self.degree, self.nodes, d)
        return self.words.format(said)


def mesh_of_box(
    sides: Sequence[float], cells: Cells, kind: Cell, degree: int, refinement: float = 1.0
) -> MeshSize:
    """The structured mesh of a box, exactly.

    Args:
        sides: Lengths along x, in space y, and upwards, m.
        cells: Numbers of cells along them.
        kind: What the cells are, or are cut into.
        degree: Of the displacement.
        refinement: Longest edges over those at the bottom corners, along each direction.
    """
    nodes = math.prod(degree * count + 1 for count in cells)
    if kind == "tetrahedron" and degree == 2:
        nodes -= math.prod(cells)  # no edge passes through the middle of a box
    corner = [side / count for side, count in zip(sides, cells, strict=True)]
    if refinement != 1:
        from geometry.grading import graded, graded_to_both_ends

        parts = [graded_to_both_ends(count, refinement)[1] for count in cells[:-1]]
        parts.append(graded(cells[-1], refinement)[1])
        corner = [side * float(part) for side, part in zip(sides, parts, strict=True)]
    return MeshSize(
        kind=kind,
        degree=degree,
        cells=math.prod(cells) * CELLS_OF_A_BOX[kind],
        nodes=nodes,
        nodes_below=math.prod(degree * count + 1 for count in cells[:-1]),
        corner_cell=tuple(corner),
        fineness=max(cells[0] / sides[0], cells[-1] / sides[-1]),
    )


@lru_cache(maxsize=64)
def mesh_of_file(shape: Block, cells: MeshCells, degree: int) -> MeshSize:
    """The mesh of a block by the cells of a file; with degree 2 about."""
    count, edge = len(cells.numbers), float(cells.volumes.mean()) ** (1 / 3)
    return MeshSize(
        kind="hexahedron" if cells.name == "hexahedron" else "tetrahedron",
        degree=degree,
        cells=count,
        nodes=cells.nodes if degree == 1 else round(1.6 * count),
        nodes_below=_nodes_below(shape, degree / edge, 3),
        corner_cell=(cells.shortest_edge,) * 3,
        fineness=1.0 / edge,
        words="{}, as in the file",
    )


@lru_cache(maxsize=64)
def mesh_of_shape(shape: Block, size: float, degree: int, dimension: Dimension) -> MeshSize:
    """About the mesh that Gmsh makes of a block by simplices with edges of a length, m."""
    solid = shape.solid
    assert solid is not None
    if solid.surface is not None:
        outside, shortest = solid.surface.area, size / FINER
    else:
        outside = sum(part.area(k) for part in solid.parts for k in range(len(part.faces)))
        shortest = min(size, shape.shortest_edge)
    content = solid.volume / (solid.thickness if dimension == 2 else 1.0)
    cells, nodes = simplices(content, outside, size, degree, dimension)
    return MeshSize(
        kind="triangle" if dimension == 2 else "tetrahedron",
        degree=degree,
        cells=cells,
        nodes=nodes,
        nodes_below=_nodes_below(shape, degree / size, dimension),
        corner_cell=(shortest,) * dimension,
        fineness=1.0 / size,
        words=f"about {{}}, cell_size {size:g} m",
    )


def _nodes_below(shape: Block, each_metre: float, dimension: Dimension) -> int:
    """About how many nodes the bottom of a block has, by those along a line, 1/m."""
    flat = dimension - 1
    across = shape.thickness if flat == 1 else 1.0
    return round(shape.bottom_area / across * each_metre**flat) + 1


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
