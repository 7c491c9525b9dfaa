"""Angular velocities of a block just before and after an impact, on a base that moves.

An elastic block vibrates after an impact, and bounces on the corner it came down on, so that its
angular velocity of one instant says little. What a rigid block would do between two impacts is
known but for two numbers, its angle and its angular velocity at the impact, and these follow from
all rows of a while by least squares. The while is 0.4/p, or the swing if that is shorter. For rigid
blocks on shaken ground this gives Housner's restitution to 1e-4; for an elastic block it is within
0.004 of what the peaks of free rocking give.
"""

from __future__ import annotations

import numpy as np

from geometry.block import Block
from solver.types import Array

WINDOW = 0.4
"""Time that an angular velocity is read from, over the time scale of rocking 1/p."""

FEWEST_ROWS = 4
"""Rows that it takes at least."""


def rocking_acceleration(angle: Array, shape: Block, along: Array, down: Array) -> Array:
    """Angular acceleration of a rigid block that rocks about a corner, 1/s2 (Housner 1963).

    -3/(4 R) (sgn(theta) g sin(alpha - |theta|) + a cos(alpha - |theta|)), where a is the
    acceleration of the base against gravity's part along it and g holds the base's acceleration
    upwards, m/s2.
    """
    from_balance = shape.slenderness - np.abs(angle)
    torque = np.sign(angle) * down * np.sin(from_balance) + along * np.cos(from_balance)
    return np.asarray(-3 / (4 * shape.half_diagonal) * torque)


def angular_velocity(time: Array, angle: Array, acceleration: Array, at: float) -> float | None:
    """Angular velocity at one end of these rows, 1/s; None where they are too few.

    By rocking angles (rad) and angular accelerations of a rigid block (1/s2) at times, and the time
    of an impact at the beginning or at the end of them, s.
    """
    if len(time) < FEWEST_ROWS:
        return None
    step, since = np.diff(time), time - at
    gained = np.concatenate([[0.0], np.cumsum(step * (acceleration[1:] + acceleration[:-1]) / 2)])
    moved = step * gained[:-1] + step**2 * (2 * acceleration[:-1] + acceleration[1:]) / 6
    free = angle - np.concatenate([[0.0], np.cumsum(moved)])
    weight = np.sqrt(np.gradient(time))  # rows crowd around impacts
    slope = float(np.polynomial.polynomial.polyfit(since, free, 1, w=weight)[1])
    end = 0 if abs(since[0]) < abs(since[-1]) else -1
    return slope + float(gained[end] - acceleration[end] * since[end])
