"""Swings of a block, and impacts with their restitution, from its history.

A swing is a stay of the rocking angle theta on one side of zero. It begins where |theta| exceeds
`SMALLEST_SWING` times the slenderness alpha = atan(B/H) and ends with an impact where theta crosses
zero (found by the parabola through the last rows before it), or where it falls below a tenth
of that and comes back on the same side (a squat block that bounces). Smaller movements, those
of an elastic block at rest among them, are not rocking and are not counted.

The restitution of an impact is the ratio of the angular velocities after and before it. On level
ground at rest it is the square root of the ratio of the energies that a rigid block has at the
peaks after and before, over its rotary inertia 4/3 m R^2 (Housner 1963):
p^2 (cos(alpha - |theta|) - cos(alpha)); where damping takes lambda theta' in the swings, theta' of
Housner's equation with that term at the impact, which is then no loss of it. A base that moves
does work on the block between two peaks, and an incline from one side to the other; there both
angular velocities are read next to the impact (`solver.results.angular_velocity`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from geometry.block import Block
from solver.results.angular_velocity import SETTLING, WINDOW, rigid_moment
from solver.types import Array

#: A swing has to exceed this part of the slenderness alpha.
SMALLEST_SWING = 1e-3

#: What the angle at an impact may be by the motion next to it, over its largest angle. Under
#: synthetic earthquakes it is 1e-5 for rigid and up to 0.007 for elastic blocks where a swing
#: follows the impact, and 0.04 or more where smaller movements lie between.
LARGEST_OFFSET = 0.02

#: Lean out of the plane of rocking, over the largest angle, with which a block rolls.
LARGEST_ASIDE = 0.01

#: Height to which a block hops, over that to which its centre rises in the swings beside: with
#: more of their energy in it, their peaks say nothing of an impact. Elastic blocks of H/B 3 hop by
#: 0.08 on firm ground and by 0.11 on a plate like themselves, and all their impacts keep the same;
#: of H/B 2 by 0.2, and what the peaks say scatters by 0.1; cubes by 0.5.
LARGEST_HOP = 0.15

#: Largest ratio of angular velocities that may be a restitution, read with an error.
MOST = 1.005

HOPS = "it hops"
ROLLS = "it rolls over its corners"
FASTER = "faster than before: something else gave it energy"
NO_SWING = "no whole swing follows it"
NOT_TOLD = "the motion beside it does not tell"

#: Steps of Runge and Kutta over a swing with drag.
SWING_STEPS = 64


@dataclass(frozen=True, slots=True, kw_only=True)
class Swing:
    """A stay of the angle on one side of zero."""

    first: int
    """Row at which it exceeds the smallest swing."""
    last: int
    """Last row of it."""
    peak_s: float
    """Time of the largest angle, s."""
    peak_rad: float
    """Largest angle, with its sign, rad."""
    turned: bool
    """Whether the peak is a turning point, not the last row of the history."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Impact:
    """The end of a swing."""

    time_s: float
    """Time of the impact, s."""
    restitution: float | None
    """Ratio of angular velocities after and before of the rigid block that has the same peaks; None
    where there is none, or what was read is no restitution."""
    reason: str = ""
    """Why there is none."""
    ratio: float | None = None
    """What was read where it is no restitution."""

    @classmethod
    def of(cls, time_s: float, ratio: float | None, reason: str) -> Impact:
        """An impact (s) with what was read; the reason is that of a ratio that was not found.

        Nobody comes from an impact faster than before: what does has energy from elsewhere.
        """
        if ratio is None or ratio > MOST:
            why = reason if ratio is None else FASTER
            return cls(time_s=time_s, restitution=None, reason=why, ratio=ratio)
        return cls(time_s=time_s, restitution=ratio)


def swings(time: Array, angle: Array, slenderness: float) -> list[Swing]:
    """The swings of a block, in their order, by its rocking angles theta and slenderness, rad."""
    large = SMALLEST_SWING * slenderness
    begins = np.flatnonzero(np.abs(angle) > large)
    ends = {side: np.flatnonzero(side * angle <= 0.1 * large) for side in (1.0, -1.0)}
    found: list[Swing] = []
    after = 0
    while len(begins) and after <= begins[-1]:
        first = int(begins[np.searchsorted(begins, after)])
        over = ends[1.0 if angle[first] > 0 else -1.0]
        place = np.searchsorted(over, first)
        after = int(over[place]) if place < len(over) else len(angle)
        found.append(_swing(time, angle, first, after - 1))
    return found


def _swing(time: Array, angle: Array, first: int, last: int) -> Swing:
    """The swing over these rows, its peak refined by the parabola through three of them."""
    peak = first + int(np.argmax(np.abs(angle[first : last + 1])))
    peak_time, peak_angle = float(time[peak]), float(angle[peak])
    if 0 < peak < len(angle) - 1:
        before, after = time[peak] - time[peak - 1], time[peak + 1] - time[peak]
        slope_before = (angle[peak] - angle[peak - 1]) / before
        slope_after = (angle[peak + 1] - angle[peak]) / after
        curvature = (slope_after - slope_before) / (before + after)
        slope = (slope_before * after + slope_after * before) / (before + after)
        # Next to an impact the largest row may lie on a kink: no parabola there.
        if curvature * angle[peak] < 0 and slope_before * slope_after < 0:
            peak_time -= float(slope / (2 * curvature))
            peak_angle -= float(slope**2 / (4 * curvature))
    turned = peak < len(angle) - 1
    return Swing(first=first, last=last, peak_s=peak_time, peak_rad=peak_angle, turned=turned)


def peaks(time: Array, angle: Array, slenderness: float) -> list[tuple[float, float]]:
    """Time (s) and angle (rad, with its sign) of the turning points of the swings."""
    return [(s.peak_s, s.peak_rad) for s in swings(time, angle, slenderness) if s.turned]


def rocking_energy(angle: float, shape: Block, gravity: float) -> float:
    """Energy of a rigid block at rest at an angle, above the upright one, per rotary inertia, 1/s2.

    p^2 (cos(alpha - |theta|) - cos(alpha)), Housner 1963.
    """
    alpha = shape.slenderness
    return float(shape.frequency(gravity) ** 2 * (np.cos(alpha - abs(angle)) - np.cos(alpha)))


def speed_at_impact(peak: float, shape: Block, gravity: float, drag: float = 0.0) -> float:
    """Speed with which a rigid block that is at rest at a peak comes to its impact, 1/s.

    By theta'' = -p^2 sin(alpha - |theta|) sgn(theta) - drag theta', with the drag, 1/s, of damping
    that is proportional to mass. With a negative drag it is the speed after an impact that leads to
    the peak: the same swing backwards. NaN where a block has no swing from there.
    """
    if drag == 0.0:
        energy = rocking_energy(peak, shape, gravity)
        return math.sqrt(2 * energy) if energy >= 0 else math.nan
    if not (0 < abs(peak) < shape.slenderness and gravity > 0):
        return math.nan
    peak, square = abs(peak), shape.frequency(gravity) ** 2

    def slope(s: float, ratio: float) -> float:
        """Slope of theta' over s, where theta = peak (1 - s^2); the ratio is s/theta'."""
        pull = square * math.sin(shape.slenderness - peak * (1 - s * s))
        return 2 * peak * (pull * ratio - drag * s)

    first = math.sqrt(2 * peak * square * math.sin(shape.slenderness - peak))  # theta'/s at s = 0
    speed, h = 0.0, 1 / SWING_STEPS
    for k in range(SWING_STEPS):
        s = k * h
        a = slope(s, s / speed if k else 1 / first)
        b = slope(s + h / 2, (s + h / 2) / (speed + h / 2 * a))
        c = slope(s + h / 2, (s + h / 2) / (speed + h / 2 * b))
        d = slope(s + h, (s + h) / (speed + h * c))
        speed += h / 6 * (a + 2 * b + 2 * c + d)
        if not speed > 0:  # overdamped by far
            return math.nan
    return speed


def impacts(
    time: Array,
    angle: Array,
    shape: Block,
    gravity: float,
    acceleration: Array | None = None,
    *,
    gives_way: bool = False,
    aside: Array | None = None,
    low: Array | None = None,
    drag: float = 0.0,
) -> list[Impact]:
    """The impacts of a block: the ends of its swings, by its rocking angles theta, rad.

    On a base that moves or is no level ground `acceleration` has the angular acceleration of a
    rigid block at these angles, 1/s2; None: it is level and at rest. A base that gives way is moved
    by impacts, too. In space `aside` is the lean out of the plane of the angles, rad: a block that
    rolls over its corners has no restitution in one plane; `low` is the gap of its lowest corner,
    m: one that hops has none at all. `drag` is lambda of the swings on level
    ground at rest, 1/s.
    """
    found = swings(time, angle, shape.slenderness)
    result = []
    for i, swing in enumerate(found):
        if swing.last == len(angle) - 1:
            continue
        following = found[i + 1] if i + 1 < len(found) else None
        at = _impact_time(time, angle, swing.last)
        kept, why = None, NOT_TOLD
        if aside is not None and _rolls(swing, following, angle, aside):
            why = ROLLS
        elif acceleration is None:
            why = NO_SWING
            kept = _restitution(swing, following, time, angle, shape, gravity, drag)
        else:
            scale = 1 / shape.frequency(gravity) if gravity > 0 else np.inf
            settled = at + SETTLING * scale if gives_way else at
            kept = _ratio_of_velocities(
                swing, following, time, angle, acceleration, at, settled, WINDOW * scale
            )
        impact = Impact.of(at, kept, why)
        if low is not None and _hops(swing, following, time, low, shape):
            impact = Impact(time_s=at, restitution=None, reason=HOPS, ratio=kept)
        result.append(impact)
    return result


def _rolls(before: Swing, after: Swing | None, angle: Array, aside: Array) -> bool:
    """Whether a block leans out of the plane of its angles in the swings beside an impact."""
    rows = slice(before.first, (after or before).last + 1)
    return bool(aside[rows].max() > LARGEST_ASIDE * np.abs(angle[rows]).max())


def _hops(before: Swing, after: Swing | None, time: Array, low: Array, shape: Block) -> bool:
    """Whether a block leaves the ground by much from the peak before an impact to that after it."""
    last = after.peak_s if after else math.inf
    rises = [
        math.cos(shape.slenderness - abs(swing.peak_rad)) - math.cos(shape.slenderness)
        for swing in (before, after or before)
    ]
    hop = np.max(low[(time >= before.peak_s) & (time <= last)], initial=0.0)
    return bool(hop > LARGEST_HOP * shape.half_diagonal * max(rises))


def _impact_time(time: Array, angle: Array, last: int) -> float:
    """Row at which the angle crosses zero after row `last`, or else stops falling."""
    i = last
    while i + 1 < len(angle) and angle[i] * angle[i + 1] > 0:
        if abs(angle[i + 1]) >= abs(angle[i]):
            return float(time[i])
        i += 1
    if i + 1 == len(angle):
        return float(time[i])
    return float(time[i]) + _crossing(time, angle, i)


def _crossing(time: Array, angle: Array, i: int) -> float:
    """Time from row `i`, the last of a swing, to the zero of the angle, s.

    At an impact the angle has a kink, so that what comes after it says nothing of when it was: the
    parabola through the last three rows before it does. Where that has no zero before the next row
    (rows of another swing, a vibration), the straight line between the two rows.
    """
    step, value = float(time[i + 1] - time[i]), abs(float(angle[i]))
    straight = step * value / (value + abs(float(angle[i + 1])))
    before = np.abs(angle[max(i - 2, 0) : i])
    if len(before) < 2 or not before[0] > before[1] > value:
        return straight
    latest = (value - before[1]) / (time[i] - time[i - 1])
    former = (before[1] - before[0]) / (time[i - 1] - time[i - 2])
    bend = (latest - former) / (time[i] - time[i - 2])
    fall = -(latest + bend * (time[i] - time[i - 1]))
    square = fall**2 - 4 * bend * value
    if fall <= 0 or square < 0:
        return straight
    found = float(2 * value / (fall + np.sqrt(square)))
    return found if found <= step else straight


def _restitution(
    before: Swing,
    after: Swing | None,
    time: Array,
    angle: Array,
    shape: Block,
    gravity: float,
    drag: float,
) -> float | None:
    """Ratio of the speeds at the impact that belong to the peaks."""
    if after is not None:
        if not after.turned:
            return None
        peak = after.peak_rad
    else:
        # What follows is smaller than a swing: its largest angle, once it has had time for one.
        if time[-1] - time[before.last] < 2 * (time[before.last] - before.peak_s):
            return None
        peak = float(np.max(np.abs(angle[before.last + 1 :])))
    start = speed_at_impact(before.peak_rad, shape, gravity, drag)
    end = speed_at_impact(peak, shape, gravity, -drag)
    return end / start if start > 0 and math.isfinite(end) else None


def _ratio_of_velocities(
    before: Swing,
    after: Swing | None,
    time: Array,
    angle: Array,
    acceleration: Array,
    at: float,
    settled: float,
    window: float,
) -> float | None:
    """Ratio of the angular velocities after and before an impact at a time (s).

    The acceleration holds from the time on at which the base has settled (s).
    """
    velocities = []
    for swing, first, last in ((before, at - window, at), (after, at, at + window)):
        if swing is None:
            return None
        rows = np.arange(_start(swing, angle), swing.last + 1)
        rows = rows[(time[rows] >= first) & (time[rows] <= last)]
        struck = (time[rows] >= at) & (time[rows] < settled)
        if np.all(struck):
            return None
        rates = np.where(struck, acceleration[rows[~struck][0]], acceleration[rows])
        found = rigid_moment(time[rows], angle[rows], rates, at)
        # A swing that does not begin here follows a smaller one, which is not counted.
        if found is None or abs(found.angle) > LARGEST_OFFSET * np.max(np.abs(angle[rows])):
            return None
        velocities.append(found.velocity)
    return abs(velocities[1] / velocities[0]) if velocities[0] else None


def _start(swing: Swing, angle: Array) -> int:
    """The row from which on the angle is on the side of the swing."""
    row = swing.first
    while row and angle[row - 1] * angle[swing.first] > 0:
        row -= 1
    return row


def overturned(angle: Array, slenderness: float) -> bool:
    """True if a block fell over.

    It ends beyond its point of balance, |theta| > alpha, or has been where it has no more energy
    than upright, |theta| > 2 alpha (at most 89 degrees: a block lies at 90).
    """
    lost = no_return(slenderness)
    return bool(abs(angle[-1]) > slenderness or np.max(np.abs(angle)) > lost)


def no_return(slenderness: Any) -> Any:
    """The angle beyond which a block does not come back, rad: 2 alpha, at most 89 degrees.

    There it has no more energy than upright. Never less than its point of balance alpha.
    """
    return np.maximum(slenderness, np.minimum(2 * slenderness, np.radians(89.0)))
