"""Where the blocks of a scene stand at the start: block by block, each on what carries it."""

from __future__ import annotations

from geometry.arrangement import Pose, initial_position, initial_position_in_space, on_top
from solver.scene import Scene
from solver.specs import BlockSpec


def stands(scene: Scene) -> dict[str, tuple[Pose, Pose]]:
    """For each block two rigid motions, by its name.

    The first takes the block's own frame to where it would stand if nothing was tilted (a
    translation: there it is meshed), the second goes on from there to where it starts.
    """
    upright: dict[str, Pose] = {}
    tilted: dict[str, Pose] = {}
    heights = {block.name: block.height for block in scene.blocks}
    for spec in scene.order:
        straight, leaning = (_pose(spec, scene.dimension, tilt) for tilt in (0.0, spec.tilt))
        if spec.on in heights:
            below = heights[spec.on]
            straight = on_top(upright[spec.on], below, straight)
            leaning = on_top(tilted[spec.on], below, leaning)
        upright[spec.name], tilted[spec.name] = straight, leaning
    return {
        name: (
            upright[name],
            Pose(
                rotation=pose.rotation,
                about=upright[name](pose.about[None])[0],
                place=pose.place,
            ),
        )
        for name, pose in tilted.items()
    }


def _pose(spec: BlockSpec, dimension: int, tilt: float) -> Pose:
    """Where a block would stand on a surface at level 0 whose origin is below its carrier."""
    if dimension == 2:
        return initial_position(spec.shape, spec.offset, tilt)
    offset = (spec.offset, spec.offset_second)
    return initial_position_in_space(spec.shape, offset, tilt, spec.tilt_direction)
