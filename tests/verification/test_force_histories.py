"""Forces of the history are those that move the block: integrated twice they are its way."""

from __future__ import annotations

import numpy as np
import pytest

from rockslip import History, parse_scene, simulate
from solver.scene import Scene
from solver.types import Array

BLOCK = """
[[block]]
name = "low"
model = "rigid"
width = 0.3
height = 0.9
mass = 200.0
friction = 0.6
tilt_deg = 4.0
{more}
[time]
end = 1.0
step = 2.5e-4
"""
SHAKEN = """
[[block]]
name = "up"
on = "low"
model = "rigid"
width = 0.25
height = 0.3
mass = 50.0
friction = 0.3
[foundation]
kind = "oscillator"
mass_ratio = 2.0
period = 0.4
damping_ratio = 0.05
[motion]
kind = "sine"
amplitude_g = 0.5
period = 0.5
[motion.vertical]
kind = "sine"
amplitude_g = 0.4
period = 0.3
"""
SPACE = "dimension = 3\n"


def way(mass: float, force: Array, step: Array) -> Array:
    """The way of a mass from rest under the mean forces of steps, by the trapezoidal rule, m."""
    velocity = np.cumsum(force * step) / mass
    before = np.concatenate([[0.0], velocity[:-1]])
    moved: Array = np.cumsum(step * (before + velocity) / 2)
    return moved


def gravity_and_ground(scene: Scene, history: History, along: int, column: str) -> Array:
    """The acceleration of gravity less that of the ground, m/s2; the ground's mean over a step."""
    gravity = np.full(len(history) - 1, scene.gravity_vector[along])
    if column in history:
        ground = history[column]
        gravity -= (ground[1:] + ground[:-1]) / 2
    return gravity


@pytest.mark.parametrize(("incline", "restitution"), [(0.0, 0.9), (3.0, None)])
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("shaken", [False, True], ids=["rocks", "stack on a platform"])
def test_forces_integrate_to_the_way_of_the_blocks(
    dimension: int, incline: float, restitution: float | None, shaken: bool
) -> None:
    """Impacts and the impulses of velocities included, in the plane and in space."""
    text = f"gravity_tilt_deg = {incline}\n"
    more = "" if restitution is None else f"restitution = {restitution}\n"
    text += BLOCK.format(more=more + (SHAKEN if shaken else ""))
    if dimension == 3:
        text = SPACE + text.replace("width", "thickness = 0.3\nwidth")
    scene = parse_scene(text)
    history = simulate(scene).history
    step, vertical = history["step_s"][1:], "xyz"[dimension - 1]
    names = [block.name for block in scene.blocks]
    assert np.abs(history["low.angle_rad"]).max() > 0.05
    for number, name in enumerate(names):
        mass = scene.blocks[number].shape.mass
        forces = {"x": history[f"{name}.friction_force_N"][1:].copy()}
        forces[vertical] = history[f"{name}.normal_force_N"][1:].copy()
        for between in names[1:]:  # in the frame of the block below, which leans
            lean, sign = history["low.angle_rad"], 1.0 if between == name else -1.0
            lean = (lean[1:] + lean[:-1]) / 2
            normal = sign * history[f"{between}.normal_force_N"][1:]
            friction = sign * history[f"{between}.friction_force_N"][1:]
            if between == name:
                forces["x"], forces[vertical] = np.zeros(len(step)), np.zeros(len(step))
            forces["x"] += friction * np.cos(lean) + normal * np.sin(lean)
            forces[vertical] += normal * np.cos(lean) - friction * np.sin(lean)
        for axis, force in forces.items():
            along = 0 if axis == "x" else -1
            ground = "base.acceleration_m_s2" if axis == "x" else "base.vertical_acceleration_m_s2"
            force += mass * gravity_and_ground(scene, history, along, ground)
            centre = history[f"{name}.centre_{axis}_m"]
            found = centre[0] + way(mass, force, step)
            # Rows do not tell when in a step an impact comes: each leaves up to 0.3 m/s dt.
            np.testing.assert_allclose(found, centre[1:], rtol=0, atol=5e-4)
