"""Sliding of a rigid block that stays flat, on ground that moves or on a platform there.

The platform stands on a spring and a dashpot: m_L (a_L + a_g) + f = 0 for the block and m_P (a_P +
a_g) + c v_P + k u_P - f = 0 for the platform, all relative to the ground; f is the friction force
on the platform. The block sticks while friction holds f = -m_L (a_P + a_g), and then both are one
oscillator. Firm ground is a platform with a_P = 0. Stick and slip follow each other event by event.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from solver.excitation.sampled import SampledMotion
from solver.reference.phases import (
    Acceleration,
    Recorder,
    State,
    event,
    first_beyond,
    output_times,
    solve,
    still,
)
from solver.scene import FrictionSpec, Platform
from solver.types import Array

BEYOND = 1 + 1e-11
"""Sticking ends where friction is exceeded by more than round-off, so that sliding does begin."""

APART = 1e-9
"""Samples that are this near to an output time are taken to come with it, s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Resistance:
    """Friction of a block that stays flat, per unit of its mass: an acceleration, m/s^2.

    tau = c + mu p, mu = mu_d + (mu_s - mu_d) exp(-DC v). With DC = 0 a block that sticks is held by
    mu_s and one that slides has mu_d, also while its velocity passes through zero.
    """

    law: FrictionSpec
    cohesion: float = 0.0
    """c times the area of the base over the mass, m/s^2."""

    @property
    def none(self) -> bool:
        """True without any friction."""
        return self.law.static == 0 and self.cohesion == 0

    def holds(self, normal: float, slipped: bool) -> float:
        """Largest force on a block that sticks, m/s^2; `slipped`: it has slid before."""
        return self._cohesion(slipped) + self.law.static * normal

    def slides(self, normal: float, speed: float) -> float:
        """Force on a block that slides at a speed |v|, m/s, by its normal force, m/s^2."""
        law = self.law
        jump = law.static - law.dynamic if law.decay > 0 else 0.0
        mu = law.dynamic + jump * math.exp(-law.decay * speed)
        return self._cohesion(slipped=True) + mu * normal

    def direction(self, rate: float, needed: float, normal: float, slipped: bool) -> float:
        """Direction in which a block slides from here on, +1 or -1; 0 if it sticks.

        One that has just come to a stop goes on at once where friction cannot hold it.

        Args:
            rate: Slip rate, m/s.
            needed: Force that holds it, m/s^2.
            normal: Normal force, m/s^2.
            slipped: True if it has slid before.
        """
        if rate or self.none:
            return math.copysign(1, rate)
        limit = self.slides(normal, 0.0) if slipped else self.holds(normal, slipped)
        # The block stays behind what it stands on.
        return 0.0 if abs(needed) <= limit else -math.copysign(1, needed)

    def _cohesion(self, slipped: bool) -> float:
        return 0.0 if slipped and self.law.cohesion_lost else self.cohesion


def coulomb(friction: float) -> Resistance:
    """Coulomb's law with one coefficient mu."""
    return Resistance(law=FrictionSpec(static=friction))


@dataclass(frozen=True, slots=True, kw_only=True)
class SlidingReference:
    """History of a sliding block and of what it stands on."""

    time: Array
    """s."""
    slip: Array
    """Displacement of the block relative to the ground or platform, m, positive towards +x."""
    slip_velocity: Array
    """m/s; exactly 0 while the block sticks."""
    drift: Array
    """Displacement u_P of the platform relative to the ground, m; 0 on firm ground."""
    drift_velocity: Array
    """v_P, m/s."""
    drift_acceleration: Array
    """a_P, m/s^2."""
    friction: Array
    """Force on the block over its mass, m/s^2."""


def sliding(
    *,
    acceleration: Acceleration | SampledMotion,
    friction: float | Resistance,
    gravity: float,
    end: float,
    step: float,
    platform: Platform | None = None,
    mass: float = 1.0,
    along: float = 0.0,
    velocity: float = 0.0,
    drift: float = 0.0,
    vertical: Acceleration = still,
) -> SlidingReference:
    """Sliding from rest or from an initial velocity, without rocking.

    With Coulomb's law on firm ground the block sticks while |a_g| <= mu g; else u'' = -a_g - mu g
    sgn u', up to u' = 0. Under samples and friction that does not depend on the speed the answer is
    known in closed form between the events.

    Args:
        acceleration: a_g of the ground, m/s^2, at a time in s, or its samples.
        friction: mu, or a law.
        gravity: g across the ground, m/s^2.
        end: s.
        step: Between output times, s; without samples also the largest step of the integrator.
        platform: Mass, stiffness and damping of the empty platform; None: firm ground.
        mass: Of the block, m_L, kg; it matters on a platform alone.
        along: Gravity along the ground, m/s^2: an incline.
        velocity: Of the block at the start, relative to the ground, m/s.
        drift: Of the platform at the start, m.
        vertical: Acceleration of the ground upwards, m/s^2, > -g.
    """
    law = friction if isinstance(friction, Resistance) else coulomb(friction)
    samples = acceleration if isinstance(acceleration, SampledMotion) else None
    at = acceleration.acceleration if isinstance(acceleration, SampledMotion) else acceleration
    block = _Slider(
        platform=platform,
        mass=mass,
        law=law,
        ground=lambda time: at(time) - along,
        normal=lambda time: gravity + vertical(time),
    )
    state, times = np.array([0.0, velocity, drift, 0.0]), output_times(end, step)
    if samples is not None and vertical is still and not law.law.decay:
        states = _Linear(block, gravity).states(samples, times, along, state)
    else:
        states = block.integrated(times, end, step, state)
    return block.history(times, states)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Slider:
    """The block and what it stands on; states are slip, its rate, drift, its rate."""

    platform: Platform | None
    mass: float
    law: Resistance
    ground: Acceleration
    """a_g, an incline counted in, m/s^2."""
    normal: Acceleration
    """Gravity and the ground's acceleration across it, m/s^2."""

    def needed(self, time: float, state: State) -> float:
        """Force that holds the block, over its mass, m/s^2: a_P + a_g of both together."""
        if self.platform is None:
            return self.ground(time)
        m, k, c = self.platform
        return -(c * state[3] + k * state[2]) / (m + self.mass)

    def under(self, time: float, state: State, force: float) -> float:
        """Acceleration a_P of the platform under a force on the block, given over its mass."""
        if self.platform is None:
            return 0.0
        m, k, c = self.platform
        return -self.ground(time) - (c * state[3] + k * state[2] + self.mass * force) / m

    def force(self, time: float, state: State) -> float:
        """Force on the block over its mass, m/s^2, which sticks where its slip rate is 0."""
        rate = state[1]
        if not rate:
            return self.needed(time, state)
        return -math.copysign(self.law.slides(self.normal(time), abs(rate)), rate)

    def history(self, times: Array, states: Array) -> SlidingReference:
        """The history, with accelerations and forces from the states, (n, 4)."""
        rows = [(float(time), states[row]) for row, time in enumerate(times)]
        forces = [self.force(*row) for row in rows]
        found = zip(rows, forces, strict=True)
        under = [self.under(time, state, force) for (time, state), force in found]
        slip, rate, drift, velocity = states.T
        return SlidingReference(
            time=times,
            slip=slip,
            slip_velocity=rate,
            drift=drift,
            drift_velocity=velocity,
            drift_acceleration=np.array(under),
            friction=np.array(forces),
        )

    def integrated(self, times: Array, end: float, step: float, state: Array) -> Array:
        """States at all times by integration from event to event, (n, 4)."""
        recorder = Recorder(times, size=4)
        time, slipped = 0.0, bool(state[1])
        while time < end:
            needed, normal = self.needed(time, state), self.normal(time)
            way = self.law.direction(state[1], needed, normal, slipped)
            if not way and self.platform is None:
                recorder.rest(time, state[0])
                start = self._uphold(slipped, time, end, step)
                if start is None or start >= end:
                    break
                time, way = start, -math.copysign(1, self.ground(start))
            phase = self._phase(way, slipped, (time, end), step, state)
            recorder.move(time, phase.t[-1], phase.sol)
            time, state = float(phase.t[-1]), phase.y[:, -1].copy()
            if way:
                state[1], slipped = 0.0, True
        return recorder.states

    def _uphold(self, slipped: bool, time: float, end: float, step: float) -> float | None:
        """Time at which the block on firm ground begins to slide, s; None: never."""

        def limit(later: float) -> float:
            return self.law.holds(self.normal(later), slipped)

        return first_beyond(self.ground, limit, time, end, step)

    def _phase(
        self, way: float, slipped: bool, span: tuple[float, float], step: float, state: Array
    ) -> Any:
        """Stick until friction gives way, or slide until the slip rate vanishes."""

        def excess(time: float, y: Array) -> float:
            return abs(self.needed(time, y)) - BEYOND * self.law.holds(self.normal(time), slipped)

        def sliding(time: float, y: Array) -> tuple[float, float, float, float]:
            force = -way * self.law.slides(self.normal(time), abs(y[1]))
            under = self.under(time, y, force)
            return y[1], force - self.ground(time) - under, y[3], under

        def sticking(time: float, y: Array) -> tuple[float, float, float, float]:
            return 0.0, 0.0, y[3], self.needed(time, y) - self.ground(time)

        stop = event(lambda time, y: way * y[1], falling=True, terminal=True)
        give = event(excess, falling=False, terminal=True)
        events = [] if self.law.none else [stop if way else give]
        return solve(sliding if way else sticking, span, state, step=step, events=events)


class _Linear:
    """The block under samples: while it sticks, or slides one way, z' = A z is linear.

    z holds slip, its rate, drift, its rate, a_g (an incline counted in), its slope, and 1. Between
    samples the slope is constant, so that z(t + h) = exp(A h) z(t) is exact.
    """

    def __init__(self, block: _Slider, normal: float):
        """Set up A of sticking (0) and of sliding forwards (1) and backwards (-1)."""
        self._block, self._law, self._normal = block, block.law, normal
        self._matrices = {way: self._matrix(way) for way in (0.0, 1.0, -1.0)}
        self._needed = np.array([0.0, 0, 0, 0, 1, 0, 0])
        if block.platform is not None:
            m, k, c = block.platform
            self._needed = np.array([0.0, 0, k, c, 0, 0, 0]) / -(m + block.mass)
        self._propagators: dict[tuple[float, float], Array] = {}

    def _matrix(self, way: float) -> Array:
        """A: slip'' = force - a_g - a_P where the block slides."""
        block, friction = self._block, -way * self._law.slides(self._normal, 0.0)
        a = np.zeros((7, 7))
        a[0, 1], a[2, 3], a[4, 5] = 1.0, 1.0, 1.0
        if block.platform is not None:
            m, k, c = block.platform
            moved = m if way else m + block.mass
            a[3] = 0, 0, -k / moved, -c / moved, -1, 0, -block.mass * friction / m
        if way:
            a[1] = -a[3]
            a[1, 4] -= 1.0
            a[1, 6] += friction
        else:
            a[0, 1] = 0.0
        return a

    def states(self, samples: SampledMotion, times: Array, along: float, state: Array) -> Array:
        """States at all times, (n, 4), from that at the start."""
        grid = _grid(times, samples)
        first, last = _ends(grid, samples)
        lengths = np.round(np.diff(grid), 13)  # with the round-off off, few propagators are needed
        z = np.array([*state, first[0] - along, 0.0, 1.0])
        slipped, found = bool(state[1]), [state]
        way = self._direction(z, slipped)
        rows = np.stack([first - along, (last - first) / lengths, lengths], axis=1)
        stretches: Any = rows.tolist()
        for ground, slope, left in stretches:
            z[4], z[5], idle = ground, slope, False
            while left > 0:
                z, passed, happens = self._until_event(z, way, slipped, left, idle)
                left -= passed
                if happens and way:
                    z[1], slipped = 0.0, True
                    # Sliding that would end where it begins is none: to the end of this stretch
                    # the block sticks, and what that leaves beyond the limit is then let go.
                    idle = passed == 0
                    way = 0.0 if idle else self._direction(z, slipped)
                elif happens:
                    way = -math.copysign(1, self._needed @ z)
                elif idle:
                    way = self._direction(z, slipped)
                slipped = slipped or bool(way)
            found.append(z[:4].copy())
        return np.array(found)[np.isin(grid, times)]

    def _direction(self, z: Array, slipped: bool) -> float:
        """Direction in which the block slides from here on, +1 or -1; 0 if it sticks."""
        needed = float(self._needed @ z)
        return self._law.direction(float(z[1]), needed, self._normal, slipped)

    def _until_event(
        self, z: Array, way: float, slipped: bool, length: float, idle: bool
    ) -> tuple[Array, float, bool]:
        """The next state, the time that it takes, and True if sticking or sliding ends there."""
        from scipy.linalg import expm

        matrix, key = self._matrices[way], (way, length)
        if key not in self._propagators:
            self._propagators[key] = expm(length * matrix)
        end = self._propagators[key] @ z
        if idle or self._law.none:
            return end, length, False
        cross = partial(_crossing, matrix, z, end, length)
        if way:
            times = [cross(np.array([0.0, -way, 0, 0, 0, 0, 0]), 0.0)]
        else:
            limit = BEYOND * self._law.holds(self._normal, slipped)
            times = [cross(self._needed, limit), cross(-self._needed, limit)]
        known = [time for time in times if time is not None]
        if not known:
            return end, length, False
        return expm(min(known) * matrix) @ z, min(known), True


def _crossing(
    matrix: Array, z: Array, end: Array, length: float, row: Array, bound: float
) -> float | None:
    """First time at which row z exceeds a bound, in a stretch from z to `end`; None: never."""
    from scipy.linalg import expm
    from scipy.optimize import brentq

    rate = row @ matrix
    first, last = rate @ z, rate @ end
    begins, ends = row @ z - bound, row @ end - bound
    if begins > 0:
        return 0.0
    if ends <= 0 and not first > 0 > last:  # nearly always
        return None

    def root(form: Array, value: float, low: float, high: float) -> float:
        def excess(time: float) -> float:
            return float(form @ (expm(time * matrix) @ z)) - value

        return float(brentq(excess, low, high, xtol=1e-16, rtol=1e-15))

    turn = root(rate, 0.0, 0.0, length) if first * last < 0 else 0.0
    if first > 0 and turn and row @ expm(turn * matrix) @ z > bound:
        return root(row, bound, 0.0, turn)
    if ends <= 0:
        return None
    return root(row, bound, turn, length) if begins < 0 or turn else 0.0


def _grid(times: Array, samples: SampledMotion) -> Array:
    """Output times and samples together."""
    inner = samples.time[(samples.time > 0) & (samples.time < times[-1])]
    after = np.searchsorted(times, inner)
    near = np.minimum(np.abs(times[after] - inner), np.abs(times[after - 1] - inner))
    return np.unique(np.concatenate([times, inner[near > APART]]))


def _ends(grid: Array, samples: SampledMotion) -> tuple[Array, Array]:
    """Accelerations at both ends of each stretch; the motion may begin and stop with a jump."""
    values = np.interp(grid, samples.time, samples.value)
    middle = (grid[1:] + grid[:-1]) / 2
    inside = (middle > samples.time[0]) & (middle < samples.stop)
    return np.where(inside, values[:-1], 0.0), np.where(inside, values[1:], 0.0)
