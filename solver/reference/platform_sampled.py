"""A rigid block that slides on a platform under samples of the ground's acceleration: closed forms.

Between two samples the ground's acceleration is linear, and while the block sticks, or slides with
constant friction, the platform is an oscillator under a linear load: the motion is known in closed
form. Only the ends of sticking and sliding are looked for, as roots. The equations are those of
`solver.reference.platform`, which integrates them for any law of friction and any motion.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from solver.excitation.sampled import SampledMotion
from solver.reference.friction import Resistance
from solver.reference.phases import output_times
from solver.reference.platform import BEYOND, Pair, PlatformReference
from solver.scene import Platform
from solver.types import Array

APART = 1e-9
"""Samples that are this near to an output time are taken to come with it, s."""


@dataclass(frozen=True, slots=True)
class LinearOscillator:
    """A damped one, u'' + 2 d u' + w2 u = load, in closed form for loads linear in time."""

    w2: float
    """Stiffness over mass, 1/s^2."""
    d: float
    """Half of the damping over mass, 1/s."""

    def after(
        self, drift: float, velocity: float, load: float, slope: float, tau: float
    ) -> tuple[float, float]:
        """Drift (m) and velocity (m/s) after a time tau (s), from those at its start.

        The load at the start is over the mass, m/s^2, and so is its slope, m/s^3.
        """
        w2, d = self.w2, self.d
        steady = slope / w2
        level = (load - 2 * d * steady) / w2
        u, v = drift - level, velocity - steady
        root, fade = w2 - d * d, math.exp(-d * tau)
        if root > 0:
            turn = math.sqrt(root)
            c, s = math.cos(turn * tau), math.sin(turn * tau) / turn
        elif root < 0:
            turn = math.sqrt(-root)
            c, s = math.cosh(turn * tau), math.sinh(turn * tau) / turn
        else:
            c, s = 1.0, tau
        moved = fade * (u * (c + d * s) + v * s)
        return level + steady * tau + moved, steady + fade * (v * (c - d * s) - w2 * u * s)


class PlatformState(NamedTuple):
    """State of the block and the platform."""

    slip: float
    """m."""
    rate: float
    """Velocity w of the slip, m/s."""
    drift: float
    """u, m."""
    velocity: float
    """Velocity v of the drift, m/s."""


@dataclass(frozen=True, slots=True)
class Segment:
    """A stretch of time over which the ground's acceleration is linear."""

    ground: float
    """a_g at its start, m/s^2."""
    slope: float
    """Slope of a_g, m/s^3."""
    length: float
    """s."""

    def from_(self, tau: float) -> Segment:
        """The rest of the segment after a time tau (s)."""
        return Segment(self.ground + self.slope * tau, self.slope, self.length - tau)


@dataclass(frozen=True, slots=True, kw_only=True)
class SampledPair(Pair):
    """The block and its platform, with a friction force that does not depend on the speed."""

    normal: float
    """Gravity across the platform, m/s^2."""
    both: LinearOscillator
    """Block and platform as one."""
    alone: LinearOscillator
    """The platform below a block that slides."""

    @classmethod
    def of(cls, platform: Platform, mass: float, normal: float, law: Resistance) -> SampledPair:
        """Set up the two oscillators."""
        m, k, c = platform
        together = m + mass
        both = LinearOscillator(k / together, c / together / 2)
        alone = LinearOscillator(k / m, c / m / 2)
        return cls(platform, mass, law, normal=normal, both=both, alone=alone)

    def stick(self, state: PlatformState, segment: Segment, tau: float) -> PlatformState:
        """State after sticking for a time tau (s)."""
        load, slope = -segment.ground, -segment.slope
        u, v = self.both.after(state.drift, state.velocity, load, slope, tau)
        return PlatformState(state.slip, 0.0, u, v)

    def slide(
        self, state: PlatformState, segment: Segment, force: float, tau: float
    ) -> PlatformState:
        """State after sliding for tau under a friction force (over the block's mass)."""
        ground, slope = segment.ground, segment.slope
        load = -ground - self.mass / self.platform.mass * force
        u, v = self.alone.after(state.drift, state.velocity, load, -slope, tau)
        # Friction alone accelerates the block; what the ground and the platform move is taken off.
        gained = (force - ground - slope * tau / 2) * tau
        passed = (force / 2 - ground / 2 - slope * tau / 6) * tau * tau
        rate = state.rate + gained - (v - state.velocity)
        slip = state.slip + (state.rate + state.velocity) * tau + passed - (u - state.drift)
        return PlatformState(slip, rate, u, v)

    def rise(self, state: PlatformState, ground: float) -> float:
        """Rate of the force that holds the block while it sticks, over its mass, m/s^3."""
        m, k, c = self.platform
        pull = -ground - 2 * self.both.d * state.velocity - self.both.w2 * state.drift
        return -(c * pull + k * state.velocity) / (m + self.mass)

    def speeding(self, state: PlatformState, force: float) -> float:
        """Rate of the slip rate while the block slides, w', m/s^2."""
        m, k, c = self.platform
        return force + (c * state.velocity + k * state.drift + self.mass * force) / m

    def gives(
        self, state: PlatformState, segment: Segment, end: PlatformState, slipped: bool
    ) -> float | None:
        """When sticking ends inside a segment, at whose end it would lead to `end`; None: never."""
        limit = BEYOND * self.law.holds(self.normal, slipped)

        def rise(tau: float) -> float:
            now = self.stick(state, segment, tau) if 0 < tau < segment.length else end
            return self.rise(now if tau else state, segment.ground + segment.slope * tau)

        for until in _turns(rise, segment.length):
            last = self.stick(state, segment, until) if until < segment.length else end
            force = self.needed(last.drift, last.velocity)
            if abs(force) > limit:
                sign = math.copysign(1, force)

                def excess(tau: float, sign: float = sign) -> float:
                    now = self.stick(state, segment, tau)
                    return sign * self.needed(now.drift, now.velocity) - limit

                return _root(excess, 0.0, until)
        return None

    def stops(
        self, state: PlatformState, segment: Segment, end: PlatformState, way: float, force: float
    ) -> float | None:
        """When sliding ends inside a segment, at whose end it would lead to `end`; None: never."""

        def speeding(tau: float) -> float:
            now = self.slide(state, segment, force, tau) if 0 < tau < segment.length else end
            return way * self.speeding(now if tau else state, force)

        def rate(tau: float) -> float:
            return way * self.slide(state, segment, force, tau).rate

        before = 0.0
        for until in _turns(speeding, segment.length):
            if (way * end.rate if until == segment.length else rate(until)) <= 0:
                return _root(rate, before, until) if before or state.rate else 0.0
            before = until
        return None


def sampled_sliding_on_platform(
    *,
    platform: Platform,
    mass: float,
    friction: Resistance,
    gravity: float,
    motion: SampledMotion,
    end: float,
    step: float,
    along: float = 0.0,
    velocity: float = 0.0,
    drift: float = 0.0,
) -> PlatformReference:
    """Sliding on a platform that begins at rest.

    Args:
        platform: Mass, stiffness and damping of the empty platform.
        mass: Of the block, m_L, kg.
        friction: A law without decay: its force does not depend on the speed.
        gravity: Across the platform, m/s^2.
        motion: Of the ground.
        end: s.
        step: Between output times, s.
        along: Gravity along the platform, m/s^2: an incline.
        velocity: Of the block at the start, relative to the ground, m/s.
        drift: Of the platform at the start, m.
    """
    if friction.law.decay:
        raise ValueError("a friction force that depends on the speed has no closed form here")
    pair = SampledPair.of(platform, mass, gravity, friction)
    times = output_times(end, step)
    grid = _grid(times, motion)
    first, last = _ends(grid, motion)
    lengths = np.diff(grid)
    rows = np.stack([first - along, (last - first) / lengths, lengths], axis=1)
    segments = [Segment(*row) for row in rows.tolist()]
    states = np.array(list(_states(pair, segments, velocity, drift)))
    ground = motion.accelerations(times) - along
    return pair.history(times, states[np.isin(grid, times)], ground, friction.slides(gravity, 0.0))


def _grid(times: Array, motion: SampledMotion) -> Array:
    """Output times and samples together."""
    samples = motion.time[(motion.time > 0) & (motion.time < times[-1])]
    after = np.searchsorted(times, samples)
    near = np.minimum(np.abs(times[after] - samples), np.abs(times[after - 1] - samples))
    return np.unique(np.concatenate([times, samples[near > APART]]))


def _ends(grid: Array, motion: SampledMotion) -> tuple[Array, Array]:
    """Accelerations at both ends of each stretch; the motion may begin and stop with a jump."""
    values = np.interp(grid, motion.time, motion.value)
    middle = (grid[1:] + grid[:-1]) / 2
    inside = (middle > motion.time[0]) & (middle < motion.stop)
    return np.where(inside, values[:-1], 0.0), np.where(inside, values[1:], 0.0)


def _states(
    pair: SampledPair, segments: Sequence[Segment], velocity: float, drift: float
) -> Iterator[PlatformState]:
    """The states at the start and after each segment."""
    state, slipped = PlatformState(0.0, velocity, drift, 0.0), velocity != 0
    way = pair.way(state, pair.normal, slipped)
    yield state
    for whole in segments:
        segment, idle = whole, False  # idle: sliding that would end where it begins is none
        while segment.length > 0:
            state, segment, way, slipped, idle = _phase(pair, state, segment, way, slipped, idle)
        yield state


def _phase(
    pair: SampledPair, state: PlatformState, segment: Segment, way: float, slipped: bool, idle: bool
) -> tuple[PlatformState, Segment, float, bool, bool]:
    """Go on to the next event, or to the end of the segment."""
    rest = Segment(0.0, 0.0, 0.0)
    if way:
        force = -way * pair.law.slides(pair.normal, 0.0)
        end = pair.slide(state, segment, force, segment.length)
        stop = None if pair.law.none else pair.stops(state, segment, end, way, force)
        if stop is None:
            return end, rest, way, True, False
        moved = pair.slide(state, segment, force, stop)._replace(rate=0.0)
        idle = stop == 0
        way = 0.0 if idle else pair.way(moved, pair.normal, True)
        return moved, segment.from_(stop), way, True, idle
    end = pair.stick(state, segment, segment.length)
    give = None if idle else pair.gives(state, segment, end, slipped)
    if give is None:
        # What an idle stretch leaves beyond the limit is let go with the next segment.
        return end, rest, pair.way(end, pair.normal, slipped) if idle else 0.0, slipped, False
    state = pair.stick(state, segment, give)
    way = -math.copysign(1, pair.needed(state.drift, state.velocity))
    return state, segment.from_(give), way, slipped, False


def _turns(derivative: Callable[[float], float], length: float) -> Iterator[float]:
    """The argument of a function's extreme inside a stretch, if there is one, and its end."""
    first, last = derivative(0.0), derivative(length)
    if first * last < 0:
        yield _root(derivative, 0.0, length)
    yield length


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    """Root of a function that changes its sign between two arguments, to round-off."""
    from scipy.optimize import brentq

    if function(low) * function(high) > 0:  # by round-off: one of the ends is the zero
        return low if abs(function(low)) < abs(function(high)) else high
    return float(brentq(function, low, high, xtol=1e-16, rtol=1e-15))
