"""Blocks that start inside one another are refused: only a block and its carrier feel contact."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from geometry.boxes import Boxes, overlap_depth
from solver.errors import Statement
from solver.scene.places import poses

if TYPE_CHECKING:
    from geometry.arrangement import Pose
    from solver.scene.block import BlockSpec
    from solver.scene.scene import Scene

ROUND_OFF = 1e-9
"""Blocks that overlap by less than this part of their size touch."""


def refuse_overlaps(scene: Scene) -> None:
    """Refuse blocks that overlap at the start, unless one carries the other.

    Raises:
        Statement: Names two such blocks and the depth.
    """
    placed = poses(scene)
    boxes = {b.name: box_of(b, placed[b.name], scene.dimension) for b in scene.blocks}
    for first, second in scene.strangers():
        depth = float(overlap_depth(boxes[first.name], boxes[second.name])[0])
        size = max(first.shape.half_diagonal, second.shape.half_diagonal)
        if depth > ROUND_OFF * size:
            raise Statement(
                f"blocks {first.name} and {second.name}",
                f"overlap by {depth:.4g} m at the start: move one (offset), or let one carry "
                f"the other (on)",
            )


def box_of(block: BlockSpec, pose: Pose, dimension: int) -> Boxes:
    """A block as a box where it stands."""
    half = np.array(block.shape.half_lengths(dimension))
    middle = np.zeros(dimension)
    middle[-1] = half[-1]
    return Boxes(half=half, centres=pose(middle[None]), frames=pose.rotation[None])
