"""What shaking records show on average: the ground-motion model of Boore et al. (2014), "BSSA14".

D. M. Boore, J. P. Stewart, E. Seyhan, G. M. Atkinson (2014), NGA-West2 equations for predicting
PGA, PGV, and 5 % damped PSA for shallow crustal earthquakes, Earthquake Spectra 30, 1057-1085.
Medians of RotD50, for California, faults of any kind, basins of average depth.
"""

from __future__ import annotations

import math

import numpy as np

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
    return G_UNIT * rock * _site(vs30, float(rock[0]))


def site_factors(magnitude: float, distance_km: float, vs30: float) -> Array:
    """Median spectrum over that of the same earthquake where Vs30 is 760 m/s, at `PERIODS`."""
    return _site(vs30, float(_on_rock(magnitude, distance_km)[0]))


def _on_rock(magnitude: float, distance_km: float) -> Array:
    """The spectrum where Vs30 is 760 m/s, g (Eqs. 2 to 4)."""
    above = magnitude - _OF["Mh"]
    below = _OF["e4"] * above + _OF["e5"] * above**2
    event = _OF["e0"] + np.where(above <= 0, below, _OF["e6"] * above)
    distance = np.hypot(distance_km, _OF["h"])
    spreading = _OF["c1"] + _OF["c2"] * (magnitude - 4.5)
    return np.exp(event + spreading * np.log(distance) + _OF["c3"] * (distance - 1))


def _site(vs30: float, rock_pga: float) -> Array:
    """Linear and nonlinear amplification; `rock_pga` in g (Eqs. 6 to 8)."""
    linear = _OF["c"] * np.log(np.minimum(vs30, _OF["Vc"]) / REFERENCE_VS30)
    softer = min(vs30, REFERENCE_VS30) - 360
    slope = _OF["f4"] * (np.exp(_OF["f5"] * softer) - np.exp(_OF["f5"] * (REFERENCE_VS30 - 360)))
    return np.exp(linear + slope * math.log((rock_pga + 0.1) / 0.1))
