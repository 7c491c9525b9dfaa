"""Closed forms of a block that slides on rigid ground (Newmark 1965)."""

from __future__ import annotations

import math


def sliding_stop(*, speed: float, friction: float, gravity: float) -> tuple[float, float]:
    """Distance v^2 / (2 mu g), m, and time v / (mu g), s, in which friction stops a block.

    The ground is level and at rest; the block is given a speed and nothing else.

    Args:
        speed: v, m/s.
        friction: mu > 0.
        gravity: g, m/s^2.
    """
    return speed**2 / (2 * friction * gravity), speed / (friction * gravity)


def sliding_block(
    *, acceleration: float, duration: float, friction: float, gravity: float
) -> float:
    """Magnitude of the slip after a rectangular pulse of ground acceleration, m.

    The slip is V^2 / (2 mu g) (1 - mu g / a) with V = a t_1; the block is left behind, against the
    pulse. It is 0 where the ground cannot make the block slide, a <= mu g.

    Args:
        acceleration: a > 0, m/s^2.
        duration: t_1, s.
        friction: mu > 0.
        gravity: g, m/s^2.
    """
    yielding = friction * gravity
    speed = acceleration * duration
    return max(0.0, speed**2 / (2 * yielding) * (1 - yielding / acceleration))


def incline_distance(*, slope: float, friction: float, gravity: float, time: float) -> float:
    """Distance that a block slides down an incline from rest, m; 0 where friction holds it.

    The distance is g (sin b - mu cos b) t^2 / 2.

    Args:
        slope: b, rad.
        friction: mu.
        gravity: g, m/s^2.
        time: t, s.
    """
    rate = gravity * (math.sin(slope) - friction * math.cos(slope))
    return max(0.0, rate) * time**2 / 2
