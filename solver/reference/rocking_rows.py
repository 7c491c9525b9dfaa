"""The columns of a history of a rigid block that rocks, on firm ground or on a platform."""

from __future__ import annotations

import math

import numpy as np

from solver.excitation.motion import GroundMotion
from solver.reference.housner import RockingReference, housner
from solver.reference.platform_rocking import rocking_on_platform
from solver.reference.rows import (
    acceleration_of,
    base_of,
    columns_of_platform,
    first_drift,
    sampled,
    table,
)
from solver.scene import Scene
from solver.types import Array


def rock(scene: Scene, ground: GroundMotion) -> dict[str, Array]:
    """Housner's block: pivots on the corner on the side it leans to; restitution may be given."""
    block, gravity = scene.blocks[0], -scene.gravity_vector[1]
    shape, vertical = block.shape, acceleration_of(ground.up)
    found = housner(
        shape,
        gravity=gravity,
        tilt=block.tilt,
        end=scene.time.end,
        step=scene.time.step,
        acceleration=lambda time: base_of(scene, ground, time),
        vertical=vertical if ground.up else None,
        restitution=block.restitution,
    )
    base = np.array([base_of(scene, ground, float(t)) for t in found.time])
    down = gravity + sampled(vertical, found.time)
    side = np.where(found.angle < 0, -1.0, 1.0)
    lean = shape.slenderness - np.abs(found.angle)
    turning = -3 / (4 * shape.half_diagonal) * (down * side * np.sin(lean) + base * np.cos(lean))
    values, across, rise = _pivoting(scene, found, turning, (base, down))
    kinetic = shape.rotary_inertia_about_corner * found.angular_velocity**2 / 2
    return table(scene, ground, found.time, values, kinetic, across, rise) | {
        "energy.friction_J": np.zeros_like(found.angle)
    }


def rock_on_platform(scene: Scene, ground: GroundMotion) -> dict[str, Array]:
    """The block that rocks on a platform without sliding; restitution may be given."""
    block, platform = scene.blocks[0], scene.platform()
    along, gravity = scene.gravity_vector[0], -scene.gravity_vector[1]
    shape, vertical = block.shape, acceleration_of(ground.up)
    found = rocking_on_platform(
        shape,
        platform,
        gravity=gravity,
        tilt=block.tilt,
        end=scene.time.end,
        step=scene.time.step,
        acceleration=acceleration_of(ground.along),
        vertical=vertical,
        along=along,
        drift=first_drift(scene),
        restitution=block.restitution,
    )
    base = np.array([base_of(scene, ground, float(t)) for t in found.time])
    under = base + found.drift_acceleration, gravity + sampled(vertical, found.time)
    values, across, rise = _pivoting(scene, found, found.angular_acceleration, under)
    values["centre_x_m"] = values["centre_x_m"] + found.drift
    velocity, turn = found.drift_velocity, found.angular_velocity
    kinetic = (platform.mass + shape.mass) * velocity**2 / 2 + shape.mass * velocity * across
    kinetic = kinetic + shape.rotary_inertia_about_corner * turn**2 / 2
    mean = across + (1 + platform.mass / shape.mass) * velocity
    known = table(scene, ground, found.time, values, kinetic, mean, rise)
    return (
        known
        | columns_of_platform(scene, known, found)
        | {"energy.friction_J": np.zeros_like(turn)}
    )


def _pivoting(
    scene: Scene, found: RockingReference, turning: Array, under: tuple[Array, Array]
) -> tuple[dict[str, Array], Array, Array]:
    """Columns of a block that stands, or turns about a corner, on a base where it is.

    Args:
        scene: What is asked.
        found: How the block turns.
        turning: Its angular acceleration where it turns, rad/s^2.
        under: Acceleration of the base along x, an incline counted in, and gravity and the
            acceleration upwards, m/s^2.

    Returns:
        The columns; velocity of the centre relative to the base along x, and upwards, m/s.
    """
    block, angle, velocity = scene.blocks[0], found.angle, found.angular_velocity
    shape = block.shape
    # At rest: upright, or lying on its side.
    moves = (velocity != 0) | ((angle != 0) & (np.abs(angle) < math.pi / 2))
    side = np.where(angle < 0, -1.0, 1.0)
    lean, radius = shape.slenderness - np.abs(angle), shape.half_diagonal
    # The centre on its circle about the pivot; lean' = -side theta'.
    across = radius * (np.cos(lean) * turning + side * np.sin(lean) * velocity**2)
    up = radius * (side * np.sin(lean) * turning - np.cos(lean) * velocity**2)
    base, down = under
    values = {
        "angle_rad": angle,
        "angular_velocity_rad_s": velocity,
        "slip_m": np.zeros_like(angle),
        "gap_left_m": shape.width * np.sin(np.maximum(angle, 0)),
        "gap_right_m": shape.width * np.sin(np.maximum(-angle, 0)),
        "centre_x_m": block.offset + side * (shape.width / 2 - radius * np.sin(lean)),
        "centre_y_m": radius * np.cos(lean),
        "normal_force_N": shape.mass * (down + np.where(moves, up, 0.0)),
        "friction_force_N": shape.mass * (base + np.where(moves, across, 0.0)),
    }
    return values, radius * np.cos(lean) * velocity, side * radius * np.sin(lean) * velocity
