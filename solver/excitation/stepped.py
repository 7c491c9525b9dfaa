"""The motion of the ground at the ends of equal steps, found for many of them at a time."""

from __future__ import annotations

import numpy as np

from solver.excitation.motion import GroundMotion
from solver.types import Array


class SteppedGround:
    """The motion of the ground at the ends of equal steps, kept for some steps ahead."""

    def __init__(self, motion: GroundMotion, step: float, ahead: int):
        """Begin with none; the motion is found for a number of steps (s) ahead at a time."""
        self._motion, self._step, self._ahead = motion, step, ahead
        self._first = 0
        self._acceleration: Array = np.zeros((0, 0))
        self._mean: Array = np.zeros((0, 0))

    def between(self, first: int, stop: int) -> tuple[Array, Array]:
        """The ground from step number `first` to `stop`.

        Returns:
            (stop - first + 1, d) accelerations at the ends of the steps, and (stop - first, d) mean
            ones over the steps, m/s2.
        """
        if not self._first <= first <= stop < self._first + len(self._acceleration):
            numbers = np.arange(first, max(stop, first + self._ahead) + 1, dtype=np.float64)
            times = numbers * self._step
            self._first = first
            self._acceleration = self._motion.accelerations(times)
            self._mean = self._motion.means(times)
        begin, end = first - self._first, stop - self._first
        return self._acceleration[begin : end + 1], self._mean[begin:end]
