"""Sliding of a rigid block on rigid ground that moves: stick and slip, event by event."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solver.reference.friction import Resistance, coulomb
from solver.reference.phases import (
    Acceleration,
    Recorder,
    event,
    first_beyond,
    output_times,
    solve,
    still,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class SlidingReference:
    """History of a sliding block, relative to the ground."""

    time: NDArray[np.float64]
    """s."""
    slip: NDArray[np.float64]
    """Displacement of the block relative to the ground, m, positive towards +x."""
    velocity: NDArray[np.float64]
    """Velocity of the block relative to the ground, m/s."""


def sliding(
    *,
    acceleration: Acceleration,
    friction: float | Resistance,
    gravity: float,
    end: float,
    step: float,
    velocity: float = 0.0,
    vertical: Acceleration = still,
) -> SlidingReference:
    """Sliding from rest or from an initial velocity, without rocking.

    With Coulomb's law the block sticks while |a_g| <= mu g; else u'' = -a_g - mu g sgn u', up to
    u' = 0. On an incline of angle b the same holds with gravity g cos b and acceleration
    a_g - g sin b.

    Args:
        acceleration: a_g of the ground, m/s^2.
        friction: mu, or a law.
        gravity: g, m/s^2.
        end: s.
        step: Between output times, s; also the largest step of the integrator.
        velocity: Of the block at the start, m/s.
        vertical: Acceleration of the ground upwards, m/s^2, > -g.
    """
    law = friction if isinstance(friction, Resistance) else coulomb(friction)
    block = _Slider(acceleration, lambda time: gravity + vertical(time), law, end, step)
    recorder = Recorder(output_times(end, step))
    time, slip, speed = 0.0, 0.0, velocity
    slipped = speed != 0
    while time < end:
        recorder.rest(time, slip)
        start, way = (time, math.copysign(1, speed)) if speed else block.uphold(time, slipped)
        if start >= end:
            break
        phase = block.slide(way, start, slip, speed)
        recorder.move(start, phase.t[-1], phase.sol)
        time, slip, speed, slipped = float(phase.t[-1]), float(phase.y[0, -1]), 0.0, True
    return SlidingReference(
        time=recorder.time, slip=recorder.states[:, 0], velocity=recorder.states[:, 1]
    )


@dataclass(frozen=True, slots=True)
class _Slider:
    """The block between two events."""

    ground: Acceleration
    normal: Acceleration
    law: Resistance
    end: float
    step: float

    def uphold(self, time: float, slipped: bool) -> tuple[float, float]:
        """When a block that stands still begins to slide, the end if never, and which way.

        One that has just come to a stop goes on at once where friction cannot hold it.
        """
        start: float | None = time
        if not (slipped and abs(self.ground(time)) > self.law.slides(self.normal(time), 0.0)):
            start = first_beyond(
                self.ground,
                lambda later: self.law.holds(self.normal(later), slipped),
                time,
                self.end,
                self.step,
            )
        if start is None:
            return self.end, 1.0
        # The block stays behind the ground.
        return start, -math.copysign(1, self.ground(start))

    def slide(self, way: float, start: float, slip: float, speed: float) -> Any:
        """Sliding one way, +1 or -1, until the velocity vanishes."""

        def rate(time: float, velocity: float) -> float:
            force = self.law.slides(self.normal(time), abs(velocity))
            return -self.ground(time) - way * force

        return solve(
            lambda time, y: (y[1], rate(time, y[1])),
            (start, self.end),
            (slip, speed),
            step=self.step,
            events=[event(lambda time, y: way * y[1], falling=True, terminal=True)],
        )
