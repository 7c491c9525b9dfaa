"""Closed forms of rebounds."""

from __future__ import annotations

import math


def rebound_of_a_mass(ratio: float) -> float:
    """Speed after over speed before, of a mass on a spring and a dashpot that do not pull.

    The mass leaves when spring and dashpot together hold nothing any more.

    Args:
        ratio: Of critical damping, below 1.
    """
    damped = math.sqrt(1 - ratio**2)
    phase = math.atan2(2 * ratio * damped, 2 * ratio**2 - 1)
    return math.exp(-ratio * phase / damped)
