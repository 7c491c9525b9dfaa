"""Shaking of the ground by an earthquake, on average: a ground-motion model and a point source.

The model of response spectra is that of Boore et al. (2014), "BSSA14": D. M. Boore, J. P. Stewart,
E. Seyhan, G. M. Atkinson (2014), NGA-West2 equations for predicting PGA, PGV, and 5 % damped PSA
for shallow crustal earthquakes, Earthquake Spectra 30, 1057-1085. Medians of RotD50, for
California, faults of any kind, basins of average depth.

The source, for Fourier amplitudes and duration, is Boore's point source (2003): earthquake, path
and site are factors of the amplitude; the source is Atkinson and Silva's (2000) for California,
with two corner frequencies. The calibration is in docs/synthetic.md.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from solver.scene.motion import G_UNIT
from solver.types import Array

REFERENCE_VS30 = 760.0
"""Shear-wave velocity of the sites whose factor is 1, m/s."""

_NAMES = ("T", "Mh", "e0", "e4", "e5", "e6", "c1", "c2", "c3", "h", "c", "Vc", "f4", "f5")
# A row for each period, s; the first is that of the peak ground acceleration.
# fmt: off
_ROWS = (
    (0.00, 5.50, 0.4473, 1.431, 0.05053, -0.1662, -1.134, 0.1917, -0.008088, 4.5,
     -0.6, 1500.0, -0.15, -0.00701),
    (0.10, 5.54, 1.1268, 1.4293, 0.055231, -0.19838, -1.0652, 0.17203, -0.0102, 4.13,
     -0.48724, 1479.12, -0.24916, -0.0056),
    (0.15, 5.74, 1.3095, 1.2844, -0.042065, -0.18234, -1.0532, 0.15401, -0.008977, 4.39,
     -0.57962, 1442.85, -0.25713, -0.00585),
    (0.20, 5.92, 1.3255, 1.1349, -0.11096, -0.15852, -1.0607, 0.14489, -0.007717, 4.61,
     -0.68762, 1392.61, -0.24658, -0.00614),
    (0.25, 6.05, 1.2766, 1.0166, -0.16213, -0.12784, -1.0773, 0.13925, -0.006517, 4.78,
     -0.77177, 1356.21, -0.23574, -0.00644),
    (0.30, 6.14, 1.2217, 0.95676, -0.1959, -0.092855, -1.0948, 0.13388, -0.005475, 4.93,
     -0.84165, 1308.47, -0.21912, -0.0067),
    (0.40, 6.20, 1.1046, 0.96766, -0.22608, -0.023189, -1.1243, 0.12512, -0.004053, 5.16,
     -0.91092, 1252.66, -0.19582, -0.00713),
    (0.50, 6.20, 0.96991, 1.0384, -0.23522, 0.029119, -1.1459, 0.12015, -0.00322, 5.34,
     -0.9693, 1203.91, -0.175, -0.00744),
    (0.75, 6.20, 0.66903, 1.2871, -0.21591, 0.10829, -1.1777, 0.11054, -0.001931, 5.6,
     -1.0154, 1147.59, -0.13866, -0.00812),
    (1.00, 6.20, 0.3932, 1.5004, -0.18983, 0.17895, -1.193, 0.10248, -0.00121, 5.74,
     -1.05, 1109.95, -0.10521, -0.00844),
    (1.50, 6.20, -0.14954, 1.7622, -0.1467, 0.33896, -1.2063, 0.096445, -0.000365, 6.18,
     -1.0454, 1072.39, -0.062, -0.00771),
    (2.00, 6.20, -0.58669, 1.9152, -0.11237, 0.44788, -1.2159, 0.096361, 0.0, 6.54,
     -1.0392, 1009.49, -0.036136, -0.00479),
    (3.00, 6.20, -1.1898, 2.1323, -0.04332, 0.62694, -1.2179, 0.097638, 0.0, 6.93,
     -1.0112, 922.43, -0.013577, -0.00183),
    (4.00, 6.20, -1.6388, 2.204, -0.014642, 0.76303, -1.2162, 0.10218, -0.000052, 7.32,
     -0.96938, 844.48, -0.003212, -0.00152),
)
# fmt: on
_OF = dict(zip(_NAMES, np.array(_ROWS).T, strict=True))

PERIODS: tuple[float, ...] = tuple(row[0] for row in _ROWS)
"""T, s, at which the model is written out; 0 stands for the peak ground acceleration."""


def median_spectrum(magnitude: float, distance_km: float, vs30: float) -> Array:
    """Median PGA and pseudo-spectral accelerations at `PERIODS`, m/s^2 (Eqs. 1 to 8).

    By moment magnitude, R_JB from the site to the surface projection of the rupture in km, and the
    mean velocity of shear waves in the upper 30 m, m/s.
    """
    rock = _on_rock(magnitude, distance_km)
    return G_UNIT * rock * _site_factor(vs30, float(rock[0]))


def site_factors(magnitude: float, distance_km: float, vs30: float) -> Array:
    """Median spectrum over that of the same earthquake where Vs30 is 760 m/s, at `PERIODS`."""
    return _site_factor(vs30, float(_on_rock(magnitude, distance_km)[0]))


def _on_rock(magnitude: float, distance_km: float) -> Array:
    """The spectrum where Vs30 is 760 m/s, g (Eqs. 2 to 4)."""
    above = magnitude - _OF["Mh"]
    below = _OF["e4"] * above + _OF["e5"] * above**2
    event = _OF["e0"] + np.where(above <= 0, below, _OF["e6"] * above)
    distance = np.hypot(distance_km, _OF["h"])
    spreading = _OF["c1"] + _OF["c2"] * (magnitude - 4.5)
    return np.exp(event + spreading * np.log(distance) + _OF["c3"] * (distance - 1))


def _site_factor(vs30: float, rock_pga: float) -> Array:
    """Linear and nonlinear amplification; `rock_pga` in g (Eqs. 6 to 8)."""
    linear = _OF["c"] * np.log(np.minimum(vs30, _OF["Vc"]) / REFERENCE_VS30)
    softer = min(vs30, REFERENCE_VS30) - 360
    slope = _OF["f4"] * (np.exp(_OF["f5"] * softer) - np.exp(_OF["f5"] * (REFERENCE_VS30 - 360)))
    return np.exp(linear + slope * math.log((rock_pga + 0.1) / 0.1))


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
