"""The limit of a sequence of measured values, and how far off it may be."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

LEAST_ORDER, MOST_ORDER = 0.5, 2.0
"""Orders of convergence that are believed; no more than the second is relied on."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Limit:
    """Limit of a sequence.

    Attributes:
        value: The limit.
        uncertainty: How far off it may be.
        source: "extrapolated"; "reached": the last values agree within their own uncertainty;
            "scatter": they have no order of convergence, and the last of them stands.
        order: Order of the convergence, NaN where nothing is extrapolated.
    """

    value: float
    uncertainty: float
    source: Literal["extrapolated", "reached", "scatter"]
    order: float = math.nan


def limit(
    distances: Sequence[float], values: Sequence[float], errors: Sequence[float]
) -> Limit | None:
    """Limit for distances that go to zero, from the last three values; None for less than three.

    Values that differ by C x^p are extrapolated, and the whole correction is the uncertainty,
    besides that of the last value. The order p follows from the three values; of more than the
    second no use is made. Where the last two agree within their own uncertainties, nothing is left
    to extrapolate. Where differences fall more slowly than with order 0.5, or change their sign,
    nothing is extrapolated either: the last value stands, and the range of the three is the
    uncertainty.

    Args:
        distances: x, positive; in any order.
        values: What was measured there.
        errors: Uncertainty of each value, such as the standard error of its mean.
    """
    order = sorted(range(len(distances)), key=lambda i: -distances[i])[-3:]
    if len(order) < 3:
        return None
    x = [distances[i] for i in order]
    e = [values[i] for i in order]
    own = errors[order[-1]]
    former, latest = e[1] - e[0], e[2] - e[1]
    noise = math.hypot(own, errors[order[-2]])
    if abs(latest) <= noise:
        return Limit(value=e[2], uncertainty=max(abs(latest), own), source="reached")
    power = _order(x, former / latest)
    if power is None:
        spread = max(e) - min(e)
        return Limit(value=e[2], uncertainty=max(spread, own), source="scatter")
    correction = latest / ((x[1] / x[2]) ** power - 1)
    return Limit(
        value=e[2] + correction,
        uncertainty=abs(correction) + own,
        source="extrapolated",
        order=power,
    )


def _order(x: Sequence[float], fall: float) -> float | None:
    """The order p for which differences of x^p fall by this factor; None where none is believed."""

    def falls(power: float) -> float:
        return float((x[0] ** power - x[1] ** power) / (x[1] ** power - x[2] ** power))

    if fall < falls(LEAST_ORDER):
        return None
    low, high = LEAST_ORDER, MOST_ORDER
    if fall >= falls(high):
        return high
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if falls(middle) < fall else (low, middle)
    return low
