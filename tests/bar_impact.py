"""A clamped elastic bar that hits a wall again and again: closed form.

The bar occupies 0 < x < 1 with E = rho = A = 1. It is clamped at x = 1, touches the wall where
u(0) = 0 (u(0) >= 0 otherwise) and is released at rest with u = (1 - x)/2. The motion has the
period 3 and the energy 1/8. In each third of the period, t mod 3 = k + s with k = 0, 1, 2, the
displacement is linear between the characteristics s = x and s = 1 - x: the bar flies (k = 0), stays
in contact (k = 1), flies back (k = 2).

Source: Dabaghi, Petrov, Pousin and Renard (2014), wave equation with unilateral contact.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

#: Period of the motion.
PERIOD = 3.0

#: Energy of the bar, which is conserved.
ENERGY = 0.125


def _split(time: float) -> tuple[int, float]:
    """Number k of the third of the period, and time s in [0, 1) since it began."""
    phase = time % PERIOD
    k = min(int(phase), 2)
    return k, phase - k


def displacement(time: float, x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Displacement u(t, x) at points in [0, 1]."""
    k, s = _split(time)
    before, early = s < x, s <= 1 - x
    if k == 0:
        return np.where(before, (1 - x) / 2, (1 - s) / 2)
    if k == 1:
        return np.where(early, np.where(before, -s / 2, -x / 2), np.where(before, x - 1, s - 1) / 2)
    return np.where(early, s / 2, (1 - x) / 2)


def velocity(time: float, x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Velocity v(t, x) at points in [0, 1]."""
    k, s = _split(time)
    before, early = s < x, s <= 1 - x
    if k == 0:
        return np.where(before, 0.0, -0.5)
    if k == 1:
        return np.where(early, np.where(before, -0.5, 0.0), np.where(before, 0.0, 0.5))
    return np.where(early, 0.5, 0.0)


def contact_stress(time: float) -> float:
    """Stress at x = 0, negative in compression."""
    return -0.5 if _split(time)[0] == 1 else 0.0
