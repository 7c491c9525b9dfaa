"""Effective mass of a block on a platform: the mass that, moved with it, needs the same friction.

Where a block lands or topples, the accelerations of rows beside the impact are as large as steps
are short, and in meshed structures they swing to and fro from row to row. Motion and force are
therefore compared as means over a window, both with the same weights: from displacements, and from
what forces have added up to.
"""

from __future__ import annotations

import math

import numpy as np

from solver.excitation.sampled import running_integral
from solver.history.history import History
from solver.scene import BlockSpec, Scene
from solver.scene.motion import G_UNIT
from solver.types import Array

WINDOW = 0.05
"""Length of the window, over the time scale of rocking 1/p."""

MEANS_A_WINDOW = 4
"""Number of means that begin within one window."""

AT_REST = 1e-9
"""Acceleration that is round-off, g."""


def friction_mass_ratio(block: BlockSpec, scene: Scene, history: History) -> float:
    """The mass whose inertia force is nearest to a block's friction, over that of all it carries.

    The block itself is part of that. Nearest in the mean square over time, if it moved with the
    platform: 1 where all of it sticks. Not a number where the platform does not move, or not for
    two windows. It is no measure of drift, and not the lambda of `rockslip study inertia`.
    """
    time, mass = history["time_s"], scene.stacked_mass(block)
    frequency = block.shape.frequency(scene.gravity)
    window = WINDOW / frequency if frequency > 0 else 0.0
    if not 0 < 2 * window < time[-1] - time[0]:
        return math.nan
    ground = running_integral(time, running_integral(time, history["base.acceleration_m_s2"]))
    inertial = history[f"{block.name}.friction_force_N"] + mass * scene.gravity_vector[0]
    impulse = np.cumsum(np.diff(time, prepend=time[:1]) * inertial)  # forces are means of steps
    moved = _means(time, history["platform.drift_m"] + ground, window)
    pushed = _means(time, running_integral(time, impulse), window)
    if np.abs(moved).max() <= AT_REST * G_UNIT:
        return math.nan
    return float(pushed @ moved) / (mass * float(moved @ moved))


def _means(time: Array, twice: Array, window: float) -> Array:
    """Means of what adds up, twice, to these values: over two windows, most in their middle."""
    begin = np.arange(time[0], time[-1] - 2 * window, window / MEANS_A_WINDOW)
    first, middle, last = (np.interp(begin + k * window, time, twice) for k in range(3))
    return np.asarray((last - 2 * middle + first) / window**2)
