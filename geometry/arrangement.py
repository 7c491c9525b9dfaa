"""Where a block stands before it moves: offset and tilt."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from geometry.block import Block

Placement = Callable[[NDArray[np.float64]], NDArray[np.float64]]


def pivot(shape: Block, tilt: float) -> tuple[float, float]:
    """The bottom corner about which `tilt` (rad) turns the block, in the block's own frame, m.

    The right one for tilt > 0 (clockwise, leaning towards +x), the left one for tilt < 0, the
    middle of the bottom for 0, where it makes no difference.
    """
    return float(np.sign(tilt)) * shape.width / 2, 0.0


def initial_position(shape: Block, offset: float, tilt: float) -> Placement:
    """The map from the block's own frame to where it stands on the surface y = 0.

    Args:
        shape: The block; its own frame has the origin at the bottom centre, x in [-B/2, B/2],
            y in [0, H].
        offset: Of the bottom centre along x before the tilt, m.
        tilt: Rotation about the bottom corner on that side, rad, positive clockwise; |tilt| < pi/2,
            so that this corner stays the lowest point and touches y = 0.

    Returns:
        The map X -> x of points, (n, 2) -> (n, 2).
    """
    if not abs(tilt) < math.pi / 2:
        raise ValueError(f"tilt: got {tilt} rad, allowed -pi/2 < tilt < pi/2")
    corner = np.array(pivot(shape, tilt))
    c, s = math.cos(tilt), math.sin(tilt)
    rotation = np.array([[c, s], [-s, c]])
    moved = corner + np.array([offset, 0.0])

    def position(points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Where points of the block's own frame stand."""
        stand: NDArray[np.float64] = (points - corner) @ rotation.T + moved
        return stand

    return position
