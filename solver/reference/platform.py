"""A rigid block that slides on a rigid platform on a spring and a dashpot, event by event.

m_L (a_L + a_g) + f = 0 for the block and m_P (a_P + a_g) + c v_P + k u_P - f = 0 for the platform,
all relative to the ground; f is the friction force on the platform. The block sticks while friction
holds f = -m_L (a_P + a_g), and then both are one oscillator.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from solver.reference.friction import Resistance, coulomb
from solver.reference.phases import (
    Acceleration,
    Recorder,
    event,
    output_times,
    solve,
    still,
)
from solver.scene import Platform
from solver.types import Array

BEYOND = 1 + 1e-11
"""Sticking ends where friction is exceeded by more than round-off, so that sliding does begin."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PlatformReference:
    """History of a block on a platform."""

    time: Array
    """s."""
    slip: Array
    """Displacement of the block relative to the platform, m, positive towards +x."""
    slip_velocity: Array
    """m/s; exactly 0 while the block sticks."""
    drift: Array
    """Displacement u_P of the platform relative to the ground, m."""
    drift_velocity: Array
    """v_P, m/s."""
    drift_acceleration: Array
    """a_P, m/s^2."""
    friction: Array
    """Force of the platform on the block over the mass of the block, m/s^2."""


@dataclass(frozen=True, slots=True)
class Pair:
    """The block and its platform; states are slip, its rate, drift, its rate."""

    platform: Platform
    mass: float
    """Mass of the block, kg."""
    law: Resistance
    """Law of friction."""

    def needed(self, drift: Any, velocity: Any) -> Any:
        """Force that holds the block, over its mass, m/s^2: a_P + a_g of both together."""
        m, k, c = self.platform
        return -(c * velocity + k * drift) / (m + self.mass)

    def acceleration(self, ground: Any, drift: Any, velocity: Any, force: Any) -> Any:
        """Acceleration a_P of the platform under a force on the block, given over its mass."""
        m, k, c = self.platform
        return -ground - (c * velocity + k * drift + self.mass * force) / m

    def way(self, state: Iterable[float], normal: float, slipped: bool) -> float:
        """Direction in which the block slides from here on, +1 or -1; 0 if it sticks."""
        _, rate, drift, velocity = state
        if rate or self.law.none:
            return math.copysign(1, rate)
        needed = self.needed(drift, velocity)
        limit = self.law.slides(normal, 0.0) if slipped else self.law.holds(normal, slipped)
        # The block stays behind the platform.
        return 0.0 if abs(needed) <= limit else -math.copysign(1, needed)

    def history(self, time: Array, states: Array, ground: Array, slides: Any) -> PlatformReference:
        """The history, with accelerations and forces from the states, (n, 4).

        By a_g at these times, an incline counted in, and the friction on the block where it slides
        over its mass, m/s^2.
        """
        slip, rate, drift, velocity = states.T
        force = np.where(rate != 0, -np.sign(rate) * slides, self.needed(drift, velocity))
        return PlatformReference(
            time=time,
            slip=slip,
            slip_velocity=rate,
            drift=drift,
            drift_velocity=velocity,
            drift_acceleration=self.acceleration(ground, drift, velocity, force),
            friction=force,
        )


def sliding_on_platform(
    *,
    platform: Platform,
    mass: float,
    friction: float | Resistance,
    gravity: float,
    acceleration: Acceleration,
    end: float,
    step: float,
    along: float = 0.0,
    velocity: float = 0.0,
    drift: float = 0.0,
    vertical: Acceleration = still,
) -> PlatformReference:
    """Sliding on a platform that begins at rest.

    Args:
        platform: Mass, stiffness and damping of the empty platform.
        mass: Of the block, m_L, kg.
        friction: mu, or a law.
        gravity: Across the platform, m/s^2.
        acceleration: a_g of the ground, m/s^2.
        end: s.
        step: Between output times, s; also the largest step of the integrator.
        along: Gravity along the platform, m/s^2: an incline.
        velocity: Of the block at the start, relative to the ground, m/s.
        drift: Of the platform at the start, m.
        vertical: Acceleration of the ground upwards, m/s^2, > -g.
    """
    law = friction if isinstance(friction, Resistance) else coulomb(friction)
    pair = _MovingPair(
        platform,
        mass,
        law,
        ground=lambda time: acceleration(time) - along,
        normal=lambda time: gravity + vertical(time),
    )
    recorder = Recorder(output_times(end, step), size=4)
    time, state, slipped = 0.0, np.array([0.0, velocity, drift, 0.0]), velocity != 0
    while time < end:
        way = pair.way(state, pair.normal(time), slipped)
        phase = pair.move(way, slipped, (time, end, step), state)
        recorder.move(time, phase.t[-1], phase.sol)
        time, state = float(phase.t[-1]), phase.y[:, -1].copy()
        if way:
            state[1], slipped = 0.0, True
    ground = np.array([pair.ground(float(t)) for t in recorder.time])
    rows = zip(recorder.time, np.abs(recorder.states[:, 1]), strict=True)
    slides = np.array([law.slides(pair.normal(float(t)), float(speed)) for t, speed in rows])
    return pair.history(recorder.time, recorder.states, ground, slides)


@dataclass(frozen=True, slots=True, kw_only=True)
class _MovingPair(Pair):
    """Block and platform over a ground of any motion, integrated from event to event."""

    ground: Acceleration
    """a_g, an incline counted in, m/s^2."""
    normal: Acceleration
    """Gravity and the ground's acceleration across the platform, m/s^2."""

    def move(
        self, way: float, slipped: bool, span: tuple[float, float, float], state: Array
    ) -> Any:
        """Stick until friction gives way, or slide until the slip rate vanishes."""
        start, end, step = span

        def excess(time: float, y: Array) -> float:
            limit = BEYOND * self.law.holds(self.normal(time), slipped)
            return abs(float(self.needed(y[2], y[3]))) - limit

        stop = event(lambda time, y: way * y[1], falling=True, terminal=True)
        give = event(excess, falling=False, terminal=True)
        events = [] if self.law.none else [stop if way else give]
        derivative = self._sliding(way) if way else self._sticking
        return solve(derivative, (start, end), state, step=step, events=events)

    def _sticking(self, time: float, y: Array) -> tuple[float, float, float, float]:
        return 0.0, 0.0, y[3], self.needed(y[2], y[3]) - self.ground(time)

    def _sliding(self, way: float) -> Callable[[float, Array], tuple[float, float, float, float]]:
        def derivative(time: float, y: Array) -> tuple[float, float, float, float]:
            force = -way * self.law.slides(self.normal(time), abs(y[1]))
            ground = self.ground(time)
            under = self.acceleration(ground, y[2], y[3], force)
            return y[1], force - ground - under, y[3], under

        return derivative
