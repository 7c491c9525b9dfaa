"""Peaks of Housner's block under a sampled motion, without its history: fast enough for ensembles.

The equation is that of `solver.reference.housner`, the method a compiled one with fixed steps.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from geometry.block import Block
from solver.excitation.sampled import SampledMotion
from solver.reference.housner import RESTING_ENERGY, housner_restitution
from solver.reference.kernels.rocking import rocking_peaks
from solver.results.rocking import no_return
from solver.types import Array

STEP = 0.01
"""Longest step times p."""


@dataclass(frozen=True, slots=True)
class RockingPeaks:
    """What is left of a history of rocking."""

    angle: float
    """Largest |theta|, rad; once overturned the angle from which it does not come back."""
    impacts: int
    overturned_at: float | None
    """When it passed that, s, as in `solver.results.rocking.no_return`; None: it did not."""


def sampled_rocking(
    shape: Block,
    motion: SampledMotion,
    *,
    gravity: float,
    end: float,
    restitution: float | None = None,
    scale: float = 1.0,
) -> RockingPeaks:
    """Rocking from rest without sliding up to a time `end`, s.

    Args:
        shape: The block.
        motion: Of the ground.
        gravity: g, m/s^2.
        end: s.
        restitution: e; None: Housner's, 0 for blocks so squat that his would be negative.
        scale: Factor on the motion.
    """
    ratio = max(0.0, housner_restitution(shape)) if restitution is None else restitution
    p = shape.frequency(gravity)
    barrier = p**2 * (1 - math.cos(shape.slenderness))
    ground, slopes, lengths = _stretches(motion, end)
    peak, impacts, fell = rocking_peaks(
        scale * ground,
        scale * slopes,
        lengths,
        STEP / p,
        (shape.slenderness, gravity, 3 / (4 * shape.half_diagonal)),
        ratio,
        math.sqrt(2 * RESTING_ENERGY * barrier),
        float(no_return(shape.slenderness)),
    )
    if math.isnan(fell):
        return RockingPeaks(float(peak), int(impacts), None)
    return RockingPeaks(float(peak), int(impacts), float(fell))


def _stretches(motion: SampledMotion, end: float) -> tuple[Array, Array, Array]:
    """Accelerations at the starts of stretches between samples, their slopes and their lengths.

    Before the first sample and after the last one the ground does not accelerate.
    """
    time, value = motion.time, motion.value
    if time[-1] > end:
        inside = time < end
        time = np.append(time[inside], end)
        value = np.append(value[inside], motion.accelerations(np.array([end])))
    lengths = np.diff(time)
    ground, slopes = value[:-1], np.diff(value) / lengths
    before, after = max(0.0, float(time[0])), end - float(time[-1])
    for at, length in ((0, before), (len(ground) + (before > 0), after)):
        if length > 0:
            ground = np.insert(ground, at, 0.0)
            slopes = np.insert(slopes, at, 0.0)
            lengths = np.insert(lengths, at, length)
    return ground, slopes, lengths
