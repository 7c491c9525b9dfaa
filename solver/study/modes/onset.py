"""How a block begins to move: angular acceleration and slip acceleration, by either engine."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geometry.block import Block
from solver.scene import Scene
from solver.types import Array

SUDDEN, SUDDEN_STEPS = 0.075566, 200
"""Time from the start of a sudden acceleration that a rigid block is looked at, and its steps.

Times are over 1/p, in which blocks turn; for the paper's block they are whole ms, here 20.
"""

RAMP, WINDOW = 0.113349, (0.151133, 0.302265)
"""Time in which the ground's acceleration rises, and first and last time of what counts.

A sudden acceleration makes an elastic block overshoot; its vibration has to decay first. For the
paper's block 30, 40 and 80 ms: it bends with a period of 6 ms.
"""

LEAST = 0.01
"""Least angular acceleration, over p^2 sin alpha, and slip acceleration, over A g, that are motion.

Three per cent beyond a boundary they are at least 0.03 where there is one of them alone.
"""


@dataclass(frozen=True, slots=True)
class Onset:
    """How a block begins to move; it leans and slips against the ground's acceleration."""

    turn: float
    """theta'', rad/s^2."""
    slip: float
    """Acceleration of the slip, m/s^2."""

    def mode(self, shape: Block, acceleration: float, gravity: float) -> str:
        """Mode that these accelerations stand for: "rest", "slide", "rock" or "slide-rock".

        Args:
            shape: The block.
            acceleration: A = |a_g|/g.
            gravity: g, m/s^2.
        """
        # 3/4 g b/R^2 = p^2 sin alpha: theta'' grows by A/A_uplift - 1 times this.
        turns = self.turn > LEAST * shape.frequency(gravity) ** 2 * np.sin(shape.slenderness)
        slips = self.slip > LEAST * acceleration * gravity
        return ("slide-rock" if slips else "rock") if turns else ("slide" if slips else "rest")


def unit(scene: Scene) -> float:
    """1/p of the block of a scene, s."""
    return 1 / scene.blocks[0].shape.frequency(scene.gravity)


def sudden_onset(scene: Scene, acceleration: float) -> Onset:
    """Onset of a rigid block under a sudden acceleration of its base, A = a_g/g."""
    from solver.rigid.plane.system import PlaneSystem

    system = PlaneSystem.from_scene(scene)
    name, columns = system.names[0], system.columns
    ground = np.zeros((SUDDEN_STEPS + 1, 2))
    ground[:, 0] = acceleration * scene.gravity
    rows = system.advance(SUDDEN_STEPS, SUDDEN * unit(scene) / SUDDEN_STEPS, ground).rows
    velocity = rows[:, columns.index(f"{name}.angular_velocity_rad_s")]
    slip = rows[:, columns.index(f"{name}.slip_m")]
    time = rows[:, columns.index("time_s")]
    # The accelerations depend on the angle, and so on t^2: theta' = theta'' t + ..t^3 from rest.
    return Onset(-_first(time, velocity, 1), -2 * _first(time, slip, 2))


def _first(time: Array, values: Array, power: int) -> float:
    """Factor of t^power in the best sum of that and t^(power + 2)."""
    terms = np.stack([time**power, time ** (power + 2)], axis=1)
    return float(np.linalg.lstsq(terms / terms[-1], values, rcond=None)[0][0] / terms[-1, 0])


def ramped_onset(scene: Scene, acceleration: float) -> Onset:
    """Onset of a block, elastic or rigid, after a ramp of its base's acceleration to A = a_g/g."""
    from mpi4py import MPI

    from solver.excitation.motion import GroundMotion
    from solver.excitation.sampled import SampledMotion
    from solver.run.simulate import simulate

    level, scale = acceleration * scene.gravity, unit(scene)
    times = np.array([0.0, RAMP * scale, scene.time.end])
    ramp = SampledMotion(time=times, value=np.array([0.0, level, level]))
    ground = GroundMotion((ramp, None))
    history = simulate(scene, comm=MPI.COMM_SELF, ground=ground).history
    name, time = scene.blocks[0].name, history["time_s"]
    turn = _fitted(time, history[f"{name}.angular_velocity_rad_s"], scale, degree=1)
    slip = 2 * _fitted(time, history[f"{name}.slip_m"], scale, degree=2)
    return Onset(-turn, -slip)


def _fitted(time: Array, values: Array, scale: float, degree: int) -> float:
    """Highest coefficient of the polynomial of a degree that fits values in the window best.

    The window is over `scale`, which is 1/p, s. Towards its ends values count less and less (Hann's
    weights), so that vibration of a few periods in it averages out.
    """
    part = np.linspace(0.0, 1.0, 401)
    at = scale * (WINDOW[0] + part * (WINDOW[1] - WINDOW[0]))
    weights = np.sin(np.pi * part)  # of the differences, which are squared
    fit = np.polyfit(at - at.mean(), np.interp(at, time, values), degree, w=weights)
    return float(fit[0])
