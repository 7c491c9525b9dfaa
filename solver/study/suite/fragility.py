"""Statistics of an ensemble: probabilities of overturning, and a lognormal curve through them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from solver.types import Array

CONFIDENCE = 0.95
"""Probability that an interval holds what it is for."""

LARGEST_LOGARITHM = 700.0
"""Magnitude of logarithms of numbers that floating point has, with something to spare."""


@dataclass(frozen=True, slots=True)
class Lognormal:
    """P(x) = Phi(ln(x/median)/beta): the probability of overturning at the intensity x.

    Attributes:
        median: Intensity at which half of all motions overturn the block.
        beta: Standard deviation of the logarithm of the intensity that overturns it.
        median_interval: Of confidence, for the median.
        beta_error: Standard error of beta.
    """

    median: float
    beta: float
    median_interval: tuple[float, float]
    beta_error: float

    def probability(self, intensity: Array) -> Array:
        """Probability of overturning at intensities > 0."""
        from scipy.stats import norm

        return np.asarray(norm.cdf(np.log(intensity / self.median) / self.beta))


def interval(count: int, trials: int) -> tuple[float, float]:
    """Interval of confidence of a probability (Clopper and Pearson 1934), which is never too short.

    Args:
        count: How often it happened.
        trials: Of how many times.
    """
    from scipy.stats import binomtest

    found = binomtest(count, trials).proportion_ci(CONFIDENCE, method="exact")
    return float(found.low), float(found.high)


def fitted(
    levels: Sequence[float], counts: Sequence[int], trials: Sequence[int]
) -> Lognormal | None:
    """The lognormal curve of largest likelihood of what happened at some levels.

    With P = Phi(b ln x - a) the logarithm of the likelihood is concave in a and b (a probit
    regression). It has a maximum where some motion overturns at a level below one at which another
    does not; None where there is none such, and where probabilities do not rise to speak of.

    Args:
        levels: Intensities > 0.
        counts: How many overturned at each level.
        trials: Of how many.
    """
    from scipy.optimize import minimize
    from scipy.stats import norm

    x, k, n = np.log(np.asarray(levels)), np.asarray(counts), np.asarray(trials)
    if not (k > 0).any() or not (k < n).any() or x[k > 0].min() >= x[k < n].max():
        return None
    middle, spread = float(x.mean()), float(np.ptp(x))
    z = (x - middle) / spread  # both parameters are then numbers near one

    def cost(parameters: Array) -> tuple[float, Array]:
        arguments = parameters[1] * z - parameters[0]
        above, below = norm.logcdf(arguments), norm.logsf(arguments)
        density = norm.logpdf(arguments)
        rate = k * np.exp(density - above) - (n - k) * np.exp(density - below)
        value = -float(k @ above + (n - k) @ below)
        return value, np.array([rate.sum(), -(rate @ z)])

    a, b = minimize(cost, np.array([0.0, 1.0]), jac=True, method="BFGS").x
    if b <= 0:
        return None
    arguments = b * z - a
    weight = n * np.exp(2 * norm.logpdf(arguments) - norm.logcdf(arguments) - norm.logsf(arguments))
    information = np.array([[weight.sum(), -(weight @ z)], [-(weight @ z), (weight * z) @ z]])
    covariance = np.linalg.inv(information)
    slope = spread * np.array([1 / b, -a / b**2])  # of ln(median) by a and b
    error = math.sqrt(float(slope @ covariance @ slope))
    centre, wide = middle + spread * a / b, float(norm.ppf(0.5 + CONFIDENCE / 2)) * error
    if not abs(centre) + wide < LARGEST_LOGARITHM:
        return None  # as many overturn at all levels
    return Lognormal(
        median=math.exp(centre),
        beta=float(spread / b),
        median_interval=(math.exp(centre - wide), math.exp(centre + wide)),
        beta_error=spread / b**2 * math.sqrt(float(covariance[1, 1])),
    )


def distance(one: Sequence[float], other: Sequence[float]) -> float:
    """The Kolmogorov-Smirnov distance of two samples.

    The largest difference of their distributions. Blocks that overturned are infinite in them.
    """
    ends = np.sort(np.concatenate([one, other]))
    parts = [np.searchsorted(np.sort(sample), ends, side="right") / len(sample)
             for sample in (one, other)]  # fmt: skip
    return float(np.abs(parts[0] - parts[1]).max())
