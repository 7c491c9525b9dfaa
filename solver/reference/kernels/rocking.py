"""Peaks of Housner's rocking block under samples of the ground's acceleration.

The equation is that of `solver.reference.housner`. Between two samples the ground's acceleration is
linear and so the motion smooth; steps end at the samples, at impacts and at uplifts.
"""

from __future__ import annotations

import math

from solver.law.compiled import compiled
from solver.types import Array

HALVINGS = 48
"""Bisections that find an impact in a step: to round-off of its length."""


@compiled
def _rate(block: tuple[float, float, float], side: float, ground: float, angle: float) -> float:
    """Angular acceleration of a block on one corner; `block`: alpha, g, 3/(4 R)."""
    lean = side * block[0] - angle
    return -block[2] * (block[1] * math.sin(lean) + ground * math.cos(lean))


@compiled
def _moved(
    block: tuple[float, float, float],
    side: float,
    ground: float,
    slope: float,
    angle: float,
    spin: float,
    dt: float,
) -> tuple[float, float]:
    """Angle and angular velocity after dt, by the classical method of Runge and Kutta."""
    half, middle, last = dt / 2, ground + slope * dt / 2, ground + slope * dt
    w1 = _rate(block, side, ground, angle)
    v2 = spin + half * w1
    w2 = _rate(block, side, middle, angle + half * spin)
    v3 = spin + half * w2
    w3 = _rate(block, side, middle, angle + half * v2)
    v4 = spin + dt * w3
    w4 = _rate(block, side, last, angle + dt * v3)
    turned = angle + dt / 6 * (spin + 2 * v2 + 2 * v3 + v4)
    return turned, spin + dt / 6 * (w1 + 2 * w2 + 2 * w3 + w4)


@compiled
def _impact(
    block: tuple[float, float, float],
    side: float,
    ground: float,
    slope: float,
    angle: float,
    spin: float,
    dt: float,
) -> float:
    """When a swing that ends within dt does so."""
    low, high = 0.0, dt
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        there, _spin = _moved(block, side, ground, slope, angle, spin, middle)
        if side * there > 0:
            low = middle
        else:
            high = middle
    return high


@compiled
def _uplift(ground: float, slope: float, limit: float, dt: float) -> float:
    """When the ground's acceleration exceeds a limit within dt; -1: it does not."""
    if abs(ground) > limit:
        return 0.0
    last = ground + slope * dt
    if abs(last) <= limit:
        return -1.0
    return min(dt, (math.copysign(limit, last) - ground) / slope)


@compiled
def rocking_peaks(
    ground: Array,
    slopes: Array,
    lengths: Array,
    longest: float,
    block: tuple[float, float, float],
    restitution: float,
    resting: float,
    lost: float,
) -> tuple[float, int, float]:
    """Largest |theta| (rad), number of impacts, and when the block overturned (s, nan: never).

    Args:
        ground: a_g at the start of each stretch, m/s^2.
        slopes: Of a_g, m/s^3.
        lengths: Of the stretches, s.
        longest: Longest step, s.
        block: alpha (rad), g (m/s^2), 3/(4 R) (1/m).
        restitution: e.
        resting: Angular velocity after an impact below which the block rests, 1/s.
        lost: Angle beyond which the block does not come back, rad.
    """
    limit = block[1] * math.tan(block[0])
    angle, spin, side, time, peak, impacts = 0.0, 0.0, 0.0, 0.0, 0.0, 0
    for i in range(ground.size):
        count = math.ceil(lengths[i] / longest)
        step = lengths[i] / count
        for part in range(count):
            done, left = part * step, step
            while left > 0:
                push = ground[i] + slopes[i] * done
                if side == 0:
                    wait = _uplift(push, slopes[i], limit, left)
                    if wait < 0:
                        break
                    done, left = done + wait, left - wait
                    push = ground[i] + slopes[i] * done
                    side = -math.copysign(1.0, push)
                    if left <= 0:
                        break
                there, speed = _moved(block, side, push, slopes[i], angle, spin, left)
                passed = left
                if side * there <= 0:
                    if angle == 0 and side * spin <= 0:  # no more than an intention to uplift
                        side, spin = 0.0, 0.0
                        break
                    passed = _impact(block, side, push, slopes[i], angle, spin, left)
                    there, speed = _moved(block, side, push, slopes[i], angle, spin, passed)
                if spin * speed < 0:
                    turn = passed * spin / (spin - speed)
                    peak = max(peak, abs(angle + spin * turn / 2))
                ends, before = side * there <= 0, abs(angle)
                angle, spin = there, speed
                peak = max(peak, abs(angle))
                if ends:
                    impacts += 1
                    angle, spin = 0.0, restitution * spin
                    side = math.copysign(1.0, spin)
                    if abs(spin) <= resting:
                        side, spin = 0.0, 0.0
                if abs(angle) >= lost:
                    part_of_it = (lost - before) / (abs(angle) - before)
                    return lost, impacts, time + done + part_of_it * passed
                done, left = done + passed, left - passed
        time += lengths[i]
    return peak, impacts, math.nan
