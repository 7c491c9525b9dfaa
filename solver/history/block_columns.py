"""The columns of a block that follow from its motion as a rigid body, for all engines.

A new one of them is an entry of `solver.history.columns.TABLE` and a line here.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from geometry.top import STEEPEST_TOP
from solver.history.columns import positions
from solver.types import Array

PLANE, SPACE = positions("block", 2), positions("block", 3)
"""Places of the columns within the part of a block."""


def has_lost_carrier(level: Any, height: Any, half: float) -> Any:
    """True if a block has lost its carrier: gaps and contact forces are then over level ground.

    Args:
        level: Cosine of the lean of the carrier's top.
        height: Of the block's centre of mass over that of its carrier, along the carrier's axis, m.
        half: Height of the carrier's top over its centre of mass, m (`geometry.top`).
    """
    return (level <= STEEPEST_TOP) | (height <= half)


def lean_in_space(rotation: Array, before: float) -> float:
    """Angle about +y by which the upright axis of a block leans, rad, carried on from `before`."""
    lean = math.atan2(rotation[0, 2], rotation[2, 2])
    return float(lean + 2 * math.pi * np.round((before - lean) / (2 * math.pi)))


def write_plane_motion(row: Array, angle: Any, spin: Any, centre: Array) -> None:
    """Fill in the columns of a block in the plane that follow from its motion.

    By its angle (rad), its angular velocity (rad/s) and its centre (m); or, as all of them, by
    arrays over rows, which then are the second axis of `row`.
    """
    row[PLANE.angle_rad], row[PLANE.angular_velocity_rad_s] = angle, spin
    row[PLANE.centre_x_m], row[PLANE.centre_y_m] = centre[0], centre[1]


def write_space_motion(row: Array, angles: Array, spin: Array, centre: Array) -> None:
    """Fill in the columns of a block in space that follow from its motion.

    By lean and rotation vector (rad), angular velocity in space (rad/s) and centre (m); rows as in
    `write_plane_motion`.
    """
    row[SPACE.angle_rad], row[SPACE.angle_x_rad] = angles[0], angles[1]
    row[SPACE.angle_y_rad], row[SPACE.angle_z_rad] = angles[2], angles[3]
    row[SPACE.angular_velocity_x_rad_s] = spin[0]
    row[SPACE.angular_velocity_y_rad_s] = spin[1]
    row[SPACE.angular_velocity_z_rad_s] = spin[2]
    row[SPACE.centre_x_m], row[SPACE.centre_y_m] = centre[0], centre[1]
    row[SPACE.centre_z_m] = centre[2]
