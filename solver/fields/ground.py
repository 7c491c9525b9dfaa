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
    half = 2 * max(abs(block.offset) + block.width / 2 for block in standing)
    low = -half / 8
    if scene.dimension == 2:
        return np.array([(-half, low), (half, low), (half, 0.0), (-half, 0.0)])
    deep = 2 * max(abs(block.offset_second) + block.thickness / 2 for block in standing)
    ring = (-half, -deep), (half, -deep), (half, deep), (-half, deep)
    return np.array([(*corner, level) for level in (low, 0.0) for corner in ring])


def floor_level(scene: Scene) -> float:
    """Height of the floor, m: of the ground below whatever carries the blocks."""
    depth = scene.foundation.depth
    return float(platform_corners(scene)[:, -1].min()) if depth is None else -depth


def half_floor(scene: Scene) -> float:
    """Half the length of the floor that is drawn, m.

    Twice what carries the blocks, and room for all of them to lie one beyond the other.
    """
    carrier = _carrier_length(scene)
    lying = 2 * sum(np.hypot(block.width, block.height) for block in scene.blocks)
    aside = max(max(abs(b.offset), abs(b.offset_second)) for b in scene.blocks)
    return float(carrier + lying + aside)


def _carrier_length(scene: Scene) -> float:
    """The longer side of a plate, a deck or the platform in plan, m; 0 on the rigid ground."""
    if scene.foundation.depth is not None:
        return float(max(scene.foundation.top or (0.0,)))
    return float(np.ptp(platform_corners(scene)[:, :-1], axis=0).max())
