"""How far bodies turn in the coming step, by how they turned in the last ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Turning:
    """Of all bodies at the start of a step.

    Attributes:
        spins: Angular velocities, one (2-D) or three (3-D) numbers each, rad/s.
        rates: Their change since the start of the step before, rad/s2; zero in a first step.
        step: Length of the step, s.
    """

    spins: Sequence[Array]
    rates: Sequence[Array]
    step: float

    @classmethod
    def of(cls, spins: Sequence[Array], step: float, last: Turning | None) -> Turning:
        """That of a step of a length (s), after the last step."""
        if last is None:
            return cls(spins, [np.zeros_like(spin) for spin in spins], step)
        pairs = zip(spins, last.spins, strict=True)
        rates = [np.asarray((spin - before) / last.step) for spin, before in pairs]
        return cls(spins, rates, step)

    def halves(self, last: Turning | None) -> list[Array]:
        """Angles, or rotation vectors, by which bodies turn up to the middle of the step, rad.

        Spins go on to change as they did in the last step, where they did so in the one before, too
        (the smaller of both changes): what an impact did says nothing of what follows.
        """
        if last is None:
            return [0.5 * self.step * spin for spin in self.spins]
        halves = []
        for spin, rate, before in zip(self.spins, self.rates, last.rates, strict=True):
            steady = np.where(np.abs(rate) < np.abs(before), rate, before)
            steady = np.where(rate * before > 0, steady, 0.0)
            halves.append(0.5 * self.step * (spin + 0.5 * self.step * steady))
        return halves
