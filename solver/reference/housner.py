"""Rocking of a rigid block on rigid ground: Housner (1963), nonlinear, with base motion.

docs/reference.md has the equations.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.block import Block
from solver.reference.phases import (
    Acceleration,
    Recorder,
    event,
    first_beyond,
    output_times,
    solve,
    still,
)

RESTING_ENERGY = 1e-10
"""Rocking ends when its energy falls below this part of what overturns the block at rest."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RockingReference:
    """History of a rocking block; angles are positive when it leans towards +x."""

    time: NDArray[np.float64]
    """s."""
    angle: NDArray[np.float64]
    """theta, rad; stays at +-pi/2 once overturned."""
    angular_velocity: NDArray[np.float64]
    """rad/s."""
    impacts: NDArray[np.float64]
    """Times of the impacts, s."""
    peaks: NDArray[np.float64]
    """Angles at which the block turned back, rad, signed, that of its release included."""
    overturned: bool


def housner_restitution(shape: Block) -> float:
    """Ratio of angular velocities across an impact, e = 1 - 3/2 sin^2 alpha (Housner 1963)."""
    return 1 - 1.5 * math.sin(shape.slenderness) ** 2


def rests(shape: Block, gravity: float, velocity: float) -> bool:
    """Whether an upright block has too little angular velocity (1/s) left to go on."""
    barrier = shape.frequency(gravity) ** 2 * (1 - math.cos(shape.slenderness))
    return velocity**2 / 2 <= RESTING_ENERGY * barrier


def housner(
    shape: Block,
    *,
    gravity: float,
    tilt: float = 0.0,
    end: float,
    step: float,
    acceleration: Acceleration | None = None,
    vertical: Acceleration | None = None,
    restitution: float | None = None,
) -> RockingReference:
    """Rocking from a tilt or from rest, without sliding and without bouncing.

    theta'' = -3/(4 R) [(g + a_v) sin(alpha sgn theta - theta) + a_g cos(alpha sgn theta - theta)]
    between impacts and w+ = e w- at impacts; from rest the block uplifts when |a_g| > (g + a_v)
    B/H (Yim, Chopra and Penzien 1980). On an incline of angle b the same holds with gravity g cos b
    and acceleration a_g - g sin b.

    Args:
        shape: The block.
        gravity: g, m/s^2.
        tilt: Angle of release, rad, without angular velocity; 0: at rest.
        end: s.
        step: Between output times, s; where the ground moves, also the integrator's largest.
        acceleration: a_g of the ground, m/s^2; None: it does not move.
        vertical: a_v of the ground upwards, m/s^2, > -g; None: it does not move so.
        restitution: e; None: Housner's, 0 for blocks so squat that his would be negative.
    """
    ratio = max(0.0, housner_restitution(shape)) if restitution is None else restitution
    if not 0 <= ratio <= 1 or not abs(tilt) < math.pi / 2:
        raise ValueError(f"housner: tilt={tilt}, restitution={ratio}")
    moves = acceleration or still, vertical or still
    block = _RigidBlock(shape, gravity, *moves, end, step)
    recorder = Recorder(output_times(end, step))
    impacts: list[float] = []
    peaks: list[float] = []
    time, angle, velocity, overturned = 0.0, tilt, 0.0, False
    while time < end and not overturned:
        side = math.copysign(1, angle or velocity)
        if angle == 0 and rests(shape, gravity, velocity):
            recorder.rest(time, 0.0)
            time, side, velocity = *block.uplift(time), 0.0
            if time >= end:
                break
        phase = block.swing(side, time, (angle, velocity))
        recorder.move(time, phase.t[-1], phase.sol)
        peaks.extend(state[0] for state in phase.y_events[2])
        time, angle, velocity = float(phase.t[-1]), float(phase.y[0, -1]), float(phase.y[1, -1])
        overturned = len(phase.t_events[1]) > 0
        if len(phase.t_events[0]):
            impacts.append(time)
            angle, velocity = 0.0, ratio * velocity
    if overturned:
        recorder.rest(time, math.copysign(math.pi / 2, angle))
    return RockingReference(
        time=recorder.time,
        angle=recorder.states[:, 0],
        angular_velocity=recorder.states[:, 1],
        impacts=np.array(impacts),
        peaks=np.array(peaks),
        overturned=overturned,
    )


@dataclass(frozen=True, slots=True)
class _RigidBlock:
    """The motion between two events."""

    shape: Block
    gravity: float
    ground: Acceleration
    vertical: Acceleration
    end: float
    step: float

    def down(self, time: float) -> float:
        """Gravity and the ground's acceleration upwards: g + a_v, m/s^2."""
        return self.gravity + self.vertical(time)

    def uplift(self, time: float) -> tuple[float, float]:
        """When the block at rest begins to rock, and to which side; at the end if never."""
        slope = math.tan(self.shape.slenderness)
        start = first_beyond(
            self.ground, lambda later: slope * self.down(later), time, self.end, self.step
        )
        if start is None:
            return self.end, 1.0
        # The block stays behind the ground: it leans against the ground's acceleration.
        return start, -math.copysign(1, self.ground(start))

    def swing(self, side: float, start: float, state: tuple[float, float]) -> Any:
        """About one corner, side = +1 or -1, up to impact (event 0) or overturning (event 1).

        Event 2, which ends nothing, is where the block turns back.
        """
        alpha, factor = self.shape.slenderness, 3 / (4 * self.shape.half_diagonal)

        def rate(time: float, angle: float) -> float:
            lean = side * alpha - angle
            push = self.down(time) * math.sin(lean) + self.ground(time) * math.cos(lean)
            return -factor * push

        events = [
            event(lambda time, y: side * y[0], falling=True, terminal=True),
            event(lambda time, y: side * y[0] - math.pi / 2, falling=False, terminal=True),
            event(lambda time, y: side * y[1], falling=True, terminal=False),
        ]
        # Over ground that moves, no feature of its motion may be stepped over.
        stands = self.ground is still and self.vertical is still
        step = math.inf if stands else self.step
        return solve(
            lambda time, y: (y[1], rate(time, y[0])),
            (start, self.end),
            state,
            step=step,
            events=events,
        )
