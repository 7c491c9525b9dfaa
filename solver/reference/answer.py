"""The rigid-body answer to a scene, in the columns of its history; what it does not know is nan."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from solver.excitation.motion import BaseMotion, base_motion
from solver.post.history import History, columns
from solver.reference.housner import housner
from solver.reference.shenton import initial_mode, release_friction
from solver.reference.sliding import sliding
from solver.scene import Scene

Array = NDArray[np.float64]

#: Names of the two answers.
ROCKING, SLIDING = "rigid block, Housner 1963", "rigid block, sliding"


def demand(scene: Scene, motion: BaseMotion | None) -> float:
    """Largest horizontal acceleration of the base over gravity, an incline counted in: A."""
    along, down = scene.gravity_vector
    return (abs(along) + (motion.peak if motion else 0.0)) / -down


def expected_mode(scene: Scene) -> str:
    """How a scene begins: Shenton (1996) from rest, else by the forces at release from a tilt."""
    block, friction = scene.blocks[0], scene.contact.friction
    if block.tilt != 0:
        needed = release_friction(block.tilt, block.shape.slenderness)
        if abs(block.tilt) > block.shape.slenderness:
            return "overturned"
        return "rock" if friction >= needed else "slide-rock"
    motion = base_motion(scene.motion, scene.time.end)
    return initial_mode(demand(scene, motion), friction, block.height / block.width)


def reference_name(scene: Scene) -> str:
    """Which answer a scene has: rocking, unless its block slides from rest and stays flat."""
    return SLIDING if expected_mode(scene) == "slide" else ROCKING


def reference_history(scene: Scene, file: Path | None = None) -> History:
    """The rigid-body answer: Housner's rocking without sliding, or sliding without rocking.

    Args:
        scene: What is asked.
        file: CSV file to write, too.
    """
    motion = base_motion(scene.motion, scene.time.end)
    known = _slide(scene, motion) if reference_name(scene) == SLIDING else _rock(scene, motion)
    history = History(columns([scene.blocks[0].name]), file)
    unknown = np.full(len(known["time_s"]), math.nan)
    table = np.stack([known.get(name, unknown) for name in history.columns], axis=1)
    for row in table[:: scene.output.history_every]:
        history.append(row)
    history.flush()
    return history


def _ground(scene: Scene, motion: BaseMotion | None, time: float) -> float:
    """Acceleration of the base that has the effect of the motion and the incline together, m/s2."""
    return (motion.acceleration(time) if motion else 0.0) - scene.gravity_vector[0]


def _rock(scene: Scene, motion: BaseMotion | None) -> dict[str, Array]:
    """Housner's block: pivots on the corner on the side it leans to."""
    block, gravity = scene.blocks[0], -scene.gravity_vector[1]
    shape = block.shape
    found = housner(
        shape,
        gravity=gravity,
        tilt=block.tilt,
        end=scene.time.end,
        step=scene.time.step,
        acceleration=lambda time: _ground(scene, motion, time),
    )
    angle, velocity = found.angle, found.angular_velocity
    ground = np.array([_ground(scene, motion, float(t)) for t in found.time])
    # At rest: upright, or lying on its side.
    moves = (velocity != 0) | ((angle != 0) & (np.abs(angle) < math.pi / 2))
    side = np.where(angle < 0, -1.0, 1.0)
    lean, radius = shape.slenderness - np.abs(angle), shape.half_diagonal
    turning = -(shape.frequency(gravity) ** 2) * (
        side * np.sin(lean) + ground / gravity * np.cos(lean)
    )
    # The centre on its circle about the pivot; lean' = -side theta'.
    across = radius * (np.cos(lean) * turning + side * np.sin(lean) * velocity**2)
    up = radius * (side * np.sin(lean) * turning - np.cos(lean) * velocity**2)
    centre_x = block.offset + side * (shape.width / 2 - radius * np.sin(lean))
    values = {
        "angle_rad": angle,
        "angular_velocity_rad_s": velocity,
        "slip_m": np.zeros_like(angle),
        "gap_left_m": shape.width * np.sin(np.maximum(angle, 0)),
        "gap_right_m": shape.width * np.sin(np.maximum(-angle, 0)),
        "centre_x_m": centre_x,
        "centre_y_m": radius * np.cos(lean),
        "normal_force_N": shape.mass * (gravity + np.where(moves, up, 0.0)),
        "friction_force_N": shape.mass * (ground + np.where(moves, across, 0.0)),
    }
    kinetic = shape.rotary_inertia_about_corner * velocity**2 / 2
    speed = radius * np.cos(lean) * velocity
    return _table(scene, motion, found.time, values, kinetic, speed) | {
        "energy.friction_J": np.zeros_like(angle)
    }


def _slide(scene: Scene, motion: BaseMotion | None) -> dict[str, Array]:
    """The block that stays flat."""
    block, gravity = scene.blocks[0], -scene.gravity_vector[1]
    shape, friction = block.shape, scene.contact.friction
    found = sliding(
        acceleration=lambda time: _ground(scene, motion, time),
        friction=friction,
        gravity=gravity,
        end=scene.time.end,
        step=scene.time.step,
    )
    ground = np.array([_ground(scene, motion, float(t)) for t in found.time])
    none = np.zeros_like(found.time)
    sticking = np.clip(ground, -friction * gravity, friction * gravity)
    force = np.where(found.velocity != 0, -friction * gravity * np.sign(found.velocity), sticking)
    values = {
        "angle_rad": none,
        "angular_velocity_rad_s": none,
        "slip_m": found.slip,
        "gap_left_m": none,
        "gap_right_m": none,
        "centre_x_m": block.offset + found.slip,
        "centre_y_m": none + block.height / 2,
        "normal_force_N": none + shape.mass * gravity,
        "friction_force_N": shape.mass * force,
    }
    kinetic = shape.mass * found.velocity**2 / 2
    travelled = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(found.slip)))])
    return _table(scene, motion, found.time, values, kinetic, found.velocity) | {
        "energy.friction_J": friction * shape.mass * gravity * travelled
    }


def _table(
    scene: Scene,
    motion: BaseMotion | None,
    time: Array,
    values: Mapping[str, Array],
    kinetic: Array,
    speed: Array,
) -> dict[str, Array]:
    """Columns of both answers; the work of the ground by the trapezoidal rule over the rows."""
    name, mass = scene.blocks[0].name, scene.blocks[0].shape.mass
    along, down = scene.gravity_vector
    none = np.zeros_like(time)
    base = np.array([motion.acceleration(float(t)) for t in time]) if motion else none
    power = -mass * base * speed
    work = np.concatenate([[0.0], np.cumsum((power[1:] + power[:-1]) / 2 * np.diff(time))])
    gravity = -mass * (along * values["centre_x_m"] + down * values["centre_y_m"])
    return {
        "time_s": time,
        "step_s": none + scene.time.step,
        "base.acceleration_m_s2": base,
        **{f"{name}.{column}": value for column, value in values.items()},
        f"{name}.penetration_m": none,
        "energy.kinetic_J": kinetic,
        "energy.strain_J": none,
        "energy.gravity_J": gravity,
        "energy.spring_J": none,
        "energy.interface_J": none,
        "energy.input_J": work,
        "energy.damping_J": none,
        "energy.total_J": kinetic + gravity,
    }
