"""How far bodies turn in the coming step, by how they turned in the last ones."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from solver.bodies.kinematics import turning_ahead
from solver.types import Array


class Turning(NamedTuple):
    """How all bodies turn at the start of a step.

    Attributes:
        step: Length of the step, s.
        spins: Angular velocities, one (2-D) or three (3-D) numbers each, rad/s.
        rates: Their change since the start of the step before, rad/s2; zero in a first step.
        angles: Angles, or rotation vectors, by which bodies turn in the step, rad.
        halves: Those by which they turn up to its middle, rad.
    """

    step: float
    spins: Sequence[Array]
    rates: Sequence[Array]
    angles: Sequence[Array]
    halves: Sequence[Array]

    @classmethod
    def of(cls, spins: Sequence[Array], step: float, last: Turning | None) -> Turning:
        """The turning of a step of a length (s), after the last step."""
        ahead = []
        for number, spin in enumerate(spins):
            if last is None:
                before, rate, length = spin, np.zeros_like(spin), 1.0
            else:
                before, rate, length = last.spins[number], last.rates[number], last.step
            ahead.append(np.empty((3, len(spin))))
            turning_ahead(spin, before, rate, length, step, ahead[-1])
        rates, angles = [each[0] for each in ahead], [each[2] for each in ahead]
        return cls(step, spins, rates, angles, [0.5 * angle for angle in angles])
