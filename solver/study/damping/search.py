"""Search for the value of a parameter with which a run comes nearest to a target."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from solver.types import Array

MOST_RUNS = 8
"""Runs of a calibration, those that measure the reach included."""

ENOUGH = 5e-4
"""Difference from the target, root mean square, that ends the search."""

NEAREST = 0.01
"""Least difference between two values that are tried, relative."""

SEARCHES_OF_REACH = 2
"""Runs more at a turning point of the restitution before a target beyond it is refused."""

ALIKE = 1e-4
"""Differences from the target that are as good as one another: the smaller value is taken."""

DIGITS = 3
"""Significant digits of the values that are tried."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """One run.

    Attributes:
        value: Of the parameter.
        restitution: Mean restitution.
        found: What is compared with the target.
    """

    value: float
    restitution: float
    found: tuple[float, ...]


@dataclass(slots=True)
class Search:
    """A search between two positive values, which tries several at first and then one by one.

    The first runs, at both ends and in the middle, measure what can be reached; where restitution
    turns between them, so do one or two more at its turning point. From then on all numbers that
    are compared are interpolated over the logarithm of the value, by cubics that overshoot nothing,
    and the next run is made where that comes nearest to the target. Where several values do, the
    smallest is taken.
    """

    low: float
    high: float
    wanted: tuple[float, ...]
    restitution: float
    """Restitution that has to be within reach."""
    most: int = MOST_RUNS
    made: list[Trial] = field(default_factory=list)
    """Runs in the order in which they were made."""

    def ask(self) -> list[float]:
        """Values to run next; none where the search has ended."""
        if not self.made:
            return [self.low, _rounded(math.sqrt(self.low * self.high)), self.high]
        if len(self.made) >= self.most or self.best_error <= ENOUGH:
            return []
        value = self._nearest() if self.within_reach else self._turning_point()
        if value is None:
            return []
        tried = [abs(math.log(trial.value / value)) for trial in self.trials]
        return [value] if min(tried) > NEAREST else []

    def tell(self, trial: Trial) -> None:
        """Add a run."""
        self.made.append(trial)

    @property
    def trials(self) -> list[Trial]:
        """The runs by their values."""
        return sorted(self.made, key=lambda trial: trial.value)

    @property
    def reach(self) -> tuple[float, float]:
        """Least and largest restitution so far."""
        found = [trial.restitution for trial in self.trials]
        return min(found), max(found)

    @property
    def within_reach(self) -> bool:
        """Whether the target lies between restitutions that were found, or next to one."""
        least, largest = self.reach
        return least - ENOUGH <= self.restitution <= largest + ENOUGH

    @property
    def best(self) -> Trial:
        """The run nearest to the target."""
        return min(self.trials, key=self.error)

    @property
    def best_error(self) -> float:
        """Difference of the nearest run from the target."""
        return self.error(self.best)

    def error(self, trial: Trial) -> float:
        """Difference of a run from the target, root mean square."""
        return _root_mean_square(np.array(trial.found) - np.array(self.wanted))

    def _turning_point(self) -> float | None:
        """Value at which restitution turns on the side of the target; None where it does not."""
        trials, (least, largest) = self.trials, self.reach
        extreme = least if self.restitution < least else largest
        number = [trial.restitution for trial in trials].index(extreme)
        if not 0 < number < len(trials) - 1 or len(trials) >= 3 + SEARCHES_OF_REACH:
            return None
        near = trials[number - 1 : number + 2]
        places = np.log([trial.value for trial in near]) - math.log(near[1].value)
        _, slope, bend = np.polynomial.polynomial.polyfit(
            places, [trial.restitution for trial in near], 2
        )
        return _rounded(near[1].value * math.exp(-slope / (2 * bend)))

    def _nearest(self) -> float:
        """Value at which the interpolated runs are nearest to the target."""
        from scipy.interpolate import PchipInterpolator

        places = np.log([trial.value for trial in self.trials])
        found = np.array([trial.found for trial in self.trials])
        fine = np.linspace(places[0], places[-1], 4001)
        differences = PchipInterpolator(places, found)(fine) - np.array(self.wanted)
        errors = np.sqrt(np.mean(differences**2, axis=1))
        good = np.flatnonzero(errors <= errors.min() + ALIKE)
        first = np.split(good, np.flatnonzero(np.diff(good) > 1) + 1)[0]
        return _rounded(math.exp(fine[first[np.argmin(errors[first])]]))


def _root_mean_square(values: Array) -> float:
    """Root of the mean of the squares."""
    return float(np.sqrt(np.mean(values**2)))


def _rounded(value: float) -> float:
    """A value with few digits."""
    return float(f"{value:.{DIGITS - 1}e}")
