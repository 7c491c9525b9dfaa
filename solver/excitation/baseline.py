"""Baselines of accelerograms."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.polynomial import legendre

from solver.types import Array

Baseline = Literal["none", "constant", "linear", "quadratic"]

DEGREES: dict[Baseline, int] = {"constant": 0, "linear": 1, "quadratic": 2}


def corrected(acceleration: Array, baseline: Baseline) -> Array:
    """Samples less the polynomial of time that makes the sum of their squared velocities least.

    After Berg and Housner (1961), who took off a parabola. The velocities are those of ground that
    is at rest at the first sample and whose acceleration (n >= 2 samples at equal distances) is
    linear between samples; at the last sample they become small, not exactly zero.
    "none" leaves the samples as they are.
    """
    if baseline == "none":
        return acceleration
    # No more coefficients than velocities that can be changed.
    degree = min(DEGREES[baseline], len(acceleration) - 2)
    powers = legendre.legvander(np.linspace(-1, 1, len(acceleration)), degree)
    unwanted, *_ = np.linalg.lstsq(_velocities(powers), _velocities(acceleration), rcond=None)
    return np.asarray(acceleration - powers @ unwanted)


def _velocities(acceleration: Array) -> Array:
    """Integrals from the first sample to each of the others, over the time between samples."""
    return np.asarray(np.cumsum((acceleration[1:] + acceleration[:-1]) / 2, axis=0))
