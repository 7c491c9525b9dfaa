"""Places of blocks at the start, each on what carries it; places that cannot be are refused."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from geometry.arrangement import Pose, initial_position, initial_position_in_space, on_top
from geometry.boxes import Boxes, overlap_depth
from solver.errors import Statement
from solver.scene.block import BlockSpec
from solver.scene.quantities import Dimension

Drift = tuple[float, float]

ROUND_OFF = 1e-9
"""Blocks that overlap by less than this part of their size touch."""


def poses(
    blocks: Sequence[BlockSpec],
    dimension: Dimension,
    *,
    upright: bool = False,
    drift: Drift = (0.0, 0.0),
) -> dict[str, Pose]:
    """For each block, by its name, the rigid motion from its own frame to its place at the start.

    Args:
        blocks: Each after its carrier.
        dimension: Of space.
        upright: As if nothing were tilted.
        drift: Place of the platform along x and y, m.
    """
    placed: dict[str, Pose] = {}
    heights = {block.name: block.height for block in blocks}
    for spec in blocks:
        carried = spec.on in placed
        start = (0.0, 0.0) if carried else drift
        pose = _on_level(spec, dimension, tilt=0.0 if upright else spec.tilt, drift=start)
        if carried:
            pose = on_top(placed[spec.on], heights[spec.on], pose)
        placed[spec.name] = pose
    return placed


def stands(blocks: Sequence[BlockSpec], dimension: Dimension) -> dict[str, tuple[Pose, Pose]]:
    """For each block two rigid motions, by its name; blocks as in `poses`.

    The first takes the block's own frame to where it would stand if nothing was tilted (a
    translation: there it is meshed), the second goes on from there to where it starts.
    """
    upright = poses(blocks, dimension, upright=True)
    return {
        name: (
            upright[name],
            Pose(
                rotation=pose.rotation,
                about=upright[name](pose.about[None])[0],
                place=pose.place,
            ),
        )
        for name, pose in poses(blocks, dimension).items()
    }


def _on_level(spec: BlockSpec, dimension: Dimension, *, tilt: float, drift: Drift) -> Pose:
    """Place of a block on a surface at level 0 whose origin is below its carrier."""
    along = spec.offset + drift[0]
    if dimension == 2:
        return initial_position(spec.shape, along, tilt)
    offset = along, spec.offset_second + drift[1]
    return initial_position_in_space(spec.shape, offset, tilt, spec.tilt_direction)


def refuse_overlaps(
    blocks: Sequence[BlockSpec],
    dimension: Dimension,
    pairs: Iterable[tuple[BlockSpec, BlockSpec]],
) -> None:
    """Refuse pairs of blocks, all of them as in `poses`, that overlap at the start.

    Raises:
        Statement: Names two such blocks and the depth.
    """
    placed = poses(blocks, dimension)
    boxes = {block.name: _box(block, placed[block.name], dimension) for block in blocks}
    for first, second in pairs:
        depth = float(overlap_depth(boxes[first.name], boxes[second.name])[0])
        size = max(first.shape.half_diagonal, second.shape.half_diagonal)
        if depth > ROUND_OFF * size:
            raise Statement(
                f"blocks {first.name} and {second.name}",
                f"overlap by {depth:.4g} m at the start: move one (offset), or let one carry "
                f"the other (on)",
            )


def _box(block: BlockSpec, pose: Pose, dimension: Dimension) -> Boxes:
    """A block as a box at its place."""
    half = np.array(block.shape.half_lengths(dimension))
    middle = np.zeros(dimension)
    middle[-1] = half[-1]
    return Boxes(half=half, centres=pose(middle[None]), frames=pose.rotation[None])
