"""Pulses of the ground that overturn a slender block at rest, without an impact: closed forms.

For theta << 1 the block on one corner obeys y'' = p^2 y + forcing, whose growing part is z = y +
y'/p: it overturns where z >= 0 after the pulse, y being the angle beyond alpha (Dimitrakopoulos and
DeJong 2012). A is the amplitude over g tan alpha, s = omega/p.
"""

from __future__ import annotations

import math
from collections.abc import Callable

LARGEST = 1e6
"""Amplitude up to which a threshold is looked for."""


def half_sine_threshold(frequency: float) -> float:
    """Least A of half a sine of frequency s = omega/p that overturns without an impact.

    sqrt(A^2 - 1) + A exp(-(pi - asin(1/A))/s) = s.
    """
    return _least(lambda a, rest: rest + a * _decay(a, math.pi, frequency) - frequency)


def one_sine_threshold(frequency: float) -> float:
    """Least A of one period of a sine of s = omega/p that overturns without an impact.

    sqrt(A^2 - 1) - A exp(-(2 pi - asin(1/A))/s) = s.
    """
    return _least(lambda a, rest: rest - a * _decay(a, 2 * math.pi, frequency) - frequency)


def _decay(amplitude: float, phase: float, frequency: float) -> float:
    """exp(-(phase - asin(1/A))/s): from uplift to the end of the pulse."""
    return math.exp(-(phase - math.asin(1 / amplitude)) / frequency)


def _least(excess: Callable[[float, float], float]) -> float:
    """The amplitude A >= 1 at which an excess, a function of A and sqrt(A^2 - 1), becomes zero."""

    def value(amplitude: float) -> float:
        return excess(amplitude, math.sqrt(amplitude**2 - 1))

    if value(1.0) >= 0:
        return 1.0
    from scipy.optimize import brentq

    return float(brentq(value, 1.0, LARGEST, xtol=1e-13, rtol=1e-13))
