"""Names of the parts of a mesh; the numbers stand here only."""

from enum import IntEnum


class CellTag(IntEnum):
    """Body that a cell belongs to."""

    BLOCK = 1
    FOUNDATION = 2


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
