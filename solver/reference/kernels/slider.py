"""Peaks of a platform on a spring: with masses fixed to it, and with a block that sticks or slides.

The phases are those of `solver.reference.sliding`, which keeps the history as well.
"""

from __future__ import annotations

import math

import numpy as np

from solver.law.compiled import compiled
from solver.reference.kernels.oscillator import (
    Form,
    Four,
    Phase,
    at,
    larger,
    moved,
    parts,
    propagator,
    rising,
    root,
    turn,
)
from solver.types import Array

BEYOND = 1 + 1e-11
"""Sticking ends where friction is exceeded by more than round-off, so that sliding does begin."""


@compiled
def fixed(
    ground: Array, slopes: Array, lengths: Array, m: float, k: float, c: float, masses: Array
) -> Array:
    """Peak drifts with masses fixed to the platform."""
    found = np.full(masses.size, np.nan)
    for j in range(masses.size):
        total = m + masses[j]
        if total <= 0:
            continue
        w2, d = k / total, c / total / 2
        u, v, peak, known, count = 0.0, 0.0, 0.0, -1.0, 1
        matrix = (1.0, 0.0, 0.0, 1.0)
        for i in range(ground.size):
            if lengths[i] != known:
                known = lengths[i]
                count = parts(w2, known)
                matrix = propagator(w2, d, known / count)
            tau, slope = known / count, -slopes[i]
            for part in range(count):
                load = -ground[i] + slope * tau * part
                x, y = moved(w2, d, u, v, load, slope, tau, matrix)
                if v * y < 0:
                    peak = larger((w2, d, load, slope), u, v, tau, x, y, 1.0, 0.0, peak)
                peak = max(peak, abs(x))
                u, v = x, y
        found[j] = peak
    return found


@compiled
def _gives(
    phase: Phase,
    u: float,
    v: float,
    tau: float,
    x: float,
    y: float,
    p: float,
    q: float,
    limit: float,
) -> float:
    """When |p u + q v| exceeds a limit in a stretch that leads to x, y; -1: never."""
    form = rising(phase, p, q)
    first = form[0] * u + form[1] * v + form[2]
    last = form[0] * x + form[1] * y + form[2] + form[3] * tau
    until, force = tau, p * x + q * y
    if first * last < 0:
        extreme = root(phase, u, v, form, 0.0, tau)
        there = at(phase, u, v, (p, q, 0.0, 0.0, 0.0), extreme)
        if abs(there) > limit:
            until, force = extreme, there
    if abs(force) <= limit:
        return -1.0
    sign = math.copysign(1.0, force)
    return root(phase, u, v, (sign * p, sign * q, -limit, 0.0, 0.0), 0.0, until)


@compiled
def _stops(
    phase: Phase, u: float, v: float, w: float, rate: Form, faster: Form, way: float, tau: float
) -> float:
    """When sliding ends in a stretch; -1: never.

    `rate` is the form of the slip rate, that begins with w, and `faster` that of its rate.
    """
    extreme, before = turn(phase, u, v, faster, tau), 0.0
    if extreme < tau:
        if way * at(phase, u, v, rate, extreme) <= 0:
            return root(phase, u, v, rate, 0.0, extreme) if w != 0 else 0.0
        before = extreme
    if way * at(phase, u, v, rate, tau) <= 0:
        return root(phase, u, v, rate, before, tau) if before > 0 or w != 0 else 0.0
    return -1.0


@compiled
def _way(needed: float, w: float, limit: float) -> float:
    """Direction in which the block slides from here on, +1 or -1; 0 if it sticks."""
    if w != 0 or limit == 0:
        return math.copysign(1.0, w)
    # The block stays behind the platform.
    return 0.0 if abs(needed) <= limit else -math.copysign(1.0, needed)


@compiled
def _stuck(
    phase: Phase, u: float, v: float, tau: float, matrix: Four, p: float, q: float, limit: float
) -> tuple[bool, float, float, float]:
    """Stick to the end of a stretch, or until friction gives way.

    Returns whether it does, the time that passes, drift and velocity; `matrix` is the propagator of
    the stretch.
    """
    w2, d, load, slope = phase
    x, y = moved(w2, d, u, v, load, slope, tau, matrix)
    give = _gives(phase, u, v, tau, x, y, p, q, limit)
    if give < 0:
        return False, tau, x, y
    x, y = moved(w2, d, u, v, load, slope, give, propagator(w2, d, give))
    return True, give, x, y


@compiled
def _slid(
    phase: Phase, u: float, v: float, w: float, tau: float, matrix: Four, ground: Form, way: float
) -> tuple[bool, float, float, float, float, float]:
    """Slide to the end of a stretch, or until the slip rate w vanishes.

    Returns whether it does, the time that passes, drift, velocity, slip and slip rate. `ground`
    holds the friction force (over the mass of the block), -a_g, k/m, c/m, m_L/m.
    """
    w2, d, load, slope = phase
    force, push, k, c, ratio = ground
    rate = (0.0, -1.0, w + v, force + push, slope / 2)
    faster = (k, c, force + ratio * force, 0.0, 0.0)
    stop = _stops(phase, u, v, w, rate, faster, way, tau) if force != 0 else -1.0
    passed, used = tau, matrix
    if stop >= 0:
        passed, used = stop, propagator(w2, d, stop)
    x, y = moved(w2, d, u, v, load, slope, passed, used)
    # Friction alone accelerates the block; what the ground and the platform move is taken off.
    gone = (force / 2 + push / 2 + slope * passed / 6) * passed * passed
    slip = (w + v) * passed + gone - (x - u)
    after = 0.0 if stop >= 0 else w + (force + push + slope * passed / 2) * passed - (y - v)
    return stop >= 0, passed, x, y, slip, after


@compiled
def slider(
    ground: Array,
    slopes: Array,
    lengths: Array,
    platform: tuple[float, float, float],
    mass: float,
    limits: tuple[float, float, float],
) -> tuple[float, float, float]:
    """Peak drift (m), base shear (N) and slip (m) of a platform that carries a block.

    Args:
        ground: a_g at the start of each stretch, m/s^2.
        slopes: Of a_g, m/s^3.
        lengths: Of the stretches, s.
        platform: Mass, stiffness, damping.
        mass: Of the block, kg.
        limits: What holds the block at first, what holds it once it has slipped, and what friction
            is while it slides, over its mass, m/s^2.
    """
    (m, k, c), (holds, again, slides) = platform, limits
    both = m + mass
    w2_both, d_both, w2, d = k / both, c / both / 2, k / m, c / m / 2
    p, q = -k / both, -c / both  # the force that holds the block is p u + q v
    u, v, w, slip, way = 0.0, 0.0, 0.0, 0.0, 0.0
    drift, shear, slipped, known, count = 0.0, 0.0, 0.0, -1.0, 1
    stick = free = (1.0, 0.0, 0.0, 1.0)
    limit, starts = BEYOND * holds, holds
    for i in range(ground.size):
        if lengths[i] != known:
            known = lengths[i]
            count = parts(w2, known)
            stick = propagator(w2_both, d_both, known / count)
            free = propagator(w2, d, known / count)
        whole, slope = known / count, -slopes[i]
        for part in range(count):
            left, done, idle = whole, 0.0, False
            while left > 0:
                push = -ground[i] + slope * (whole * part + done)
                if way == 0:
                    phase = (w2_both, d_both, push, slope)
                    matrix = stick if left == whole else propagator(w2_both, d_both, left)
                    bound = math.inf if idle else limit
                    gave, passed, x, y = _stuck(phase, u, v, left, matrix, p, q, bound)
                    after = 0.0
                    if gave:
                        way = -math.copysign(1.0, p * x + q * y)
                    elif idle:  # what it leaves beyond the limit is let go with the next stretch
                        way = _way(p * x + q * y, 0.0, starts)
                else:
                    force = -way * slides
                    phase = (w2, d, push - mass / m * force, slope)
                    matrix = free if left == whole else propagator(w2, d, left)
                    forces = (force, push, k / m, c / m, mass / m)
                    stops, passed, x, y, gone, after = _slid(
                        phase, u, v, w, left, matrix, forces, way
                    )
                    slip, limit, starts = slip + gone, BEYOND * again, slides
                    slipped = max(slipped, abs(slip))
                    if stops:
                        idle = passed == 0
                        way = 0.0 if idle else _way(p * x + q * y, 0.0, slides)
                drift = larger(phase, u, v, passed, x, y, 1.0, 0.0, drift)
                shear = larger(phase, u, v, passed, x, y, k, c, shear)
                u, v, w = x, y, after
                done, left = done + passed, left - passed
    return drift, shear, slipped
