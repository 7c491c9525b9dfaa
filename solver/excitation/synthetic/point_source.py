"""Shaking of the ground by an earthquake, on average: Fourier amplitudes and duration.

Boore's point source (2003): earthquake, path and site are factors of the amplitude. The source is
Atkinson and Silva's (2000) for California, with two corner frequencies. What was calibrated, and
with which numbers, is in docs/synthetic.md.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from solver.excitation.synthetic.bssa14 import PERIODS, site_factors
from solver.types import Array

SHEAR_VELOCITY = 3500.0
"""beta at the source, m/s."""
DENSITY = 2800.0
"""rho at the source, kg/m^3."""
RADIATION = 0.55 * 2.0 * math.sqrt(0.5)
"""Radiation pattern times free surface times share of one horizontal direction."""
KAPPA = 0.04
"""Loss in the rock below the site, s (Anderson and Hough 1984)."""
CROSSOVER = 40e3
"""Distance from which amplitudes fall with its square root only, m."""

# Duration that the path adds, s, over distance, km (Boore and Thompson 2014); its last slope holds.
_PATH = ((0.0, 7.0, 45.0, 125.0, 175.0, 270.0), (0.0, 2.4, 8.4, 10.9, 17.4, 34.2))
_PATH_SLOPE = 0.156

# Frequency, Hz, and amplification of the crust where Vs30 is 760 m/s (Boore 2016, his update of
# Boore and Joyner 1997).
# fmt: off
_CRUST = (
    (0.01, 0.045, 0.095, 0.138, 0.2, 0.291, 0.423, 0.615, 0.894, 1.301, 1.892, 2.751, 4.0, 5.817,
     8.459, 12.301, 17.889, 26.014, 37.83, 55.012, 80.0),
    (1.0, 1.04, 1.09, 1.13, 1.18, 1.25, 1.32, 1.41, 1.51, 1.64, 1.8, 1.99, 2.18, 2.38,
     2.56, 2.75, 2.95, 3.17, 3.42, 3.68, 3.96),
)
# fmt: on

CALIBRATION = ((0.25, 0.5, 1.0, 2.0, 5.0, 10.0), (1.19, 0.73, 0.87, 1.0, 1.12, 1.02))
"""Frequency, Hz, and factor with which medians agree with BSSA14 at M 6.7, 25 km, 400 m/s."""


def fourier_amplitude(frequency: Array, magnitude: float, distance_km: float, vs30: float) -> Array:
    """Amplitude |A(f)| of the acceleration of the ground in one horizontal direction, m/s.

    At frequencies f > 0, Hz, by moment magnitude, R_JB in km, and the mean velocity of shear waves
    in the upper 30 m, m/s.
    """
    path = _path(frequency, effective_distance(magnitude, distance_km))
    site = _site(frequency, magnitude, distance_km, vs30)
    return _source(frequency, magnitude) * path * site


def effective_distance(magnitude: float, distance_km: float) -> float:
    """From the site to the point that stands for the rupture, m (Atkinson and Silva 2000)."""
    depth_km = 10 ** (-0.05 + 0.15 * magnitude)
    return 1e3 * math.hypot(distance_km, depth_km)


def duration(magnitude: float, distance_km: float) -> float:
    """Duration of the strong shaking, s: 1/(2 f_a) at the source and what the path adds."""
    away_km = effective_distance(magnitude, distance_km) / 1e3
    path = float(np.interp(away_km, *_PATH)) + _PATH_SLOPE * max(away_km - _PATH[0][-1], 0.0)
    return 0.5 / _corners(magnitude)[0] + path


def _corners(magnitude: float) -> tuple[float, float, float]:
    """f_a and f_b, Hz, and the share epsilon of the second (Atkinson and Silva 2000)."""
    return (
        10 ** (2.181 - 0.496 * magnitude),
        10 ** (2.410 - 0.408 * magnitude),
        10 ** (0.605 - 0.255 * magnitude),
    )


def _source(frequency: Array, magnitude: float) -> Array:
    """Amplitude times distance at the source, m^2/s."""
    moment = 10 ** (1.5 * magnitude + 9.05)  # N m
    first, second, share = _corners(magnitude)
    shape = (1 - share) / (1 + (frequency / first) ** 2)
    shape += share / (1 + (frequency / second) ** 2)
    constant = RADIATION / (4 * math.pi * DENSITY * SHEAR_VELOCITY**3)
    return constant * moment * (2 * math.pi * frequency) ** 2 * shape


def _path(frequency: Array, distance: float) -> Array:
    """Spreading, 1/m, and loss on the way, with the quality factor 180 f^0.45."""
    spreading = 1 / distance if distance < CROSSOVER else 1 / math.sqrt(CROSSOVER * distance)
    quality = 180 * frequency**0.45
    return spreading * np.exp(-math.pi * frequency * distance / (quality * SHEAR_VELOCITY))


def _site(frequency: Array, magnitude: float, distance_km: float, vs30: float) -> Array:
    """Amplification of crust and site, loss below the site, and the calibration."""
    # The factors of the spectrum at a period stand for those of the amplitude at its inverse.
    factors = site_factors(magnitude, distance_km, vs30)[:0:-1]
    soil = _between(frequency, 1 / np.array(PERIODS[:0:-1]), factors)
    crust = np.interp(np.log(frequency), np.log(_CRUST[0]), _CRUST[1])
    return crust * soil * _between(frequency, *CALIBRATION) * np.exp(-math.pi * KAPPA * frequency)


def _between(frequency: Array, known: ArrayLike, factors: ArrayLike) -> Array:
    """Factors interpolated between logarithms, constant beyond the first and the last."""
    return np.exp(np.interp(np.log(frequency), np.log(known), np.log(factors)))
