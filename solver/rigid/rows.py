"""Rows of the history of rigid bodies, from the states that the compiled steps leave."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from geometry.block import Block
from geometry.outline import rolls
from geometry.top import top_over_centre
from solver.history.block_columns import (
    contact_columns,
    force_columns,
    has_lost_carrier,
    plane_motion,
    space_motion,
)
from solver.history.engine_rows import of_owner
from solver.kernels.world import Steps
from solver.types import Array


def rotation_matrices(rotation: Array) -> Array:
    """Rotation matrices (..., d, d) of angles (..., 1), anticlockwise, or quaternions (..., 4)."""
    if rotation.shape[-1] == 1:
        c, s = np.cos(rotation[..., 0]), np.sin(rotation[..., 0])
        return np.stack([np.stack([c, -s], -1), np.stack([s, c], -1)], -2)
    w, x, y, z = np.moveaxis(rotation, -1, 0)
    return np.stack(
        [
            np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], -1),
            np.stack([2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], -1),
            np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], -1),
        ],
        -2,
    )


def quaternion_of(rotation: Array) -> Array:
    """The unit quaternion (w, x, y, z) of a rotation matrix, w >= 0."""
    from scipy.spatial.transform import Rotation

    x, y, z, w = Rotation.from_matrix(rotation).as_quat()
    return np.array([w, x, y, z]) * (1.0 if w >= 0 else -1.0)


class BlockRows:
    """Writer of the columns of blocks."""

    def __init__(self, blocks: Mapping[str, Block], carriers: Sequence[int], d: int):
        """Keep what its columns take of each block, by their names.

        `carriers` are the numbers of the bodies that carry the blocks, or the number of blocks for
        what carries all.
        """
        self._names, self._carriers, self._d = list(blocks), carriers, d
        shapes = list(blocks.values())
        self._bottoms = np.array(
            [np.array(shape.bottom_corners(d)) - shape.centre_of_mass(d) for shape in shapes]
        )
        """Corners of their bottoms about the centres of mass, m, (n, 2^(d-1), d)."""
        self._tops = [shape.height - shape.centre_height for shape in shapes]
        """Levels of their highest corners over these, m."""
        self._holds = [top_over_centre(shape, d) for shape in shapes]
        """Levels of the lowest corners of their tops, which hold others, m."""
        self._rolls = [rolls(shape, d) for shape in shapes]
        """True where a top is always level."""
        parts = [1 if shape.solid is None else len(shape.solid.parts) for shape in shapes]
        ends = np.cumsum([count if count > 1 else 0 for count in parts])
        self._feet = [range(end - shape.feet, end) for shape, end in zip(shapes, ends, strict=True)]
        """Numbers of their feet among the parts of all bodies that have several."""

    def lean(self, steps: Steps, frames: Array, before: Array) -> Array:
        """Lean towards +x of all blocks after steps, carried on, rad, (steps, n).

        `frames` has the rotation matrices of all bodies.
        """
        if self._d == 2:
            return -steps.turned[:, :-1, 0]
        lean = np.arctan2(frames[:, :-1, 0, 2], frames[:, :-1, 2, 2])
        return np.unwrap(np.concatenate([before[None], lean]), axis=0)[1:]

    def columns(self, steps: Steps, dt: float, lean: Array) -> tuple[dict[str, Any], Array]:
        """The columns of the blocks for all steps but the first, and the last lean."""
        frames = rotation_matrices(steps.rotation)
        leans = self.lean(steps, frames, lean)[1:]
        known = dict[str, Any]()
        for b, (name, carrier) in enumerate(zip(self._names, self._carriers, strict=True)):
            known |= of_owner(name, self._motion(steps, b, leans[:, b]))
            contact, mean = self._contact(steps, frames, b, carrier, dt)
            known |= of_owner(name, contact)
            for foot, part in enumerate(self._feet[b], start=1):
                force = (steps.parts[1:, part, None, :] @ mean)[:, 0].T / dt
                known |= of_owner(f"{name}.foot_{foot}", force_columns(np.roll(force, 1, axis=0)))
        return known, leans[-1]

    def _motion(self, steps: Steps, b: int, lean: Array) -> dict[str, Any]:
        """The columns that follow from the motion of a block."""
        spin, centre = steps.spin[1:, b].T, steps.centre[1:, b].T
        if self._d == 2:
            return plane_motion(lean, -spin[0], centre)
        return space_motion(lean, steps.turned[1:, b].T, spin, centre)

    def _contact(
        self, steps: Steps, frames: Array, b: int, carrier: int, dt: float
    ) -> tuple[dict[str, Any], Array]:
        """Slip, gaps, penetration and forces: over the carrier, or level ground once it is lost.

        And the axes of the forces as columns, (steps, d, d).
        """
        d, base = self._d, len(self._carriers)
        level = np.eye(d)
        centre = steps.centre[1:, b]
        over_ground = centre - steps.centre[1:, base] * (1 - level[-1])
        if carrier == base:
            half: Array = np.zeros(len(centre))
            below = mean = np.broadcast_to(level, (len(centre), d, d))
            shift = over_ground
        else:
            below, mean = frames[1:, carrier], (frames[:-1, carrier] + frames[1:, carrier]) / 2
            if self._rolls[carrier]:  # on what is uppermost
                below = mean = np.broadcast_to(level, below.shape)
            height = self._tops[carrier]
            shift = centre - steps.centre[1:, carrier]
            above = np.einsum("si,si->s", below[:, :, -1], shift)
            lost = has_lost_carrier(below[:, -1, -1], above, self._holds[carrier])
            below = np.where(lost[:, None, None], level, below)
            mean = np.where(lost[:, None, None], level, mean)
            shift = np.where(lost[:, None], over_ground, shift)
            half = np.where(lost, 0.0, height)
        arms = np.einsum("sij,kj->ski", frames[1:, b], self._bottoms[b])
        gaps = np.einsum("ski,si->sk", shift[:, None] + arms, below[:, :, -1]) - half[:, None]
        force = np.roll((steps.impulse[1:, b, None, :] @ mean)[:, 0].T / dt, 1, axis=0)
        slip, depth = steps.slip[1:, b].T, steps.penetration[1:, b]
        return contact_columns(slip, gaps.T, depth, force), mean
