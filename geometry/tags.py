"""Names of the parts of a mesh; the numbers stand here only."""

from collections.abc import Sequence
from enum import IntEnum

ALL_CELLS = 1
"""Tag of all cells of a mesh: of a Gmsh model only what has one is handed over."""


class FacetTag(IntEnum):
    """The sides of a body, in its own frame; the last four in space or on columns only."""

    BOTTOM = 1
    RIGHT = 2
    """Towards +x."""
    TOP = 3
    LEFT = 4
    """Towards -x."""
    FRONT = 5
    """Towards -y."""
    BACK = 6
    """Towards +y."""
    FEET = 7
    """Feet of the columns, which are clamped."""
    FREE = 8
    """Tops that carry nothing, of storeys below the one that the blocks stand on."""


FINER = 4
"""Segments of a sharp edge of a surface for each length of a cell, at most: it keeps its own
corners up to this number."""


def tags_of_faces(upwards: Sequence[float]) -> tuple[int, ...]:
    """Tags of the faces of a convex body, by the upward components of their unit normals.

    The face that looks most downwards is the bottom, the one that looks most upwards the top; the
    others have numbers beyond those of `FacetTag`. Of equal ones it is the first.
    """
    rises = [round(float(rise), 9) for rise in upwards]
    named = {rises.index(min(rises)): FacetTag.BOTTOM, rises.index(max(rises)): FacetTag.TOP}
    first = len(FacetTag) + 1
    return tuple(int(named.get(number, first + number)) for number in range(len(rises)))
