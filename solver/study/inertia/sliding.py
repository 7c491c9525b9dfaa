"""A block that slides on an oscillator under many motions: peaks of the drift and the base shear.

The block stays flat, so that it has one degree of freedom. With the trapezoidal rule the platform
(mass m, stiffness k, dashpot c) and the block (mass M) on it take a step h, in which the velocity
of the ground changes by j, under an impulse q M of friction:

    (m + h c/2 + h^2 k/4) (v' - v) = -m j - h (c v + k u + h k v/2) - M q,   u' = u + h (v + v')/2
    w' - w = -j + q

relative to the ground. q is that with which the block moves on with the platform, w' = v'; where
friction does not hold that, it is the dynamic friction mu_d g h against the way it slides, less
where it turns round in the step.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.signal import lfilter

from solver.excitation.sampled import SampledMotion
from solver.scene import Platform
from solver.types import Array

STEPS = 200
"""Steps in a period of the platform: peaks are within 0.001 of those of the equations, and within
0.005 where friction falls as sliding begins."""


def jumps(motion: SampledMotion, scale: float, step: float) -> Array:
    """Changes of the ground's velocity in each step (s) up to the end of a motion, m/s."""
    count = int(np.ceil(motion.stop / step * (1 - 1e-9)))
    times: Array = step * np.arange(count + 1, dtype=np.float64)
    return scale * np.diff(motion.velocity(times))


def fixed_drifts(change: Array, step: float, platform: Platform, masses: Array) -> Array:
    """Peak drifts with masses (kg) fixed to the platform, m, (n,); NaN for no positive sum.

    The steps of `peaks` for a block that never slides, as a recursion of the drift alone.

    Args:
        change: Of the ground's velocity in each step, m/s.
        step: h, s.
        platform: The empty structure.
        masses: Fixed to it, kg, (n,).
    """
    m, k, c = platform
    pushed = np.append(change, 0.0) / step
    found = np.full(len(masses), np.nan)
    for number, total in enumerate(m + masses):
        if total > 0:
            square, slope, mean = 1 / step**2, c / (2 * step * total), k / (4 * total)
            recursion = [square + slope + mean, 2 * (mean - square), square - slope + mean]
            found[number] = np.abs(lfilter([0.0, -0.5, -0.5], recursion, pushed)).max()
    return found


def peaks(
    changes: Sequence[Array],
    step: float,
    platform: Platform,
    masses: Array,
    holds: Array,
    slides: Array,
) -> tuple[Array, Array]:
    """Peak drifts (m) and base shears (N) from rest to the end of each motion, (motions, n) each.

    Args:
        changes: Of the ground's velocity in each step, m/s, for each motion.
        step: h, s.
        platform: The empty structure.
        masses: Of the block, M, kg, (n,).
        holds: Acceleration that friction holds without sliding, mu_s g, m/s^2, (n,).
        slides: That of dynamic friction, mu_d g, m/s^2, (n,).
    """
    (m, k, c), h = platform, step
    change = np.full((max(map(len, changes)), len(changes), 1), np.nan)  # no peaks after the end
    for column, jump in enumerate(changes):
        change[: len(jump), column, 0] = jump
    stiff = m + h * c / 2 + h**2 * k / 4
    both, part = stiff / (stiff + masses), masses / stiff
    most, kinetic = h * holds, h * slides
    u, v, w, drift, shear = np.zeros((5, len(changes), masses.size))
    for jump in change:
        free = v - (m * jump + h * (c * v + k * (u + h / 2 * v))) / stiff
        stick = both * (free - w + jump)
        needed, way = np.abs(stick), np.sign(stick)
        slips = needed > np.where(w == v, most, kinetic)
        before = np.maximum(way * (w - v), 0.0)  # it slides the other way at first
        turned = before / (before + (needed + kinetic) / both)
        q = np.where(slips, way * kinetic * (1 - 2 * turned), stick)
        after = free - part * q
        w = np.where(slips, w - jump + q, after)
        u = u + h / 2 * (v + after)
        v = after
        drift = np.fmax(drift, np.abs(u))
        shear = np.fmax(shear, np.abs(k * u + c * v))
    return drift, shear
