"""Ground below the blocks in pictures: the platform, which a scene gives no size, and the floor."""

from __future__ import annotations

import numpy as np

from solver.scene import Scene
from solver.types import Array


def platform_corners(scene: Scene) -> Array:
    """Corners of the platform as it is drawn, m, (4, 2) or (8, 3), its top at level 0.

    Twice as wide as where the blocks stand, a quarter of half that high; in VTK's order.
    """
    standing = [block for block in scene.blocks if scene.carrier_of(block) is None]
    aside = {name: np.abs(place) for name, place in _places(scene).items()}
    half = 2 * max(aside[block.name][0] + block.width / 2 for block in standing)
    low = -half / 8
    if scene.dimension == 2:
        return np.array([(-half, low), (half, low), (half, 0.0), (-half, 0.0)])
    deep = 2 * max(aside[block.name][1] + block.thickness / 2 for block in standing)
    ring = (-half, -deep), (half, -deep), (half, deep), (-half, deep)
    return np.array([(*corner, level) for level in (low, 0.0) for corner in ring])


def floor_level(scene: Scene) -> float:
    """Height of the floor, m: of the ground below whatever carries the blocks."""
    depth = scene.foundation.depth
    return float(platform_corners(scene)[:, -1].min() if depth is None else -depth)


def half_floor(scene: Scene) -> float:
    """Half the length of the floor that is drawn, m.

    Twice what carries the blocks, and room for all of them to lie one beyond the other.
    """
    carrier = _carrier_length(scene)
    lying = 2 * sum(np.hypot(block.width, block.height) for block in scene.blocks)
    aside = max(np.abs(place).max() for place in _places(scene).values())
    return float(carrier + lying + aside)


def _places(scene: Scene) -> dict[str, Array]:
    """Places of the blocks in plan at the start, as if nothing was tilted, m, by their names."""
    return {name: pose.place[:-1] for name, pose in scene.poses(upright=True).items()}


def _carrier_length(scene: Scene) -> float:
    """The longer side of a plate, a deck or the platform in plan, m; 0 on the rigid ground."""
    if scene.foundation.depth is not None:
        return float(max(scene.foundation.top or (0.0,)))
    return float(np.ptp(platform_corners(scene)[:, :-1], axis=0).max())
