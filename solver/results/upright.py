"""Positions of blocks at rest, and their gravity energy above these."""

from __future__ import annotations

import numpy as np

from solver.history.history import History
from solver.results.motion import centres
from solver.scene import BlockSpec, Scene
from solver.types import Array


def upright_centre(scene: Scene, block: BlockSpec) -> Array:
    """Centre of a block that stands upright at its place, on all that carries it, m, (d,).

    In the frame of the foundation: its surface is at level 0, its centre at x = 0.
    """
    middle = np.zeros(scene.dimension)
    middle[-1] = block.height / 2
    return scene.poses(upright=True)[block.name](middle[None])[0]


def gravity_above_upright(scene: Scene, history: History) -> Array:
    """Gravity energy of all blocks above that of their upright places, J, over the rows."""
    gravity = np.array(scene.gravity_vector)
    energy = np.zeros(len(history))
    for block in scene.blocks:
        raised = centres(history, block.name) - upright_centre(scene, block)
        energy -= block.shape.mass * (raised @ gravity)
    return energy
