"""Rocking of a rigid block on ground that moves or on a platform there, without sliding.

On firm ground it is Housner's block (1963), nonlinear and with base motion. A platform on a spring
and a dashpot moves horizontally; M is its mass, V its velocity and A its acceleration, a_g
included. With the block's mass m, the lean phi = alpha - |theta| of its half diagonal and s = sgn
theta,

    I_o theta'' + m R cos(phi) A = -m R s (g + a_v) sin(phi)
    m R cos(phi) theta'' + (m + M) A = -c V - k u - m R s sin(phi) theta'^2

between impacts; at an impact w+ = e w- about the new corner, and the horizontal momentum stays:
V+ - V- = -kappa h (w+ - w-), kappa = m/(m + M), h the half height. On firm ground A is a_g.
docs/reference.md derives the equations. Of an uneven block R, alpha, I_o and e are those of the
edge on the side of s.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from geometry.block import SIDES, Block
from solver.reference.phases import (
    EXACT,
    Acceleration,
    Recorder,
    State,
    event,
    first_beyond,
    output_times,
    solve,
    still,
)
from solver.scene import Platform
from solver.types import Array

RESTING_ENERGY = 1e-10
"""Rocking ends when its energy falls below this part of what overturns the block at rest."""

BEYOND = 1 + 1e-11
"""A block on a platform uplifts where the limit is exceeded by more than round-off."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RockingReference:
    """History of a rocking block and of what it stands on; angles are positive towards +x."""

    time: Array
    """s."""
    angle: Array
    """theta, rad; stays at +-pi/2 once overturned."""
    angular_velocity: Array
    """rad/s."""
    angular_acceleration: Array
    """theta'', rad/s^2; 0 at rest."""
    drift: Array
    """Displacement u of the platform relative to the ground, m; 0 on firm ground."""
    drift_velocity: Array
    """V, m/s."""
    drift_acceleration: Array
    """A - a_g, m/s^2."""
    impacts: Array
    """Times of the impacts, s."""
    peaks: Array
    """Angles at which the block turned back, rad, signed, that of its release included."""
    overturned: bool


def housner(
    shape: Block,
    *,
    gravity: float,
    tilt: float = 0.0,
    end: float,
    step: float,
    acceleration: Acceleration = still,
    vertical: Acceleration = still,
    restitution: float | None = None,
    platform: Platform | None = None,
    along: float = 0.0,
    drift: float = 0.0,
    longest: float | None = None,
    tolerance: float = EXACT,
) -> RockingReference:
    """Rocking from a tilt or from rest, without sliding and without bouncing.

    On firm ground theta'' = -3/(4 R) [(g + a_v) sin(alpha sgn theta - theta) + a_g cos(alpha sgn
    theta - theta)] between impacts and w+ = e w- at impacts; from rest the block uplifts when |a_g|
    > (g + a_v) B/H (Yim, Chopra and Penzien 1980). On an incline of angle b the same holds with
    gravity g cos b and acceleration a_g - g sin b. An uneven block has R, alpha, I_o and e of the
    edge that it turns about, or lands on.

    Args:
        shape: The block.
        gravity: g across the ground, m/s^2.
        tilt: Angle of release, rad, without angular velocity; 0: at rest.
        end: s.
        step: Between output times, s; in such steps uplift is looked for, too.
        acceleration: a_g of the ground, m/s^2.
        vertical: a_v of the ground upwards, m/s^2, > -g.
        restitution: e; None: that of an impact without rebound (Housner's on firm ground), 0 for
            blocks so squat that it would be negative.
        platform: Mass, stiffness and damping of the empty platform, which begins at rest; None:
            firm ground.
        along: Gravity along the ground, m/s^2: an incline.
        drift: Of the platform at the start, m.
        longest: Longest step of the integrator over ground that moves, s; None: `step`.
        tolerance: Relative, of the integrator.
    """
    share = shape.mass / (shape.mass + platform.mass) if platform else 0.0
    ratios = {side: max(0.0, shape.restitution(side, share)) for side in SIDES}
    if restitution is not None:
        ratios = dict.fromkeys(SIDES, restitution)
    if not all(0 <= ratio <= 1 for ratio in ratios.values()) or not abs(tilt) < math.pi / 2:
        raise ValueError(f"housner: tilt={tilt}, restitution={ratios[1]}")
    # Over ground that moves, no feature of its motion may be stepped over.
    free = platform is None and acceleration is still and vertical is still
    block = _Rocker(
        shape=shape,
        platform=platform,
        gravity=gravity,
        ground=acceleration if not along else lambda time: acceleration(time) - along,
        vertical=vertical,
        end=end,
        step=step,
        longest=math.inf if free else longest or step,
        tolerance=tolerance,
    )
    recorder = Recorder(output_times(end, step), size=4)
    impacts, peaks, overturned = block.follow(np.array([tilt, 0.0, drift, 0.0]), ratios, recorder)
    turning, under = block.accelerations(recorder.time, recorder.states)
    angle, velocity, drifts, drift_velocity = recorder.states.T
    return RockingReference(
        time=recorder.time,
        angle=angle,
        angular_velocity=velocity,
        angular_acceleration=turning,
        drift=drifts,
        drift_velocity=drift_velocity,
        drift_acceleration=under,
        impacts=np.array(impacts),
        peaks=np.array(peaks),
        overturned=overturned,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class _Rocker:
    """The block and what it stands on; states are theta, theta', u, V."""

    shape: Block
    platform: Platform | None
    gravity: float
    ground: Acceleration
    """a_g, an incline counted in, m/s^2."""
    vertical: Acceleration
    end: float
    step: float
    """In which uplift on firm ground is looked for, s."""
    longest: float
    """Step of the integrator, s."""
    tolerance: float

    def follow(
        self, state: Array, restitution: Mapping[int, float], recorder: Recorder
    ) -> tuple[list[float], list[float], bool]:
        """Go from event to event, from a state at time 0 to the end, recording all of it.

        The restitutions are those of impacts on the edge of a side.

        Returns:
            Times of impacts (s), angles at which swings turn round (rad), True if it overturns.
        """
        impacts, peaks, time, overturned = list[float](), list[float](), 0.0, False
        while time < self.end:
            side = self._side(time, state)
            if not side and self.platform is None:
                recorder.rest(time, state[0])
                start = None if state[0] else self._uplift(time)
                if start is None or start >= self.end:
                    break
                time, side = start, self._side(start, state)
            phase = self._swing(side, time, state) if side else self._stand(time, state)
            recorder.move(time, phase.t[-1], phase.sol)
            time, state = float(phase.t[-1]), phase.y[:, -1].copy()
            if not side:
                continue
            peaks.extend(found[0] for found in phase.y_events[2])
            if len(phase.t_events[0]):
                impacts.append(time)
                left = restitution[-int(side)] * state[1]
                state = self._jump(state, 0.0, 0.0 if self._rests(left) else left)
            elif len(phase.t_events[1]):
                overturned, state = True, self._jump(state, side * math.pi / 2, 0.0)
        return impacts, peaks, overturned

    def _rests(self, velocity: float) -> bool:
        """True if an upright block has too little angular velocity (1/s) left to go on."""
        side = -1 if velocity < 0 else 1
        lean = self.shape.slenderness(side)
        barrier = self.shape.frequency(self.gravity, side) ** 2 * (1 - math.cos(lean))
        return velocity**2 / 2 <= RESTING_ENERGY * barrier

    def _arms(self, angle: float, side: float) -> tuple[float, float]:
        """Displacement of the centre along x, and upwards, per radian of rotation, m."""
        edge = int(side)
        lean, radius = self.shape.slenderness(edge) - side * angle, self.shape.radius(edge)
        return radius * math.cos(lean), side * radius * math.sin(lean)

    def _together(self, time: float, state: State) -> float:
        """Acceleration A of what the block stands on while it stands or lies, a_g included."""
        if self.platform is None:
            return self.ground(time)
        m, k, c = self.platform
        return -(c * state[3] + k * state[2]) / (m + self.shape.mass)

    def _limit(self, time: float) -> float:
        """Acceleration A that uplifts the block over the edge that is nearer, m/s^2."""
        return (self.gravity + self.vertical(time)) * math.tan(self.shape.slenderness())

    def _demand(self, acceleration: float) -> float:
        """An acceleration A, less by how much farther the edge is over which it overturns, m/s^2.

        The block stays behind what it stands on: it leans to -x where that accelerates towards +x.
        """
        side = -1 if acceleration > 0 else 1
        return acceleration * (self.shape.arm() / self.shape.arm(side))

    def _uplift(self, time: float) -> float | None:
        """Time at which the block on firm ground begins to rock, s; None: never."""

        def demand(time: float) -> float:
            return self._demand(self.ground(time))

        return first_beyond(demand, self._limit, time, self.end, self.step)

    def _side(self, time: float, state: State) -> float:
        """To which side the block leans from here on, +1 or -1; 0: it stands, or lies."""
        angle, velocity = state[:2]
        if abs(angle) >= math.pi / 2:
            return 0.0
        if angle or velocity:
            return math.copysign(1.0, angle or velocity)
        needed = self._demand(self._together(time, state))
        # The block stays behind what it stands on.
        return -math.copysign(1.0, needed) if abs(needed) > self._limit(time) else 0.0

    def _jump(self, state: Array, angle: float, velocity: float) -> Array:
        """The state after a jump to an angular velocity that leaves the horizontal momentum."""
        if self.platform is None:
            return np.array([angle, velocity, 0.0, 0.0])
        across, _ = self._arms(angle, math.copysign(1.0, angle))
        share = self.shape.mass / (self.shape.mass + self.platform.mass)
        jump = -share * across * (velocity - state[1])
        return np.array([angle, velocity, state[2], state[3] + jump])

    def _rates(self, time: float, state: State, side: float) -> tuple[float, float]:
        """Angular acceleration in a swing, and A - a_g of what carries the block."""
        angle, velocity, drift, speed = state
        mass, inertia = self.shape.mass, self.shape.rotary_inertia_about_corner(int(side))
        across, up = self._arms(angle, side)
        moment, coupling = -mass * up * (self.gravity + self.vertical(time)), mass * across
        if self.platform is None:
            return (moment - coupling * self.ground(time)) / inertia, 0.0
        m, k, c = self.platform
        force = -c * speed - k * drift - mass * up * velocity**2
        whole = inertia * (m + mass) - coupling**2
        turning = (moment * (m + mass) - coupling * force) / whole
        return turning, (inertia * force - coupling * moment) / whole - self.ground(time)

    def _swing(self, side: float, start: float, state: Array) -> Any:
        """About one corner, up to impact (event 0) or overturning (event 1); event 2: a peak."""

        def derivative(time: float, y: Array) -> tuple[float, float, float, float]:
            turning, under = self._rates(time, y, side)
            return y[1], turning, y[3], under

        events = [
            event(lambda time, y: side * y[0], falling=True, terminal=True),
            event(lambda time, y: side * y[0] - math.pi / 2, falling=False, terminal=True),
            event(lambda time, y: side * y[1], falling=True, terminal=False),
        ]
        return self._solved(derivative, start, state, events)

    def _stand(self, start: float, state: Array) -> Any:
        """Block and platform as one oscillator: until the block uplifts, or, lying, to the end."""

        def derivative(time: float, y: Array) -> tuple[float, float, float, float]:
            return 0.0, 0.0, y[3], self._together(time, y) - self.ground(time)

        def excess(time: float, y: Array) -> float:
            return abs(self._demand(self._together(time, y))) - BEYOND * self._limit(time)

        events = [] if state[0] else [event(excess, falling=False, terminal=True)]
        return self._solved(derivative, start, state, events)

    def _solved(self, derivative: Any, start: float, state: Array, events: list[Any]) -> Any:
        span = start, self.end
        return solve(
            derivative, span, state, step=self.longest, events=events, tolerance=self.tolerance
        )

    def accelerations(self, times: Array, states: Array) -> tuple[Array, Array]:
        """Angular accelerations and the platform's without a_g, at many times."""
        found = np.zeros((len(times), 2))
        for row, time in enumerate(map(float, times)):
            state = states[row]
            if 0 < abs(state[0]) < math.pi / 2 or state[1] != 0:
                found[row] = self._rates(time, state, math.copysign(1.0, state[0] or state[1]))
            else:
                found[row] = 0.0, self._together(time, state) - self.ground(time)
        return found[:, 0], found[:, 1]
