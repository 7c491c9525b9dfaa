"""Peaks of a platform under samples of the ground's acceleration: a block slides, or is fixed.

The equations and the closed forms of each phase are those of `solver.reference.sliding`,
compiled and without a history: a suite of motions takes milliseconds a motion. Peaks are those of
the continuous motion: turning points between samples are found as roots, too.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from solver.excitation.sampled import SampledMotion, even_step
from solver.reference.kernels.slider import fixed, slider
from solver.reference.sliding import Resistance
from solver.scene import Platform
from solver.types import Array


class Peaks(NamedTuple):
    """Largest values of a run."""

    drift: float
    """|u| of the platform relative to the ground, m."""
    shear: float
    """|k u + c v|, the base shear, N."""
    slip: float
    """Slip of the block on the platform, m; without friction only at the ends of the stretches."""


class Stretches(NamedTuple):
    """Stretches of time over which the ground's acceleration is linear, (n,) each."""

    ground: Array
    """a_g at the start, m/s^2."""
    slope: Array
    """m/s^3."""
    length: Array
    """s."""

    @classmethod
    def of(cls, motion: SampledMotion, scale: float = 1.0) -> Stretches:
        """The stretches of a motion, its acceleration times a factor."""
        value, length = scale * motion.value, np.diff(motion.time)
        step = even_step(motion.time)
        if step is not None:  # without their round-off, propagators are computed once
            length = np.full(length.size, step)
        return cls(value[:-1].copy(), np.diff(value) / length, length)


def slider_peaks(
    motion: Stretches, platform: Platform, mass: float, friction: Resistance, gravity: float
) -> Peaks:
    """Peaks of a platform that carries a block of this mass (kg), which sticks or slides.

    From rest to the end of the motion; the friction force must not depend on the speed.
    """
    if friction.law.decay:
        raise ValueError("a friction force that depends on the speed has no closed form here")
    holds = friction.holds(gravity, slipped=False)
    again, slides = friction.holds(gravity, slipped=True), friction.slides(gravity, 0.0)
    m, k, c = platform
    return Peaks(*slider(*motion, (m, k, c), mass, (holds, again, slides)))


def fixed_drifts(motion: Stretches, platform: Platform, masses: Array) -> Array:
    """Peak drifts, m, (n,), of platforms with further masses (kg) fixed to them; k and c stay.

    NaN where the mass is not positive.
    """
    return fixed(*motion, *platform, np.asarray(masses, dtype=float))
