"""Swings of a block: their ends and peaks, by its angles; where a block does not come back.

A swing is a stay of the rocking angle theta on one side of zero. It begins where |theta| exceeds
`SMALLEST_SWING` times the slenderness alpha = atan(B/H) and ends with an impact where theta crosses
zero (found by the parabola through the last rows before it), or where it falls below a tenth
of that and comes back on the same side (a squat block that bounces). Smaller movements, those
of an elastic block at rest among them, are not rocking and are not counted.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from solver.types import Array

#: A swing has to exceed this part of the slenderness alpha.
SMALLEST_SWING = 1e-3


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
    """True if the peak is a turning point, not the last row of the history."""


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


def begins(swing: Swing, angle: Array, slenderness: float, after: int = 0) -> int:
    """The row, not before another one, from which on the angle grows to that of the swing."""
    row, side = swing.first, 1.0 if angle[swing.first] > 0 else -1.0
    while row > after and side * angle[row - 1] > 0.1 * SMALLEST_SWING * slenderness:
        row -= 1
    return row


def end_of(swing: Swing, time: Array, angle: Array) -> tuple[int, float]:
    """The last row before the impact that ends a swing, and its time, s.

    There the angle crosses zero, or else stops falling.
    """
    i = swing.last
    while i + 1 < len(angle) and angle[i] * angle[i + 1] > 0:
        if abs(angle[i + 1]) >= abs(angle[i]):
            return i, float(time[i])
        i += 1
    if i + 1 == len(angle):
        return i, float(time[i])
    return i, float(time[i]) + _crossing(time, angle, i)


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


def no_return(slenderness: Any) -> Any:
    """The angle beyond which a block does not come back, rad: 2 alpha, at most 89 degrees.

    There it has no more energy than upright. Never less than its point of balance alpha.
    """
    return np.maximum(slenderness, np.minimum(2 * slenderness, np.radians(89.0)))
