"""Where the blocks of a scene stand at the start: block by block, each on what carries it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from geometry.arrangement import Pose, initial_position, initial_position_in_space, on_top
from solver.scene.block import BlockSpec

if TYPE_CHECKING:
    from solver.scene.scene import Scene

Drift = tuple[float, float]


def poses(scene: Scene, *, upright: bool = False, drift: Drift = (0.0, 0.0)) -> dict[str, Pose]:
    """For each block, by its name, the rigid motion from its own frame to where it stands.

    `upright`: as if nothing were tilted; `drift` is where the platform is along x and y, m.
    """
    placed: dict[str, Pose] = {}
    for spec in scene.order:
        carrier = scene.carrier_of(spec)
        pose = _on_level(
            spec,
            scene.dimension,
            tilt=0.0 if upright else spec.tilt,
            drift=drift if carrier is None else (0.0, 0.0),
        )
        if carrier is not None:
            pose = on_top(placed[carrier.name], carrier.height, pose)
        placed[spec.name] = pose
    return placed


def stands(scene: Scene) -> dict[str, tuple[Pose, Pose]]:
    """For each block two rigid motions, by its name.

    The first takes the block's own frame to where it would stand if nothing was tilted (a
    translation: there it is meshed), the second goes on from there to where it starts.
    """
    upright = poses(scene, upright=True)
    return {
        name: (
            upright[name],
            Pose(
                rotation=pose.rotation,
                about=upright[name](pose.about[None])[0],
                place=pose.place,
            ),
        )
        for name, pose in poses(scene).items()
    }


def _on_level(spec: BlockSpec, dimension: int, *, tilt: float, drift: Drift) -> Pose:
    """Where a block would stand on a surface at level 0 whose origin is below its carrier."""
    along = spec.offset + drift[0]
    if dimension == 2:
        return initial_position(spec.shape, along, tilt)
    offset = along, spec.offset_second + drift[1]
    return initial_position_in_space(spec.shape, offset, tilt, spec.tilt_direction)
