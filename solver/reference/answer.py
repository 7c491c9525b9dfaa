"""The rigid-body answer to a scene, in the columns of its history; unknown ones are nan."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from geometry.block import SIDES
from solver.errors import SceneError
from solver.excitation.kinds import BaseMotion
from solver.excitation.motion import GroundMotion, read_ground
from solver.excitation.sampled import SampledMotion
from solver.history.events import NAME as EVENTS
from solver.history.events import events_text
from solver.history.history import History, scene_columns
from solver.reference.housner import RockingReference, housner
from solver.reference.initiation import expected_mode, resistance
from solver.reference.phases import EXACT, Acceleration, still
from solver.reference.sliding import SlidingReference, sliding
from solver.results.endings import Watch
from solver.results.events import Recorder
from solver.results.motion import of_side
from solver.scene import Scene
from solver.scene.checking import shown
from solver.types import Array

ONLY = "where a rigid-body reference is asked for"

#: Names of the answers.
ROCKING, SLIDING = "rigid block, Housner 1963", "rigid block, sliding"
ON_PLATFORM = "rigid block on a platform, sliding"
ROCKING_ON_PLATFORM = "rigid block on a platform, rocking"


def reference_name(scene: Scene, ground: GroundMotion | None = None) -> str:
    """The name of the answer that a scene has.

    On a platform a block rocks that is tilted, or that friction holds at rest until it uplifts;
    others slide. On firm ground it rocks, unless it slides from rest and stays flat.

    Args:
        scene: The scene.
        ground: Its motion of the ground, as it was read; None: it is read here.

    Raises:
        SceneError: There is none.
    """
    ground = ground or read_ground(scene)
    _refuse(scene, ground)
    if scene.has_platform:
        return ROCKING_ON_PLATFORM if _pivots_on_platform(scene) else ON_PLATFORM
    mode, block = expected_mode(scene, ground), scene.blocks[0]
    if block.velocity[0] and mode != "slide":
        got = f"{shown(block.velocity)} of a block that may {mode}"
        raise SceneError(f"{block.name}.velocity", got, f"[0, 0] {ONLY}")
    slides = mode == "slide" or (mode == "rest" and ground.up is not None)
    return SLIDING if slides else ROCKING


def reference_history(
    scene: Scene, file: Path | None = None, ground: GroundMotion | None = None
) -> History:
    """The history of the rigid-body answer; arguments as those of `reference_run`."""
    return reference_run(scene, file, ground)[0]


def reference_run(
    scene: Scene, file: Path | None = None, ground: GroundMotion | None = None
) -> tuple[History, str]:
    """The rigid-body answer: rocking without sliding, or sliding without rocking.

    Args:
        scene: The scene; SceneError where there is no answer.
        file: CSV file to write, too.
        ground: Motion of the ground, as it was read; None: it is read here.

    Returns:
        The history, and why it ends before `time.end`, in words: empty where it does not.
    """
    ground = ground or read_ground(scene)
    slides = reference_name(scene, ground) in (SLIDING, ON_PLATFORM)
    return as_history(scene, slide(scene, ground) if slides else rock(scene, ground), file)


def as_history(
    scene: Scene, known: dict[str, Array], file: Path | None = None
) -> tuple[History, str]:
    """Columns as a history, which ends where `time.stop` says, and why it does, in words."""
    history = History(scene_columns(scene), file)
    unknown = np.full_like(known["time_s"], np.nan)
    table = np.stack([known.get(name, unknown) for name in history.columns], axis=1)
    ending = Watch(scene).look(table)
    every, last = scene.output.history_every, ending.row if ending else len(table) - 1
    for number in range(0, last + 1, every):
        history.append(table[number])
    if last % every:
        history.append(table[last])
    history.flush()
    recorder = Recorder(scene, history.columns, rigid=True)
    recorder.add(table[: last + 1])
    # Its forces have no impulses.
    history.events = tuple(replace(event, impulse_Ns=np.nan) for event in recorder.finish())
    if file is not None:
        file.with_name(EVENTS).write_text(events_text(history.events), encoding="utf-8")
    return history, ending.reason if ending else ""


def _pivots_on_platform(scene: Scene) -> bool:
    """True if the block is tilted, or at rest and held by friction until it uplifts: mu > B/H.

    Over either edge, whichever is first.
    """
    block, down = scene.blocks[0], -scene.gravity_vector[1]
    if block.tilt or block.velocity[0]:
        return bool(block.tilt)
    farthest = max(block.shape.uplift(side) for side in SIDES)
    return resistance(scene).holds(down, slipped=False) > down * farthest


def refuse_joined(scene: Scene, where: str) -> None:
    """Refuse links and forces: SceneError; `where` follows what is allowed."""
    for key, members in (("link", scene.links), ("force", scene.forces)):
        if members:
            raise SceneError(key, members[0].name, f"none {where}")


def refuse_several(scene: Scene, where: str) -> None:
    """Refuse what is not one block in the plane, by itself, that stands: SceneError."""
    block = scene.blocks[0]
    if scene.dimension != 2:
        raise SceneError("dimension", "3", f"2 {where}")
    if len(scene.blocks) != 1:
        raise SceneError("block", f"{len(scene.blocks)} blocks", f"one block {where}")
    refuse_joined(scene, where)
    if block.position is not None:
        raise SceneError(f"{block.name}.position", shown(block.position), f"offset {where}")


def _refuse(scene: Scene, ground: GroundMotion) -> None:
    """Refuse a scene that no reference answers, in one line."""
    block = scene.blocks[0]
    refuse_several(scene, ONLY)
    if scene.gravity == 0:
        raise SceneError("gravity", "0", f"gravity > 0 {ONLY}")
    if scene.carrier_moves and not scene.has_platform:
        raise SceneError("foundation.kind", shown(scene.foundation.kind), f"any other kind {ONLY}")
    if block.angular_velocity:
        raise SceneError(
            f"{block.name}.angular_velocity", shown(block.angular_velocity), f"0 {ONLY}"
        )
    if block.velocity[1] or (block.velocity[0] and block.tilt):
        allowed = f"[0, 0], or [v, 0] without a tilt, {ONLY}"
        raise SceneError(f"{block.name}.velocity", shown(block.velocity), allowed)
    vertical = ground.up
    if vertical is not None and vertical.peak >= -scene.gravity_vector[1]:
        raise SceneError("motion.vertical", f"{vertical.peak:g} m/s2", f"less than gravity {ONLY}")


def _acceleration_of(motion: BaseMotion | None) -> Acceleration:
    """The acceleration of the ground along one direction, m/s2, as a function of time."""
    return motion.acceleration if motion else still


def _first_drift(scene: Scene) -> float:
    """Drift of the platform at the start, m: on an incline its spring may hold all weight."""
    block = scene.blocks[0]
    if not scene.has_platform or scene.time.initial != "static" or block.tilt:
        return 0.0
    mass, stiffness, _ = scene.platform()
    return (mass + scene.carried_mass) / stiffness * scene.gravity_vector[0]


def slide(scene: Scene, ground: GroundMotion) -> dict[str, Array]:
    """Columns of the block that stays flat; SceneError if on a platform it does not stay flat."""
    block, (along, down) = scene.blocks[0], scene.gravity_vector
    law, along_x = resistance(scene), ground.along
    found = sliding(
        acceleration=along_x if isinstance(along_x, SampledMotion) else _acceleration_of(along_x),
        friction=law,
        gravity=-down,
        end=scene.time.end,
        step=scene.time.step,
        platform=scene.platform() if scene.has_platform else None,
        mass=block.shape.mass,
        along=along,
        velocity=block.velocity[0],
        drift=_first_drift(scene),
        vertical=_acceleration_of(ground.up),
    )
    normal = -down + _sampled(ground.up, found.time)
    # Pushed towards +x below its centre, it leans to -x.
    shape, side = block.shape, np.where(found.friction > 0, -1, 1)
    uplift = np.abs(found.friction) > normal * of_side(shape.uplift, side)
    if scene.has_platform and uplift.any():
        got = f"a block that would rock at {found.time[int(np.argmax(uplift))]:.4g} s"
        raise SceneError("foundation.kind", got, f"a platform with a block that stays flat, {ONLY}")
    none = np.zeros_like(found.slip)
    values = {
        "angle_rad": none,
        "angular_velocity_rad_s": none,
        "slip_m": found.slip,
        "gap_left_m": none,
        "gap_right_m": none,
        "centre_x_m": block.offset + shape.centre_of_mass()[0] + found.slip + found.drift,
        "centre_y_m": none + shape.centre_height,
        "normal_force_N": block.shape.mass * normal,
        "friction_force_N": block.shape.mass * found.friction,
    }
    kinetic = block.shape.mass * (found.slip_velocity + found.drift_velocity) ** 2 / 2
    pairs = zip(map(float, normal), map(float, np.abs(found.slip_velocity)), strict=True)
    force = np.array([law.slides(*pair) for pair in pairs])
    lost = block.shape.mass * _integral(np.cumsum(np.abs(np.diff(found.slip, prepend=0.0))), force)
    return _table(scene, ground, found, values, kinetic, found.slip_velocity, lost=lost)


def rock(
    scene: Scene,
    ground: GroundMotion,
    *,
    step: float | None = None,
    longest: float | None = None,
    tolerance: float = EXACT,
) -> dict[str, Array]:
    """Columns of the block that rocks without sliding; restitution may be given.

    Args:
        scene: The scene.
        ground: Its motion of the ground.
        step: Between rows, s; None: that of the scene.
        longest: Longest step of the integrator, s; None: that between rows.
        tolerance: Relative, of the integrator.
    """
    block, (along, down) = scene.blocks[0], scene.gravity_vector
    shape = block.shape
    found = housner(
        shape,
        gravity=-down,
        tilt=block.tilt,
        end=scene.time.end,
        step=step or scene.time.step,
        acceleration=_acceleration_of(ground.along),
        vertical=_acceleration_of(ground.up),
        restitution=scene.restitution_of(block) or None,
        platform=scene.platform() if scene.has_platform else None,
        along=along,
        drift=_first_drift(scene),
        longest=longest,
        tolerance=tolerance,
    )
    angle, velocity, turning = found.angle, found.angular_velocity, found.angular_acceleration
    # At rest: upright, or lying on its side.
    moves = (velocity != 0) | ((angle != 0) & (np.abs(angle) < math.pi / 2))
    side = np.where(angle < 0, -1.0, 1.0)
    edge = side.astype(int)
    lean, radius = of_side(shape.slenderness, edge) - np.abs(angle), of_side(shape.radius, edge)
    # The centre on its circle about the pivot; lean' = -side theta'.
    across = radius * (np.cos(lean) * turning + side * np.sin(lean) * velocity**2)
    up = radius * (side * np.sin(lean) * turning - np.cos(lean) * velocity**2)
    base = _sampled(ground.along, found.time) - along + found.drift_acceleration
    values = {
        "angle_rad": angle,
        "angular_velocity_rad_s": velocity,
        "slip_m": np.zeros_like(angle),
        "gap_left_m": shape.width * np.sin(np.maximum(angle, 0)),
        "gap_right_m": shape.width * np.sin(np.maximum(-angle, 0)),
        "centre_x_m": block.offset + side * (shape.width / 2 - radius * np.sin(lean)) + found.drift,
        "centre_y_m": radius * np.cos(lean),
        "normal_force_N": shape.mass
        * (_sampled(ground.up, found.time) - down + np.where(moves, up, 0.0)),
        "friction_force_N": shape.mass * (base + np.where(moves, across, 0.0)),
    }
    speed, rise = radius * np.cos(lean) * velocity, side * radius * np.sin(lean) * velocity
    kinetic = of_side(shape.rotary_inertia_about_corner, edge) * velocity**2 / 2
    kinetic += shape.mass * found.drift_velocity * (found.drift_velocity / 2 + speed)
    return _table(scene, ground, found, values, kinetic, speed, rise=rise)


def _sampled(motion: BaseMotion | None, time: Array) -> Array:
    """Accelerations of the ground along one direction at many times, m/s^2."""
    return motion.acceleration(time) if motion else np.zeros_like(time)


def _integral(time: Array, rate: Array) -> Array:
    """The integral so far, by the trapezoidal rule over the rows."""
    return np.concatenate([[0.0], np.cumsum((rate[1:] + rate[:-1]) / 2 * np.diff(time))])


def _table(
    scene: Scene,
    ground: GroundMotion,
    found: RockingReference | SlidingReference,
    values: dict[str, Array],
    kinetic: Array,
    speed: Array,
    *,
    rise: Array | float = 0.0,
    lost: Array | float = 0.0,
) -> dict[str, Array]:
    """Columns of all answers; the work of the ground by the trapezoidal rule over the rows.

    Args:
        scene: The scene.
        ground: Its motion of the ground.
        found: How the block moves, and what it stands on.
        values: Columns of the block, by what follows its name.
        kinetic: Energy of the block, J.
        speed: Of the block's centre relative to what it stands on, m/s.
        rise: The same upwards.
        lost: By friction so far, J.
    """
    name, mass, time = scene.blocks[0].name, scene.blocks[0].shape.mass, found.time
    along, down = scene.gravity_vector
    none, drift, velocity = np.zeros_like(time), found.drift, found.drift_velocity
    base, heave = _sampled(ground.along, time), _sampled(ground.up, time)
    gravity = -mass * (along * values["centre_x_m"] + down * values["centre_y_m"])
    work, spring, damping, platform = -mass * base * (speed + velocity), none, none, {}
    if scene.has_platform:
        own, stiffness, dashpot = scene.platform()
        kinetic = kinetic + own * velocity**2 / 2
        gravity = gravity - own * along * drift
        work = work - own * base * velocity
        spring, damping = stiffness * drift**2 / 2, _integral(time, dashpot * velocity**2)
        platform = {
            "platform.drift_m": drift,
            "platform.velocity_m_s": velocity,
            "platform.acceleration_m_s2": found.drift_acceleration,
            "foundation.base_shear_N": stiffness * drift + dashpot * velocity,
        }
    return platform | {
        "time_s": time,
        "step_s": none + scene.time.step,
        "base.acceleration_m_s2": base,
        "base.vertical_acceleration_m_s2": heave,
        **{f"{name}.{column}": value for column, value in values.items()},
        f"{name}.penetration_m": none,
        "energy.kinetic_J": kinetic,
        "energy.strain_J": none,
        "energy.gravity_J": gravity,
        "energy.spring_J": spring,
        "energy.interface_J": none,
        "energy.friction_J": none + lost,
        "energy.input_J": _integral(time, work - mass * heave * rise),
        "energy.damping_J": damping,
        "energy.total_J": kinetic + gravity + spring,
    }
