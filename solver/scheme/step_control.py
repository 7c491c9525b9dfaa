"""The ladder of time steps, a factor of two from rung to rung, and the criteria to change rungs."""

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
        """Start at time 0 with a step dt, s; all steps are dt times a power of two.

        No step goes beyond the end, is shorter than the smallest, or longer than the largest, by
        default dt.
        """
        self._level = 0 if largest is None else max(0, math.floor(math.log2(largest / step) + 1e-9))
        self.depth = self._level + max(0, math.floor(math.log2(step / smallest) + 1e-9))
        self._tick = step / 2 ** (self.depth - self._level)
        self._now = 0
        self.lead_to(end)
        self._wait, self._succeeded = 1, 0
        self._tries = False
        """True if the next step is the first one after climbing."""
        self.rejected = 0

    def lead_to(self, end: float) -> None:
        """Let the ladder end at a time, s."""
        self._end = math.floor(end / self._tick + 1e-9)

    @property
    def time(self) -> float:
        """Time reached, s."""
        return self._now * self._tick

    @property
    def done(self) -> bool:
        """True if the end is reached."""
        return self._now >= self._end

    @property
    def step(self) -> float:
        """The step to try next, s; shorter where the end is nearer."""
        while self._level < self.depth and self._now + self._ticks > self._end:
            self._level += 1
        return self._ticks * self._tick

    @property
    def then(self) -> float:
        """Time at the end of that step, s."""
        return (self._now + self._ticks) * self._tick

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
        self._wait = min(2 * self._wait, self.LONGEST_WAIT)
        return self.shorten()

    def shorten(self, halvings: int = 1) -> bool:
        """The step is not accurate enough: halve it so often; False where no shorter is allowed.

        That says nothing of the steps that follow: the ladder is climbed as early as before.
        """
        self.rejected += 1
        self._succeeded = 0
        self._tries = False
        if self._level == self.depth:
            return False
        self._level = min(self._level + halvings, self.depth)
        return True


class Tolerance:
    """Judges steps by the error they make in the motion of bodies, over half their diagonal.

    Where contact changes within a step, the error of the rigid motion is of first order, and what
    an impact takes is decided there: the bound is strict. Elsewhere it is of third order and evens
    out, as the forces swing with the vibration of the bodies: the bound is `CALM` times as large.
    Vibration itself is judged by a bound of its own, since it decides how a block that has left the
    ground after an impact meets it again. What damping leaves of it until the next impact meets
    that in some phase, which has to be right as well: the bound is the lower, the more is left.
    """

    CHANGE = 8e-6
    """Error of the rigid motion in a step in which contact changes, over the tolerance."""
    CALM = 100.0
    """Factor of that error in all other steps."""
    VIBRATION = 3e-4
    """Error of the vibration in a step, over the tolerance, where none is left at next impacts."""
    LASTING = 40.0
    """By what that bound is divided, less 1, over the share that is left."""
    FOLLOWED = 2.0
    """The share that counts is at most so many times what damping takes."""
    GROWTH = 8.0
    """By what the error grows when the step doubles."""
    MARGIN = 1.15
    """Reserve of a step that may double."""

    def __init__(self, tolerance: float, left: float = 0.0):
        """Judge by a tolerance, which is about the error of the restitution of an impact.

        `left` is the share of an impact's vibration that is left when the next one comes. Where
        damping takes next to nothing, the phase would have to be right over all impacts that
        follow, which no steps can afford: such vibration is not followed.
        """
        self._tolerance = tolerance
        share = min(left, self.FOLLOWED * (1.0 - left))
        self._vibration = self.VIBRATION / (1.0 + self.LASTING * share)

    def used(self, *, rigid: float, vibration: float, reversal: float, changed: bool) -> float:
        """The share of what is allowed that a step used; above 1 it is refused.

        Args:
            rigid: Error of the motion as a whole, over half the diagonal.
            vibration: Root of the mean square error of the points of a body, over the same length.
            reversal: Error of a slip that turned round within the step, over that length.
            changed: True if contact changed in the step.
        """
        bound = self.CHANGE * (1.0 if changed else self.CALM)
        shares = rigid / bound, vibration / self._vibration, reversal / self.CHANGE
        return max(shares) / self._tolerance

    def climbs(self, used: float) -> bool:
        """True if twice the step may be tried after one that used this share."""
        return self.MARGIN * self.GROWTH * used <= 1.0

    def halvings(self, used: float) -> int:
        """Number of halvings of a step that used this share, above 1, of what is allowed."""
        return max(1, math.floor(math.log(used, self.GROWTH)))
