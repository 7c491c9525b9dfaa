"""Rows of the history of rigid bodies, from the states that the compiled steps leave."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from solver.history.block_columns import (
    has_lost_carrier,
    write_plane_motion,
    write_space_motion,
)
from solver.history.columns import RowLayout, positions
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


class Foot(NamedTuple):
    """A foot of a block."""

    part: int
    """Its number among the parts of all bodies that have several."""
    column: int
    """Number of the first of its columns."""


class BlockRows:
    """Writer of the columns of blocks."""

    def __init__(
        self,
        bottoms: Array,
        tops: Array,
        holds: Array,
        rolls: Sequence[bool],
        carriers: Sequence[int],
        feet: Mapping[int, Sequence[Foot]] | None = None,
    ):
        """Keep corners of bottoms and levels of tops about centres of mass, what carries, and feet.

        Corners of the blocks are (n, 2^(d-1), d), m; levels of their highest corners and of the
        lowest ones of their tops, which `holds` others, (n,), m; `rolls` where a top is always
        level; carriers are numbers; feet are those of some blocks, by the numbers of these.
        """
        self._holds, self._rolls = holds, rolls
        self._feet = feet or {}
        self._d, self._bottoms, self._tops = bottoms.shape[2], bottoms, tops
        self._carriers, self._at = carriers, positions("block", self._d)

    def lean(self, steps: Steps, frames: Array, before: Array) -> Array:
        """Lean towards +x of all blocks after steps, carried on, rad, (steps, n).

        `frames` has the rotation matrices of all bodies.
        """
        if self._d == 2:
            return -steps.turned[:, :-1, 0]
        lean = np.arctan2(frames[:, :-1, 0, 2], frames[:, :-1, 2, 2])
        return np.unwrap(np.concatenate([before[None], lean]), axis=0)[1:]

    def write(self, rows: Array, layout: RowLayout, steps: Steps, dt: float, lean: Array) -> Array:
        """Fill in the columns of the blocks for all steps but the first; returns the last lean."""
        frames = rotation_matrices(steps.rotation)
        leans = self.lean(steps, frames, lean)[1:]
        for b, carrier in enumerate(self._carriers):
            first = layout.block + layout.stride * b
            own = rows[:, first : first + layout.stride]
            self._write_motion(own, steps, b, leans[:, b])
            mean = self._write_contact(own, steps, frames, b, carrier, dt)
            for foot in self._feet.get(b, ()):
                force = (steps.parts[1:, foot.part, None, :] @ mean)[:, 0] / dt
                along = force[:, [-1, *range(self._d - 1)]]
                rows[:, foot.column : foot.column + self._d] = along
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


def write_platform(rows: Array, layout: RowLayout, steps: Steps, dt: float) -> None:
    """Fill in the columns of the platform and of its base, for all steps but the first."""
    d = steps.centre.shape[-1]
    at, base = positions("platform", d), positions("foundation", d)
    own, below = rows[:, layout.platform :], rows[:, layout.foundation :]
    drift, velocity = steps.centre[1:, -1], steps.velocity[:, -1]
    acceleration, shear = np.diff(velocity, axis=0) / dt, steps.ground_impulse[1:] / dt
    for k, second in enumerate(("", "_second")[: d - 1]):
        own[:, getattr(at, f"drift{second}_m")] = drift[:, k]
        own[:, getattr(at, f"velocity{second}_m_s")] = velocity[1:, k]
        own[:, getattr(at, f"acceleration{second}_m_s2")] = acceleration[:, k]
        below[:, getattr(base, f"base_shear{second}_N")] = shear[:, k]


def write_energies(part: Array, stored: Array, exchanged: Array) -> None:
    """Fill in the columns of the energies.

    The total at the start is still in the error of the ledger. `stored`: kinetic, gravity, spring;
    `exchanged`: taken in, lost by friction, damping, contact and time stepping, J.
    """
    at, total = positions("energy", 3), stored.sum(axis=1)
    part[:, at.kinetic_J], part[:, at.gravity_J], part[:, at.spring_J] = stored.T
    part[:, at.strain_J] = part[:, at.interface_J] = part[:, at.contact_damping_J] = 0.0
    part[:, at.input_J], part[:, at.friction_J] = exchanged[:, 0], exchanged[:, 1]
    part[:, at.damping_J], part[:, at.contact_J] = exchanged[:, 2], exchanged[:, 3]
    part[:, at.numerical_J], part[:, at.total_J] = exchanged[:, 4], total
    part[:, at.ledger_error_J] = total - exchanged[:, 0] + exchanged[:, 1:].sum(axis=1)
