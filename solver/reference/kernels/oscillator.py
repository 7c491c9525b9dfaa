"""An oscillator under a load linear in time, u'' + 2 d u' + w^2 u = load + slope t, in closed form.

Roots and turning points inside a stretch of time are found to round-off.
"""

from __future__ import annotations

import math

from solver.law.compiled import compiled

PER_PERIOD = 24
"""Stretches in a period, at least: then each holds at most one turn of what is looked at."""

MOST_PARTS = 64
"""Most parts of a stretch; platforms of so short a period follow their load without vibrating."""

ROOT_STEPS = 100
"""Most evaluations towards a root."""

ROUND_OFF = 1e-15
"""Width of the interval in which a root is known, over the stretch."""


Four = tuple[float, float, float, float]
"""A matrix of two rows, one after the other."""

Phase = tuple[float, float, float, float]
"""w^2 and d of u'' + 2 d u' + w^2 u = load + slope t, load and slope."""

Form = tuple[float, float, float, float, float]
"""A to E of A u + B v + C + D t + E t^2."""


@compiled
def propagator(w2: float, d: float, tau: float) -> Four:
    """Matrix of the free motion of u'' + 2 d u' + w2 u = 0 over a time, row by row."""
    root, fade = w2 - d * d, math.exp(-d * tau)
    if root > 0:
        turn = math.sqrt(root)
        c, s = math.cos(turn * tau), math.sin(turn * tau) / turn
    elif root < 0:
        turn = math.sqrt(-root)
        # The slower of two decays; products of exp and cosh would overflow.
        slow, fast = math.exp((turn - d) * tau), math.exp(-(turn + d) * tau)
        fade, c, s = 1.0, (slow + fast) / 2, (slow - fast) / (2 * turn)
    else:
        c, s = 1.0, tau
    return fade * (c + d * s), fade * s, -fade * w2 * s, fade * (c - d * s)


@compiled
def moved(
    w2: float, d: float, u: float, v: float, load: float, slope: float, tau: float, p: Four
) -> tuple[float, float]:
    """Drift and velocity after a time under a load linear in it, by the propagator of the time."""
    steady = slope / w2
    level = (load - 2 * d * steady) / w2
    x, y = u - level, v - steady
    return level + steady * tau + p[0] * x + p[1] * y, steady + p[2] * x + p[3] * y


@compiled
def at(phase: Phase, u: float, v: float, form: Form, t: float) -> float:
    """A form A u + B v + C + D t + E t^2 at a time after the start of a stretch."""
    w2, d, load, slope = phase
    x, y = u, v
    if t > 0:
        x, y = moved(w2, d, u, v, load, slope, t, propagator(w2, d, t))
    return form[0] * x + form[1] * y + form[2] + t * (form[3] + t * form[4])


@compiled
def root(phase: Phase, u: float, v: float, form: Form, low: float, high: float) -> float:
    """When a form is zero between two times, to round-off, by the rule of Illinois."""
    at_low, at_high = at(phase, u, v, form, low), at(phase, u, v, form, high)
    if at_low * at_high > 0:  # by round-off: one of the ends is the zero
        return low if abs(at_low) < abs(at_high) else high
    least, side = ROUND_OFF * (high - low), 0
    for _ in range(ROOT_STEPS):
        if high - low <= least or at_high == at_low:
            break
        t = high - at_high * (high - low) / (at_high - at_low)
        if not low < t < high:
            t = (low + high) / 2
        now = at(phase, u, v, form, t)
        if now == 0:
            return t
        if now * at_high > 0:
            high, at_high = t, now
            at_low, side = at_low / 2 if side == 1 else at_low, 1
        else:
            low, at_low = t, now
            at_high, side = at_high / 2 if side == -1 else at_high, -1
    return high


@compiled
def rising(phase: Phase, k: float, c: float) -> Form:
    """The form of the rate of k u + c v: k v + c a."""
    w2, d, load, slope = phase
    return -c * w2, k - 2 * d * c, c * load, c * slope, 0.0


@compiled
def turn(phase: Phase, u: float, v: float, form: Form, tau: float) -> float:
    """When a form changes its sign inside a stretch; its end where it does not."""
    if at(phase, u, v, form, 0.0) * at(phase, u, v, form, tau) < 0:
        return root(phase, u, v, form, 0.0, tau)
    return tau


@compiled
def larger(
    phase: Phase,
    u: float,
    v: float,
    tau: float,
    x: float,
    y: float,
    k: float,
    c: float,
    peak: float,
) -> float:
    """The larger of a peak and of |k u + c v| over a stretch that leads to drift x, velocity y."""
    form = rising(phase, k, c)
    first = form[0] * u + form[1] * v + form[2]
    last = form[0] * x + form[1] * y + form[2] + form[3] * tau
    found = max(abs(k * u + c * v), abs(k * x + c * y))
    if first * last < 0 and found + tau * max(abs(first), abs(last)) > peak:
        turn = root(phase, u, v, form, 0.0, tau)
        found = max(found, abs(at(phase, u, v, (k, c, 0.0, 0.0, 0.0), turn)))
    return max(peak, found)


@compiled
def parts(w2: float, length: float) -> int:
    """Number of parts in which a stretch is taken."""
    wanted = PER_PERIOD * length * math.sqrt(w2) / (2 * math.pi)
    return max(1, min(MOST_PARTS, math.ceil(wanted)))
