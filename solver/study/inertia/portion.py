"""The portion lambda: roots of mean drift(lambda) = target, the one reported, its interval.

D(lambda) is the mean peak drift of the structure with the portion lambda of the live load fixed to
it, stiffness k and dashpot c kept. It is not monotone: roots can be several, or negative, or none.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from solver.types import Array

LEAST, MOST, SPACING = -0.5, 1.5, 0.01
"""Range of lambda, and the spacing of the points between which D(lambda) is taken as straight."""

ROUND_OFF = 1e-9
"""A target that is this near to a point of the curve is met there."""

INSENSITIVE = 0.01
"""Where D changes by less than this part between lambda = 0 and 1, lambda is not reported."""

RESAMPLES, SEED = 1000, 19
"""Number of suites that the bootstrap draws, and the seed that it draws them by."""

QUANTILES = (0.05, 0.95)
"""Quantiles that bound an interval of 90 %."""


def grid() -> Array:
    """The values of lambda at which drifts are computed."""
    count = round((MOST - LEAST) / SPACING)
    return np.round(LEAST + SPACING * np.arange(count + 1), 10)


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """Mean drift against lambda, straight between its points."""

    portions: Array
    """lambda, increasing."""
    drifts: Array
    """D(lambda)."""

    @property
    def insensitive(self) -> bool:
        """Whether the live load hardly changes the drift, so that no lambda can be told."""
        inside = self.drifts[(self.portions >= 0) & (self.portions <= 1)]
        return bool(np.ptp(inside) < INSENSITIVE * np.mean(np.abs(inside)))

    def roots(self, target: float) -> Array:
        """All lambda at which the curve has this value, increasing."""
        excess = self.drifts - target
        met = np.abs(excess) <= ROUND_OFF * abs(target)
        sign = np.where(met, 0.0, np.sign(excess))
        first = np.nonzero(sign[:-1] * sign[1:] < 0)[0]
        part = excess[first] / (excess[first] - excess[first + 1])
        low, high = self.portions[first], self.portions[first + 1]
        return np.sort(np.concatenate((low + part * (high - low), self.portions[met])))

    def turns(self) -> Array:
        """Values of lambda at which the curve has a local extreme."""
        rising = np.sign(np.diff(self.drifts))
        return self.portions[1:-1][rising[:-1] * rising[1:] < 0]

    def followed(self, targets: Array, start: float = 1.0) -> list[float]:
        """The root that a start leads to as the target goes from value to value; NaN: none.

        It stays on its branch, between two local extremes of the curve, as long as that has a root;
        then it goes on from the nearest one, and where there is none it waits.
        """
        turns, at, found = self.turns(), start, []
        for target in targets:
            roots = self.roots(target)
            if not roots.size:
                found.append(np.nan)
                continue
            low, high = np.minimum(roots, at), np.maximum(roots, at)
            between = np.searchsorted(turns, high) - np.searchsorted(turns, low, side="right")
            same = roots[between <= 0]
            near = same if same.size else roots
            at = float(near[np.argmin(np.abs(near - at))])
            found.append(at)
        return found


@dataclass(frozen=True, slots=True, kw_only=True)
class Portion:
    """What a suite says about lambda."""

    value: float | None
    """The one reported; None: there is none."""
    roots: tuple[float, ...]
    """All of them."""
    low: float | None
    """Lower end of the interval of 90 %."""
    high: float | None
    """Upper end of that interval."""
    without: float
    """Share of the resampled suites that have none."""

    @property
    def half_width(self) -> float:
        """Half of the interval; infinite where there is none."""
        return np.inf if self.low is None or self.high is None else (self.high - self.low) / 2


def resampled(count: int) -> Array:
    """How often each motion is in each resampled suite over their number, (resamples, n)."""
    chosen = np.random.default_rng(SEED).integers(count, size=(RESAMPLES, count))
    weights = np.zeros((RESAMPLES, count))
    np.add.at(weights, (np.arange(RESAMPLES)[:, None], chosen), 1.0 / count)
    return weights


def portions(drifts: Array, targets: Array, weights: Array, *, geometric: bool) -> list[Portion]:
    """Lambda at each of the targets, followed from the first one, where lambda is 1.

    Args:
        drifts: Peak drifts of each motion with the portions of the grid fixed, (n, points).
        targets: Peak drifts of each motion with what slides or rocks, (n, targets).
        weights: Of the resampled suites, (resamples, n).
        geometric: Take means of the logarithms.
    """
    known = np.all(drifts > 0, axis=0)  # where the structure has a mass that is positive
    axis, curves, aims = grid()[known], drifts[:, known], targets
    if geometric:
        curves, aims = np.log(curves), np.log(targets)
    own = Curve(axis, curves.mean(axis=0))
    if Curve(axis, drifts[:, known].mean(axis=0)).insensitive:
        none = Portion(value=None, roots=(), low=None, high=None, without=1.0)
        return [none] * targets.shape[1]
    means = aims.mean(axis=0)
    values = own.followed(means)
    those, aimed = weights @ curves, weights @ aims
    several = [Curve(axis, those[k]).followed(aimed[k]) for k in range(len(weights))]
    spread = np.array(several)
    return [
        _portion(value, own.roots(mean), spread[:, j])
        for j, (value, mean) in enumerate(zip(values, means, strict=True))
    ]


def _portion(value: float, roots: Array, spread: Array) -> Portion:
    """A value with the interval of those of the resampled suites."""
    known = spread[np.isfinite(spread)]
    low, high = np.quantile(known, QUANTILES) if known.size else (np.nan, np.nan)
    return Portion(
        value=None if np.isnan(value) else float(value),
        roots=tuple(float(root) for root in roots),
        low=float(low) if known.size else None,
        high=float(high) if known.size else None,
        without=1 - known.size / spread.size,
    )
