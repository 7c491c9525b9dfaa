"""The columns of a block that follow from its motion as a rigid body, for all engines.

A new one of them is an entry of `solver.history.columns.TABLE` and a line here.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from geometry.top import STEEPEST_TOP
from solver.history.engine_rows import along
from solver.types import Array


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


def plane_motion(angle: Any, spin: Any, centre: Array) -> dict[str, Any]:
    """The columns of a block in the plane that follow from its motion, by their names within it.

    By its angle (rad), its angular velocity (rad/s) and its centre (m); or by arrays over steps.
    """
    return {
        "angle_rad": angle,
        "angular_velocity_rad_s": spin,
        **along("centre_{}_m", centre, "xy"),
    }


def space_motion(lean: Any, turn: Array, spin: Array, centre: Array) -> dict[str, Any]:
    """The columns of a block in space that follow from its motion, by their names within it.

    By lean and rotation vector (rad), angular velocity in space (rad/s) and centre (m); or by
    arrays over steps.
    """
    return {
        "angle_rad": lean,
        **along("angle_{}_rad", turn, "xyz"),
        **along("angular_velocity_{}_rad_s", spin, "xyz"),
        **along("centre_{}_m", centre, "xyz"),
    }


def contact_columns(slip: Array, gaps: Array, depth: Any, force: Array) -> dict[str, Any]:
    """The columns of a block on what carries it, by their names within it.

    By slip (m), gaps of its bottom corners (m), the largest penetration (m), and the force on it
    (N), normal and along its carrier; or by arrays over steps.
    """
    corners = ("left", "right") if len(gaps) == 2 else "1234"
    return {
        **along("slip{}_m", slip),
        **along("gap_{}_m", gaps, corners),
        "penetration_m": depth,
        **force_columns(force),
    }


def force_columns(force: Array) -> dict[str, Any]:
    """The columns of a force on a block or a foot, N: normal, and along x and y of its carrier."""
    return {"normal_force_N": force[0], **along("friction_force{}_N", force[1:])}
