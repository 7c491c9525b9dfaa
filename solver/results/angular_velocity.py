"""Angular velocities of a block just before and after an impact, on a base that moves.

An elastic block vibrates after an impact, and bounces on the corner it came down on, so that its
angular velocity of one instant says little. What a rigid block would do between two impacts is
known but for two numbers, its angle and its angular velocity at the impact, and these follow from
all rows of a while by least squares. The while is 0.4/p, or the swing if that is shorter. For rigid
blocks on shaken ground this gives Housner's restitution to 1e-4; for an elastic block it is within
0.004 of what the peaks of free rocking give. At the impact the angle is zero: where it is not, the
swing does not follow the impact, but an impact too small to be seen.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geometry.block import Block
from solver.excitation.sampled import running_integral
from solver.types import Array

WINDOW = 0.4
"""Time that an angular velocity is read from, over the time scale of rocking 1/p."""

SETTLING = 0.01
"""Time after an impact, over 1/p, in which a platform's acceleration is that of its end: what the
impact does to the platform is no acceleration that the block feels later."""

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


class RigidMoment(NamedTuple):
    """Motion of a rigid block at an instant."""

    angle: float
    """Its angle, rad."""
    velocity: float
    """Its angular velocity, 1/s."""


def rigid_moment(time: Array, angle: Array, acceleration: Array, at: float) -> RigidMoment | None:
    """The rigid block's motion at one end of these rows; None where they are too few.

    By rocking angles (rad) and angular accelerations of a rigid block (1/s2) at times, and the time
    of an impact at the beginning or at the end of them, s.
    """
    if len(time) < FEWEST_ROWS:
        return None
    step, since = np.diff(time), time - at
    gained = running_integral(time, acceleration)
    moved = step * gained[:-1] + step**2 * (2 * acceleration[:-1] + acceleration[1:]) / 6
    fallen = np.concatenate([[0.0], np.cumsum(moved)])
    weight = np.sqrt(np.gradient(time))  # rows crowd around impacts
    start, slope = np.polynomial.polynomial.polyfit(since, angle - fallen, 1, w=weight)
    end = 0 if abs(since[0]) < abs(since[-1]) else -1
    way, rate = float(since[end]), float(acceleration[end])
    velocity = float(slope + gained[end])  # at the row next to the impact; from there at a rate
    there = float(start + slope * way + fallen[end])
    return RigidMoment(there - velocity * way + rate * way**2 / 2, velocity - rate * way)
