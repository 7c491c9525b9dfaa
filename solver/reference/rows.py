"""The columns of a history that belong to a rigid block, and those of one that slides."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np

from solver.errors import SceneError
from solver.excitation.kinds import BaseMotion
from solver.excitation.motion import GroundMotion
from solver.excitation.sampled import SampledMotion
from solver.reference.expected import resistance
from solver.reference.friction import Resistance
from solver.reference.phases import Acceleration, still
from solver.reference.platform import sliding_on_platform
from solver.reference.platform_sampled import sampled_sliding_on_platform
from solver.reference.sliding import sliding
from solver.rigid.start import platform_of
from solver.scene import Scene
from solver.types import Array

ONLY = "where a rigid-body reference is asked for"


def acceleration_of(motion: BaseMotion | None) -> Acceleration:
    """The acceleration of the ground along one direction, m/s2, as a function of time."""
    return motion.acceleration if motion else still


def base_of(scene: Scene, ground: GroundMotion, time: float) -> float:
    """Acceleration of the base that has the effect of the motion and the incline together, m/s2."""
    return acceleration_of(ground.along)(time) - scene.gravity_vector[0]


def slide(scene: Scene, ground: GroundMotion) -> dict[str, Array]:
    """The block that stays flat, on firm ground."""
    block, gravity = scene.blocks[0], -scene.gravity_vector[1]
    law, vertical = resistance(scene), acceleration_of(ground.up)
    found = sliding(
        acceleration=lambda time: base_of(scene, ground, time),
        friction=law,
        gravity=gravity,
        end=scene.time.end,
        step=scene.time.step,
        velocity=block.velocity[0],
        vertical=vertical,
    )
    normal = gravity + sampled(vertical, found.time)
    force = _friction(law, normal, found.velocity)
    base = np.array([base_of(scene, ground, float(t)) for t in found.time])
    held = np.where(found.velocity != 0, -force * np.sign(found.velocity), base)
    kinetic = block.shape.mass * found.velocity**2 / 2
    values = _flat(scene, found.slip, found.slip, normal, held)
    return table(scene, ground, found.time, values, kinetic, found.velocity) | {
        "energy.friction_J": block.shape.mass * _along(force, found.slip)
    }


def slide_on_platform(scene: Scene, ground: GroundMotion) -> dict[str, Array]:
    """The block that stays flat, on a platform; SceneError if it does not stay flat."""
    block, platform = scene.blocks[0], scene.platform()
    along, down = scene.gravity_vector[0], -scene.gravity_vector[1]
    law, vertical = resistance(scene), acceleration_of(ground.up)
    given: dict[str, Any] = {
        "platform": platform,
        "mass": block.shape.mass,
        "friction": law,
        "gravity": down,
        "end": scene.time.end,
        "step": scene.time.step,
        "along": along,
        "velocity": block.velocity[0],
        "drift": first_drift(scene),
    }
    if isinstance(ground.along, SampledMotion) and vertical is still and not law.law.decay:
        found = sampled_sliding_on_platform(motion=ground.along, **given)
    else:
        acceleration = acceleration_of(ground.along)
        found = sliding_on_platform(acceleration=acceleration, vertical=vertical, **given)
    normal = down + sampled(vertical, found.time)
    uplift = np.abs(found.friction) * block.height > normal * block.width
    if uplift.any():
        got = f"a block that would rock at {found.time[int(np.argmax(uplift))]:.4g} s"
        raise SceneError("foundation.kind", got, f"a platform with a block that stays flat, {ONLY}")
    drift, velocity = found.drift, found.drift_velocity
    speed = velocity + found.slip_velocity
    kinetic = (block.shape.mass * speed**2 + platform.mass * velocity**2) / 2
    values = _flat(scene, found.slip, found.slip + drift, normal, found.friction)
    # The mass whose acceleration takes part in the work of the ground moves like this.
    mean = speed + platform.mass / block.shape.mass * velocity
    known = table(scene, ground, found.time, values, kinetic, mean)
    force = _friction(law, normal, found.slip_velocity)
    return (
        known
        | columns_of_platform(scene, known, found)
        | {"energy.friction_J": block.shape.mass * _along(force, found.slip)}
    )


def first_drift(scene: Scene) -> float:
    """Drift of the platform at the start, m: on an incline its spring may hold all weight."""
    start = platform_of(scene)
    return start.drift[0] if start else 0.0


class _Drifting(Protocol):
    """History of a platform."""

    @property
    def drift(self) -> Array:
        """u, m."""

    @property
    def drift_velocity(self) -> Array:
        """Velocity, m/s."""

    @property
    def drift_acceleration(self) -> Array:
        """Acceleration, m/s^2."""


def columns_of_platform(
    scene: Scene, known: Mapping[str, Array], found: _Drifting
) -> dict[str, Array]:
    """The columns of the platform, and those to which it adds energy.

    Args:
        scene: What is asked.
        known: The columns of the block.
        found: How the platform moves.
    """
    platform, drift = scene.platform(), found.drift
    spring = platform.stiffness * drift**2 / 2
    gravity = known["energy.gravity_J"] - platform.mass * scene.gravity_vector[0] * drift
    dashpot = platform.damping * found.drift_velocity**2
    return {
        "platform.drift_m": drift,
        "platform.velocity_m_s": found.drift_velocity,
        "platform.acceleration_m_s2": found.drift_acceleration,
        "foundation.base_shear_N": platform.stiffness * drift
        + platform.damping * found.drift_velocity,
        "energy.spring_J": spring,
        "energy.gravity_J": gravity,
        "energy.total_J": known["energy.kinetic_J"] + gravity + spring,
        "energy.damping_J": _integral(known["time_s"], dashpot),
    }


def sampled(function: Acceleration, time: Array) -> Array:
    """Values of a function at many times."""
    return np.array([function(float(t)) for t in time])


def _friction(law: Resistance, normal: Array, speed: Array) -> Array:
    """Friction while the block slides, over its mass, m/s^2."""
    pairs = zip(map(float, normal), map(abs, map(float, speed)), strict=True)
    return np.array([law.slides(*pair) for pair in pairs])


def _along(force: Array, slip: Array) -> Array:
    """Work of a force along the slip so far, whichever way it goes."""
    return np.concatenate([[0.0], np.cumsum((force[1:] + force[:-1]) / 2 * np.abs(np.diff(slip)))])


def _integral(time: Array, rate: Array) -> Array:
    """The integral so far, by the trapezoidal rule over the rows."""
    return np.concatenate([[0.0], np.cumsum((rate[1:] + rate[:-1]) / 2 * np.diff(time))])


def _flat(
    scene: Scene, slip: Array, displacement: Array, normal: Array, friction: Array
) -> dict[str, Array]:
    """Columns of a block that stays flat; forces over its mass, m/s^2."""
    block, none = scene.blocks[0], np.zeros_like(slip)
    return {
        "angle_rad": none,
        "angular_velocity_rad_s": none,
        "slip_m": slip,
        "gap_left_m": none,
        "gap_right_m": none,
        "centre_x_m": block.offset + displacement,
        "centre_y_m": none + block.height / 2,
        "normal_force_N": block.shape.mass * normal,
        "friction_force_N": block.shape.mass * friction,
    }


def table(
    scene: Scene,
    ground: GroundMotion,
    time: Array,
    values: Mapping[str, Array],
    kinetic: Array,
    speed: Array,
    rise: Array | None = None,
) -> dict[str, Array]:
    """Columns of all answers; the work of the ground by the trapezoidal rule over the rows.

    Args:
        scene: What is asked.
        ground: Its motion of the ground.
        time: s.
        values: Columns of the block, by what follows its name.
        kinetic: Energy, J.
        speed: Along x, of the block's mass on which the ground works, m/s.
        rise: The same upwards; None: it does not rise.
    """
    name, mass = scene.blocks[0].name, scene.blocks[0].shape.mass
    along, down = scene.gravity_vector
    none = np.zeros_like(time)
    base = ground.along.accelerations(time) if ground.along else none
    heave = sampled(acceleration_of(ground.up), time)
    power = base * speed + (0.0 if rise is None else heave * rise)
    gravity = -mass * (along * values["centre_x_m"] + down * values["centre_y_m"])
    return {
        "time_s": time,
        "step_s": none + scene.time.step,
        "base.acceleration_m_s2": base,
        "base.vertical_acceleration_m_s2": heave,
        **{f"{name}.{column}": value for column, value in values.items()},
        f"{name}.penetration_m": none,
        "energy.kinetic_J": kinetic,
        "energy.strain_J": none,
        "energy.gravity_J": gravity,
        "energy.spring_J": none,
        "energy.interface_J": none,
        "energy.input_J": _integral(time, -mass * power),
        "energy.damping_J": none,
        "energy.total_J": kinetic + gravity,
    }
