"""The ladder of time steps, a factor of two from rung to rung, and who goes up and down on it."""

from __future__ import annotations

import math


class Ladder:
    """Time as a whole number of ticks of the smallest step, so that no round-off gathers.

    Each step size keeps its own factorizations; halving reaches the same few sizes again and again.
    Where steps fail again and again the ladder is climbed ever later: each failure doubles the
    number of steps that have to succeed first, up to `LONGEST_WAIT`; each rung that holds halves
    it.
    """

    LONGEST_WAIT = 64
    """Steps that have to succeed before a rung is climbed, at most."""

    def __init__(self, step: float, end: float, smallest: float, largest: float | None = None):
        """Start at time 0 with a step of `step`.

        Args:
            step: dt, s; all steps are dt times a power of two.
            end: Time at which the run ends, s; no step goes beyond it.
            smallest: No step is shorter than this, s.
            largest: No step is longer than this, s; None for `step`.
        """
        self._level = 0 if largest is None else max(0, math.floor(math.log2(largest / step) + 1e-9))
        self.depth = self._level + max(0, math.floor(math.log2(step / smallest) + 1e-9))
        self._tick = step / 2 ** (self.depth - self._level)
        self._end = math.floor(end / self._tick + 1e-9)
        self._now = 0
        self._wait, self._succeeded = 1, 0
        self._tries = False
        """Whether the next step is the first one after climbing."""
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

    def accept(self, *, climb: bool = True) -> None:
        """The step succeeded: go on; climb a rung where the coarser grid has a point."""
        self._now += self._ticks
        self._succeeded += 1
        if self._tries:
            self._wait = max(1, self._wait // 2)
        ready = climb and self._succeeded >= self._wait
        self._tries = bool(ready and self._level and self._now % (2 * self._ticks) == 0)
        if self._tries:
            self._level -= 1
            self._succeeded = 0

    def reject(self) -> bool:
        """The step failed: halve it. False where no shorter step is allowed."""
        self.rejected += 1
        self._wait, self._succeeded = min(2 * self._wait, self.LONGEST_WAIT), 0
        self._tries = False
        if self._level == self.depth:
            return False
        self._level += 1
        return True


class Tolerance:
    """Judges steps by the error they make, and more strictly around events.

    A step that is refused has met something sudden: an impact, the end of a slip. The error that
    such a step makes is of first order and stays, while smooth motion and vibration leave next to
    nothing. So the tolerance is `CALM` times as large until a step is refused; then it counts as it
    is until `WATCH` steps have passed, of which none is longer than the one before.
    """

    CALM = 10.0
    """Factor of the tolerance while nothing sudden happens."""

    WATCH = 32
    """Steps that do not grow after a step was refused."""

    def __init__(self, tolerance: float):
        """Judge by a tolerance, in the unit of the errors."""
        self._tolerance, self._watch = tolerance, 0

    @property
    def _bound(self) -> float:
        """Error up to which a step is accepted at present."""
        return self._tolerance if self._watch else self.CALM * self._tolerance

    def accepts(self, error: float) -> bool:
        """Whether a step with this error is good enough; if not, something has happened."""
        if error <= self._bound:
            return True
        self._watch = self.WATCH
        return False

    def climbs(self, error: float) -> bool:
        """After an accepted step: whether twice the step may be tried, its error being 8 times."""
        self._watch = max(self._watch - 1, 0)
        return not self._watch and 8 * error <= self._bound / 2
