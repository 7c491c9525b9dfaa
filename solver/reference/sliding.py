"""Sliding of a rigid block on rigid ground that moves: stick and slip, event by event."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solver.reference.phases import (
    Acceleration,
    Recorder,
    event,
    first_beyond,
    integrate,
    output_times,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class SlidingReference:
    """History of a sliding block, relative to the ground."""

    time: NDArray[np.float64]
    """s."""
    slip: NDArray[np.float64]
    """Displacement of the block relative to the ground, m, positive towards +x."""
    velocity: NDArray[np.float64]
    """Of the block relative to the ground, m/s."""


def sliding(
    *, acceleration: Acceleration, friction: float, gravity: float, end: float, step: float
) -> SlidingReference:
    """Sliding from rest, without rocking.

    The block sticks while |a_g| <= mu g; else u'' = -a_g - mu g sgn u', up to u' = 0. On an incline
    of angle b the same holds with gravity g cos b and acceleration a_g - g sin b.

    Args:
        acceleration: a_g of the ground, m/s^2.
        friction: mu.
        gravity: g, m/s^2.
        end: s.
        step: Between output times, s; also the largest step of the integrator.
    """
    recorder = Recorder(output_times(end, step))
    time, slip = 0.0, 0.0
    while time < end:
        recorder.rest(time, slip)
        start = first_beyond(acceleration, friction * gravity, time, end, step)
        if start is None or start >= end:
            break
        # The block stays behind the ground.
        way = -math.copysign(1, acceleration(start))
        phase = _slide(way, acceleration, friction * gravity, (start, end, step), slip)
        recorder.move(start, phase.t[-1], phase.sol)
        time, slip = phase.t[-1], phase.y[0, -1]
    return SlidingReference(time=recorder.time, slip=recorder.position, velocity=recorder.velocity)


def _slide(
    way: float,
    acceleration: Acceleration,
    friction: float,
    span: tuple[float, float, float],
    slip: float,
) -> Any:
    """Sliding one way, +1 or -1, until the velocity vanishes."""
    start, end, step = span

    def rate(time: float, position: float) -> float:
        return -acceleration(time) - friction * way

    stop = event(lambda time, y: way * y[1], falling=True, terminal=True)
    return integrate(rate, start, end, (slip, 0.0), step=step, events=[stop])
