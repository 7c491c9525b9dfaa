"""How the motion of the ground enters the steps of rigid blocks."""

from __future__ import annotations

import numpy as np

from solver.excitation.motion import GroundMotion
from solver.types import Array


class SteppedGround:
    """The motion of the ground at the ends of equal steps, found for many of them at a time."""

    def __init__(self, motion: GroundMotion, step: float, ahead: int):
        """Begin with none.

        Args:
            motion: What moves.
            step: s.
            ahead: Number of steps to find the motion for at a time.
        """
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
            self._first = first
            self._acceleration, self._mean = motion_at(self._motion, numbers * self._step)
        begin, end = first - self._first, stop - self._first
        return self._acceleration[begin : end + 1], self._mean[begin:end]


def motion_at(motion: GroundMotion, times: Array) -> tuple[Array, Array]:
    """Accelerations at (n,) times, and the (n - 1) mean ones from each to the next, m/s2."""
    gained = np.diff(motion.velocities(times), axis=0)
    return motion.accelerations(times), gained / np.diff(times)[:, None]


def ground_of_steps(
    count: int, dimension: int, ground: Array | None, mean: Array | None
) -> tuple[Array, Array]:
    """Accelerations of the ground at the ends of steps, and by how much both ends of each shift.

    Within a step, and the pieces into which events cut it, the ground's acceleration is linear; the
    shift gives it the right mean, so that no impulse goes missing whatever happens in between.

    Args:
        count: Number of steps.
        dimension: d.
        ground: (count + 1, d) accelerations at the ends of the steps, m/s2; None: it stands.
        mean: (count, d) mean accelerations over the steps, m/s2; None: linear between the ends.
    """
    if ground is None:
        return np.zeros((count + 1, dimension)), np.zeros((count, dimension))
    ground = np.ascontiguousarray(ground, dtype=np.float64)
    if mean is None:
        return ground, np.zeros((count, dimension))
    return ground, np.ascontiguousarray(mean - (ground[1:] + ground[:-1]) / 2)
