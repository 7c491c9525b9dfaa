"""A rigid block that slides on a rigid platform on a spring and a dashpot, event by event.

m_L (a_L + a_g) + f = 0 for the block and m_P (a_P + a_g) + c v_P + k u_P - f = 0 for the platform,
all relative to the ground; f is the friction force on the platform. The block sticks while friction
holds f = -m_L (a_P + a_g), and then both are one oscillator.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from solver.reference.friction import Resistance, coulomb
from solver.reference.phases import (
    Acceleration,
    Recorder,
    event,
    first_step,
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
    vertical: Acceleration = still,
) -> PlatformReference:
    """Sliding on a platform that begins at rest with its spring unstretched.

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
        vertical: Acceleration of the ground upwards, m/s^2, > -g.
    """
    law = friction if isinstance(friction, Resistance) else coulomb(friction)
    pair = _Pair(
        platform,
        mass,
        lambda time: acceleration(time) - along,
        lambda time: gravity + vertical(time),
        law,
    )
    recorder = Recorder(output_times(end, step), size=4)
    time, state, slipped = 0.0, np.array([0.0, velocity, 0.0, 0.0]), velocity != 0
    while time < end:
        way = pair.way(time, state, slipped)
        phase = pair.move(way, slipped, (time, end, step), state)
        recorder.move(time, phase.t[-1], phase.sol)
        time, state = float(phase.t[-1]), phase.y[:, -1].copy()
        if way:
            state[1], slipped = 0.0, True
    return _result(pair, recorder)


@dataclass(frozen=True, slots=True)
class _Pair:
    """The block and its platform; states are slip, its rate, drift, its rate."""

    platform: Platform
    mass: float
    ground: Acceleration
    normal: Acceleration
    law: Resistance

    def needed(self, state: Any) -> Any:
        """Force that holds the block, over its mass, m/s^2: a_P + a_g of both together."""
        p = self.platform
        return -(p.damping * state[3] + p.stiffness * state[2]) / (p.mass + self.mass)

    def way(self, time: float, state: Array, slipped: bool) -> float:
        """Direction in which the block slides from here on, +1 or -1; 0 if it sticks."""
        if state[1] != 0 or self.law.none:
            return math.copysign(1, state[1])
        normal, needed = self.normal(time), float(self.needed(state))
        limit = self.law.slides(normal, 0.0) if slipped else self.law.holds(normal, slipped)
        # The block stays behind the platform.
        return 0.0 if abs(needed) <= limit else -math.copysign(1, needed)

    def acceleration(self, time: float, state: Any, force: Any) -> Any:
        """Acceleration a_P of the platform under a force on the block, given over its mass."""
        p = self.platform
        pull = p.damping * state[3] + p.stiffness * state[2] + self.mass * force
        return -self.ground(time) - pull / p.mass

    def move(
        self, way: float, slipped: bool, span: tuple[float, float, float], state: Array
    ) -> Any:
        """Stick until friction gives way, or slide until the slip rate vanishes."""
        start, end, step = span
        derivative = self._sliding(way) if way else self._sticking
        first = first_step(end - start, step, float(state[1]), derivative(start, state)[1])

        def excess(time: float, y: Array) -> float:
            return abs(float(self.needed(y))) - BEYOND * self.law.holds(self.normal(time), slipped)

        stop = event(lambda time, y: way * y[1], falling=True, terminal=True)
        give = event(excess, falling=False, terminal=True)
        events = [] if self.law.none else [stop if way else give]
        return solve(derivative, (start, end), state, step=step, first=first, events=events)

    def _sticking(self, time: float, y: Array) -> tuple[float, float, float, float]:
        return 0.0, 0.0, y[3], self.needed(y) - self.ground(time)

    def _sliding(self, way: float) -> Callable[[float, Array], tuple[float, float, float, float]]:
        def derivative(time: float, y: Array) -> tuple[float, float, float, float]:
            force = -way * self.law.slides(self.normal(time), abs(y[1]))
            under = self.acceleration(time, y, force)
            return y[1], force - self.ground(time) - under, y[3], under

        return derivative


def _result(pair: _Pair, recorder: Recorder) -> PlatformReference:
    """The history, with accelerations and forces from the states."""
    states = recorder.states.T
    slip, rate, drift, velocity = states
    sliding = [
        -math.copysign(pair.law.slides(pair.normal(float(t)), abs(w)), w)
        for t, w in zip(recorder.time, rate, strict=True)
    ]
    force = np.where(rate != 0, sliding, pair.needed(states))
    accelerations = [
        pair.acceleration(float(t), state, f)
        for t, state, f in zip(recorder.time, recorder.states, force, strict=True)
    ]
    return PlatformReference(
        time=recorder.time,
        slip=slip,
        slip_velocity=rate,
        drift=drift,
        drift_velocity=velocity,
        drift_acceleration=np.array(accelerations),
        friction=force,
    )
