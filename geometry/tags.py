"""Names of the parts of a mesh; the numbers stand here only."""

from enum import IntEnum


class CellTag(IntEnum):
    """What a cell belongs to."""

    BLOCK = 1


class FacetTag(IntEnum):
    """The sides of a block, in the frame of the block."""

    BOTTOM = 1
    RIGHT = 2
    TOP = 3
    LEFT = 4
