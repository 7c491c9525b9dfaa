"""Restitution of a block in one run: impact by impact, their mean, and how much they scatter."""

from __future__ import annotations

import math
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class Restitution:
    """Restitution of the first impacts of a block.

    Attributes:
        known: That of each impact of which it is known, in their order.
        wanted: Number of impacts that count.
    """

    known: tuple[float, ...]
    wanted: int

    @classmethod
    def of(cls, block: Mapping[str, Any], wanted: int) -> Restitution:
        """From the part of a summary that tells of a block.

        Args:
            block: `summary["blocks"][NAME]`.
            wanted: Number of impacts that count.
        """
        impacts = [impact["restitution"] for impact in block["impacts"][:wanted]]
        return cls(tuple(e for e in impacts if e is not None and e > 0), wanted)

    @property
    def mean(self) -> float | None:
        """Geometric mean; None where there is no impact."""
        return geometric_mean(self.known) if self.known else None

    @property
    def error(self) -> float:
        """Standard error of the mean; 0 for a single impact."""
        if len(self.known) < 2:
            return 0.0
        return statistics.stdev(self.known) / math.sqrt(len(self.known))

    @property
    def complete(self) -> bool:
        """Whether all impacts that count are known."""
        return len(self.known) >= self.wanted

    def too_few(self, end: float) -> str:
        """What is missing, in words; "" where nothing is.

        Args:
            end: Time at which the run ended, s.
        """
        if self.complete:
            return ""
        count = f"{len(self.known) or 'no'} impact{'s' * (len(self.known) != 1)}"
        return f"{count} with a restitution by {end:g} s, {self.wanted} are wanted"


def geometric_mean(values: Sequence[float]) -> float:
    """Geometric mean of positive numbers."""
    return math.exp(statistics.fmean(math.log(value) for value in values))
