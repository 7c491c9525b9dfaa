"""A rigid block that rocks on a rigid platform on a spring and a dashpot, event by event.

The platform moves horizontally; M is its mass, V its velocity and A its acceleration, a_g included.
With the block's mass m, the lean phi = alpha - |theta| of its half diagonal and s = sgn theta,

    I_o theta'' + m R cos(phi) A = -m R s (g + a_v) sin(phi)
    m R cos(phi) theta'' + (m + M) A = -c V - k u - m R s sin(phi) theta'^2

between impacts; at an impact w+ = e w- about the new corner, and the horizontal momentum stays:
V+ - V- = -kappa h (w+ - w-), kappa = m/(m + M), h the half height. docs/reference.md derives it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from geometry.block import Block
from solver.reference.housner import RockingReference, rests
from solver.reference.phases import Acceleration, Recorder, event, output_times, solve, still
from solver.reference.platform import BEYOND
from solver.scene import Platform
from solver.types import Array


@dataclass(frozen=True, slots=True, kw_only=True)
class RockingOnPlatformReference(RockingReference):
    """History of a block that rocks on a platform, and of the platform."""

    angular_acceleration: Array
    """theta'', rad/s^2; 0 at rest."""
    drift: Array
    """Displacement u of the platform relative to the ground, m."""
    drift_velocity: Array
    """V, m/s."""
    drift_acceleration: Array
    """A - a_g, m/s^2."""


def restitution_on_platform(shape: Block, platform_mass: float) -> float:
    """Ratio of angular velocities across an impact without rebound, on a platform that is free.

    [h^2 (4/3 - kappa) - (2/3) b^2]/[h^2 (4/3 - kappa) + (4/3) b^2], b and h half of width and
    height: the angular momentum about the new corner and the horizontal momentum stay. Housner's
    ratio for a heavy platform.
    """
    kappa = shape.mass / (shape.mass + platform_mass)
    high, wide = (4 / 3 - kappa) * (shape.height / 2) ** 2, (shape.width / 2) ** 2
    return (high - 2 / 3 * wide) / (high + 4 / 3 * wide)


def rocking_on_platform(
    shape: Block,
    platform: Platform,
    *,
    gravity: float,
    tilt: float = 0.0,
    end: float,
    step: float,
    acceleration: Acceleration = still,
    vertical: Acceleration = still,
    along: float = 0.0,
    drift: float = 0.0,
    restitution: float | None = None,
) -> RockingOnPlatformReference:
    """Rocking without sliding or bouncing, on a platform that begins at rest.

    Args:
        shape: The block.
        platform: Mass, stiffness and damping of the empty platform.
        gravity: g across the platform, m/s^2.
        tilt: Angle of release, rad, without angular velocity; 0: at rest.
        end: s.
        step: Between output times, s; also the largest step of the integrator.
        acceleration: a_g of the ground, m/s^2.
        vertical: a_v of the ground upwards, m/s^2, > -g.
        along: Gravity along the platform, m/s^2: an incline.
        drift: Of the platform at the start, m.
        restitution: e; None: that of an impact without rebound, 0 where it would be negative.
    """
    plastic = max(0.0, restitution_on_platform(shape, platform.mass))
    ratio = plastic if restitution is None else restitution
    if not 0 <= ratio <= 1 or not abs(tilt) < math.pi / 2:
        raise ValueError(f"rocking_on_platform: tilt={tilt}, restitution={ratio}")
    pair = _Pair(
        shape,
        platform,
        gravity,
        ground=lambda time: acceleration(time) - along,
        vertical=vertical,
        span=(end, step),
    )
    recorder = Recorder(output_times(end, step), size=4)
    events = pair.follow(np.array([tilt, 0.0, drift, 0.0]), ratio, recorder)
    turning, under = pair.accelerations(recorder.time, recorder.states)
    return RockingOnPlatformReference(
        time=recorder.time,
        angle=recorder.states[:, 0],
        angular_velocity=recorder.states[:, 1],
        impacts=np.array(events.impacts),
        peaks=np.array(events.peaks),
        overturned=events.overturned,
        angular_acceleration=turning,
        drift=recorder.states[:, 2],
        drift_velocity=recorder.states[:, 3],
        drift_acceleration=under,
    )


class _Events(NamedTuple):
    """What happens to a block."""

    impacts: list[float]
    """Times, s."""
    peaks: list[float]
    """Angles at which swings turn round, rad."""
    overturned: bool
    """Whether it falls over, after which it lies."""


@dataclass(frozen=True, slots=True)
class _Pair:
    """Block and platform between two events; states are theta, theta', u, V."""

    shape: Block
    platform: Platform
    gravity: float
    ground: Acceleration
    """a_g, an incline counted in, m/s^2."""
    vertical: Acceleration
    span: tuple[float, float]
    """End and longest step, s."""

    def follow(self, state: Array, restitution: float, recorder: Recorder) -> _Events:
        """Go from event to event, from a state at time 0 to the end, recording all of it."""
        impacts: list[float] = []
        peaks: list[float] = []
        time, overturned = 0.0, False
        while time < self.span[0]:
            side = self.side(time, state)
            phase = self.swing(side, time, state) if side else self.stand(time, state)
            recorder.move(time, phase.t[-1], phase.sol)
            time, state = float(phase.t[-1]), phase.y[:, -1].copy()
            if not side:
                continue
            peaks.extend(found[0] for found in phase.y_events[2])
            if len(phase.t_events[0]):
                impacts.append(time)
                left = restitution * state[1]
                halts = rests(self.shape, self.gravity, left)
                state = self.turned(state, 0.0, 0.0 if halts else left)
            elif len(phase.t_events[1]):
                overturned, state = True, self.turned(state, side * math.pi / 2, 0.0)
        return _Events(impacts, peaks, overturned)

    def _arms(self, angle: float, side: float) -> tuple[float, float]:
        """How far the centre moves along x, and upwards, while the block turns by a radian, m."""
        lean, radius = self.shape.slenderness - abs(angle), self.shape.half_diagonal
        return radius * math.cos(lean), side * radius * math.sin(lean)

    def _needed(self, state: Array) -> float:
        """Acceleration of both together while the block stands or lies, a_g included, m/s^2."""
        m, k, c = self.platform
        return float(-(c * state[3] + k * state[2]) / (m + self.shape.mass))

    def _excess(self, time: float, state: Array, factor: float) -> float:
        """By how much it exceeds what uplifts the block, times a factor near one, m/s^2."""
        limit = (self.gravity + self.vertical(time)) * math.tan(self.shape.slenderness)
        return abs(self._needed(state)) - factor * limit

    def side(self, time: float, state: Array) -> float:
        """To which side the block leans from here on, +1 or -1; 0: it stands, or lies."""
        angle, velocity = state[:2]
        if abs(angle) >= math.pi / 2:
            return 0.0
        if angle or velocity:
            return math.copysign(1.0, angle or velocity)
        if self._excess(time, state, 1.0) <= 0:
            return 0.0
        return -math.copysign(1.0, self._needed(state))  # the block stays behind the platform

    def turned(self, state: Array, angle: float, velocity: float) -> Array:
        """The state after a jump to an angular velocity that leaves the horizontal momentum."""
        across, _ = self._arms(angle, 1.0)
        share = self.shape.mass / (self.shape.mass + self.platform.mass)
        jump = -share * across * (velocity - state[1])
        return np.array([angle, velocity, state[2], state[3] + jump])

    def rates(self, time: float, state: Array, side: float) -> tuple[float, float]:
        """Angular acceleration in a swing, and A, the platform's acceleration with a_g."""
        angle, velocity, drift, speed = state
        m, k, c = self.platform
        mass, inertia = self.shape.mass, self.shape.rotary_inertia_about_corner
        across, up = self._arms(angle, side)
        moment = -mass * up * (self.gravity + self.vertical(time))
        force = -c * speed - k * drift - mass * up * velocity**2
        coupling = mass * across
        whole = inertia * (m + mass) - coupling**2
        turning = (moment * (m + mass) - coupling * force) / whole
        return turning, (inertia * force - coupling * moment) / whole

    def swing(self, side: float, start: float, state: Array) -> Any:
        """About one corner, up to impact (event 0) or overturning (event 1); event 2: a peak."""

        def derivative(time: float, y: Array) -> tuple[float, float, float, float]:
            turning, under = self.rates(time, y, side)
            return y[1], turning, y[3], under - self.ground(time)

        events = [
            event(lambda time, y: side * y[0], falling=True, terminal=True),
            event(lambda time, y: side * y[0] - math.pi / 2, falling=False, terminal=True),
            event(lambda time, y: side * y[1], falling=True, terminal=False),
        ]
        end, step = self.span
        return solve(derivative, (start, end), state, step=step, events=events)

    def stand(self, start: float, state: Array) -> Any:
        """Block and platform as one oscillator: until the block uplifts, or, lying, to the end."""

        def derivative(time: float, y: Array) -> tuple[float, float, float, float]:
            return 0.0, 0.0, y[3], self._needed(y) - self.ground(time)

        def excess(time: float, y: Array) -> float:
            return self._excess(time, y, BEYOND)

        end, step = self.span
        events = [] if state[0] else [event(excess, falling=False, terminal=True)]
        return solve(derivative, (start, end), state, step=step, events=events)

    def accelerations(self, times: Array, states: Array) -> tuple[Array, Array]:
        """Angular accelerations and the platform's without a_g, at many times."""
        found = np.zeros((len(times), 2))
        for row, time in enumerate(map(float, times)):
            state = states[row]
            swings = 0 < abs(state[0]) < math.pi / 2 or state[1] != 0
            side = math.copysign(1.0, state[0] or state[1])
            rates = self.rates(time, state, side) if swings else (0.0, self._needed(state))
            found[row] = rates[0], rates[1] - self.ground(time)
        return found[:, 0], found[:, 1]
