"""How far bodies turn in the coming step, by how they turned in the last ones."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from solver.types import Array


class Turning(NamedTuple):
    """How all bodies turn at the start of a step.

    Attributes:
        step: Length of the step, s.
        spins: Angular velocities, one (2-D) or three (3-D) numbers each, rad/s.
        rates: Their change since the start of the step before, rad/s2; zero in a first step.
        steady: What of it can be counted on for this step: what an impact did cannot.
    """

    step: float
    spins: Sequence[Array]
    rates: Sequence[Array]
    steady: Sequence[Array]

    @classmethod
    def of(cls, spins: Sequence[Array], step: float, last: Turning | None) -> Turning:
        """The turning of a step of a length (s), after the last step."""
        if last is None:
            none = [np.zeros_like(spin) for spin in spins]
            return cls(step, spins, none, none)
        pairs = zip(spins, last.spins, strict=True)
        rates = [np.asarray((spin - before) / last.step) for spin, before in pairs]
        return cls(
            step, spins, rates, [_smaller(*two) for two in zip(rates, last.rates, strict=True)]
        )

    @property
    def angles(self) -> list[Array]:
        """Angles, or rotation vectors, by which bodies turn in the step, rad."""
        pairs = zip(self.spins, self.steady, strict=True)
        return [self.step * (spin + 0.5 * self.step * rate) for spin, rate in pairs]

    @property
    def halves(self) -> list[Array]:
        """Angles, or rotation vectors, by which bodies turn up to the middle of the step, rad."""
        return [0.5 * angle for angle in self.angles]


def _smaller(rate: Array, before: Array) -> Array:
    """The smaller of two changes, none where they go different ways."""
    smaller = np.where(np.abs(rate) < np.abs(before), rate, before)
    return np.where(rate * before > 0, smaller, 0.0)
