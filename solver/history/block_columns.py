"""The columns of a block that follow from its motion as a rigid body, for all engines. Compiled.

A new one of them is an entry of `solver.history.columns.TABLE` and a line here.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from solver.history.columns import positions
from solver.law.compiled import compiled
from solver.types import Array

PLANE, SPACE = positions("block", 2), positions("block", 3)
"""Places of the columns within the part of a block."""

STEEPEST_TOP = 0.5
"""Cosine of the lean of a block's top beyond which it carries nothing, 60 degrees."""


@compiled
def has_lost_carrier(level: float, height: float, half: float) -> bool:
    """Whether a block has lost its carrier: gaps and contact forces are then over level ground.

    Args:
        level: Cosine of the lean of the carrier's top.
        height: Of the block's centre over that of its carrier, along the carrier's axis, m.
        half: Half the height of the carrier, m.
    """
    return level <= STEEPEST_TOP or height <= half


class MovingBlock(NamedTuple):
    """A block as a rigid body at an instant; of a meshed one the rigid motion that fits it best."""

    mass: float
    """kg."""
    inertia: Array
    """About the centre, in space the principal moments, kg m2, (1,) or (3,)."""
    centre: Array
    """Position of the centre, m, (d,)."""
    velocity: Array
    """Velocity of the centre, m/s, (d,)."""
    angles: Array
    """The angle, (1,); in space the lean and the rotation vector, (4,), rad."""
    spin: Array
    """Angular velocity in space, rad/s, (1,) or (3,)."""
    own_spin: Array
    """Angular velocity about the block's own axes, rad/s."""


@compiled
def lean_in_space(rotation: Array, before: float) -> float:
    """Angle about +y by which the upright axis of a block leans, rad, carried on from `before`."""
    lean = math.atan2(rotation[0, 2], rotation[2, 2])
    return float(lean + 2 * math.pi * np.round((before - lean) / (2 * math.pi)))


@compiled
def write_plane_motion(block: MovingBlock, row: Array) -> None:
    """Fill in the columns of a block in the plane that follow from its motion."""
    row[PLANE.angle_rad], row[PLANE.angular_velocity_rad_s] = block.angles[0], block.spin[0]
    row[PLANE.centre_x_m], row[PLANE.centre_y_m] = block.centre[0], block.centre[1]


@compiled
def write_space_motion(block: MovingBlock, row: Array) -> None:
    """Fill in the columns of a block in space that follow from its motion."""
    row[SPACE.angle_rad], row[SPACE.angle_x_rad] = block.angles[0], block.angles[1]
    row[SPACE.angle_y_rad], row[SPACE.angle_z_rad] = block.angles[2], block.angles[3]
    row[SPACE.angular_velocity_x_rad_s] = block.spin[0]
    row[SPACE.angular_velocity_y_rad_s] = block.spin[1]
    row[SPACE.angular_velocity_z_rad_s] = block.spin[2]
    row[SPACE.centre_x_m], row[SPACE.centre_y_m] = block.centre[0], block.centre[1]
    row[SPACE.centre_z_m] = block.centre[2]
