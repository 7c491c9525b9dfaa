"""Rows of the history of rigid bodies, from the states that the compiled steps leave."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geometry.block import Block
from geometry.outline import rolls
from geometry.top import top_over_centre
from solver.history.block_columns import (
    has_lost_carrier,
    write_plane_motion,
    write_space_motion,
)
from solver.history.columns import positions
from solver.history.engine_rows import EngineRows
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

    def __init__(self, shapes: Sequence[Block], carriers: Sequence[int], columns: EngineRows):
        """Keep what its columns take of each block.

        `carriers` are the numbers of the bodies that carry the blocks, or the number of blocks for
        what carries all.
        """
        self._columns, self._carriers, self._d = columns, carriers, columns.dimension
        d, self._at = self._d, positions("block", self._d)
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

    def write(self, rows: Array, steps: Steps, dt: float, lean: Array) -> Array:
        """Fill in the columns of the blocks for all steps but the first; returns the last lean."""
        frames = rotation_matrices(steps.rotation)
        leans = self.lean(steps, frames, lean)[1:]
        for b, carrier in enumerate(self._carriers):
            own = rows[:, self._columns.blocks[b]]
            self._write_motion(own, steps, b, leans[:, b])
            mean = self._write_contact(own, steps, frames, b, carrier, dt)
            feet = rows[:, self._columns.feet[b]].reshape(len(rows), len(self._feet[b]), self._d)
            for foot, part in enumerate(self._feet[b]):
                force = (steps.parts[1:, part, None, :] @ mean)[:, 0] / dt
                feet[:, foot] = force[:, [-1, *range(self._d - 1)]]
        return leans[-1]

    def _write_motion(self, own: Array, steps: Steps, b: int, lean: Array) -> None:
        spin, centre = steps.spin[1:, b].T, steps.centre[1:, b].T
        if self._d == 2:
            write_plane_motion(own.T, lean, -spin[0], centre)
        else:
            angles = np.stack([lean, *steps.turned[1:, b].T])
            write_space_motion(own.T, angles, spin, centre)

    def _write_contact(
        self, own: Array, steps: Steps, frames: Array, b: int, carrier: int, dt: float
    ) -> Array:
        """Slip, gaps, penetration and forces: over the carrier, or level ground once it is lost.

        Returns:
            The axes of the forces as columns, (steps, d, d).
        """
        at, d, base = self._at, self._d, len(self._carriers)
        level = np.eye(d)
        centre = steps.centre[1:, b]
        over_ground = centre - steps.centre[1:, base] * (1 - level[-1])
        if carrier == base:
            half: Array = np.zeros(len(own))
            below = mean = np.broadcast_to(level, (len(own), d, d))
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
        names = ("left", "right") if d == 2 else ("1", "2", "3", "4")
        for k, name in enumerate(names):
            own[:, getattr(at, f"gap_{name}_m")] = gaps[:, k]
        own[:, at.slip_m] = steps.slip[1:, b, 0]
        own[:, at.penetration_m] = steps.penetration[1:, b]
        force = (steps.impulse[1:, b, None, :] @ mean)[:, 0] / dt
        own[:, at.normal_force_N], own[:, at.friction_force_N] = force[:, -1], force[:, 0]
        if d == 3:
            own[:, at.slip_second_m] = steps.slip[1:, b, 1]
            own[:, at.friction_force_second_N] = force[:, 1]
        return mean
