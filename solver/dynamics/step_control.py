"""The ladder of time steps dt, dt/2, dt/4, ...: down where one fails, up where the grid allows."""

from __future__ import annotations

import math


class Ladder:
    """Time as a whole number of ticks of the smallest step, so that no round-off gathers.

    Each step size keeps its own factorization; halving reaches the same few sizes again and again.
    """

    def __init__(self, step: float, end: float, smallest: float):
        """Start at time 0 with the full step.

        Args:
            step: dt, s.
            end: Time at which the run ends, s; no step goes beyond it.
            smallest: No step is shorter than this, s.
        """
        self.depth = max(0, math.floor(math.log2(step / smallest) + 1e-9))
        self._tick = step / 2**self.depth
        self._end = math.floor(end / self._tick + 1e-9)
        self._now = 0
        self._level = 0
        self.rejected = 0

    @property
    def time(self) -> float:
        """Time reached, s."""
        return self._now * self._tick

    @property
    def done(self) -> bool:
        """Whether the end is reached."""
        return self._now >= self._end

    @property
    def step(self) -> float:
        """The step to try next, s; shorter where the end is nearer."""
        while self._level < self.depth and self._now + self._ticks > self._end:
            self._level += 1
        return self._ticks * self._tick

    @property
    def _ticks(self) -> int:
        """Ticks in the present step."""
        return 1 << (self.depth - self._level)

    def accept(self) -> None:
        """The step succeeded: go on, and climb one rung where the coarser grid has a point."""
        self._now += self._ticks
        if self._level and self._now % (2 * self._ticks) == 0:
            self._level -= 1

    def reject(self) -> bool:
        """The step failed: halve it. False where no shorter step is allowed."""
        self.rejected += 1
        if self._level == self.depth:
            return False
        self._level += 1
        return True
