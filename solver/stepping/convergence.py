"""Criteria of convergence and of failure of the iteration of a step."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple


class IterationVerdict(IntEnum):
    """The verdict after an iteration, by PETSc's numbers (`SNESConvergedReason`)."""

    ITERATING = 0
    SMALL_RESIDUAL = 2
    SMALL_RELATIVE_RESIDUAL = 3
    SMALL_CORRECTION = 4
    NOT_A_NUMBER = -4
    TOO_MANY_ITERATIONS = -5
    GROWING = -9


class IterationRecord(NamedTuple):
    """An iteration so far."""

    residuals: Sequence[float]
    """Euclidean norm of the residual at every iterate, the first guess included, N."""
    correction: float
    """Norm of the last correction, m."""
    unknowns: float
    """Norm of the unknowns, m."""
    forces: float
    """Largest norm of the contact forces so far, N."""
    acceleration: Callable[[], float]
    """Gives the largest acceleration of a body by the resultant of the residual, m/s2; collective,
    and used only where the residual itself is small."""


class ResidualTolerance(NamedTuple):
    """Residuals that count as zero.

    Attributes:
        norm: Euclidean norm, N.
        acceleration: What the resultant gives a body, m/s2.
        round_off: Norm that may be round-off where it no longer falls, N.
    """

    norm: float
    acceleration: float
    round_off: float

    @classmethod
    def of_norm(cls, norm: float) -> ResidualTolerance:
        """By the norm (N) alone."""
        return cls(norm, math.inf, norm)


class IterationTolerances(NamedTuple):
    """Tolerances of an iteration.

    Attributes:
        residual: Of a residual itself.
        relative: Norm of a residual over that of the first one.
        correction: Norm of a correction over that of the unknowns.
    """

    residual: ResidualTolerance
    relative: float
    correction: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Convergence:
    """The rules by which an iteration ends."""

    round_offs: float = 15.0
    """A residual below this many estimates of round-off that no longer falls is round-off and is
    accepted; found with the blocks of the verification tests, where the round-off of stiff stresses
    exceeds its estimate by less than that."""
    stagnation: float = 0.9
    """A residual no longer falls where it stays above this part of the one before; found with a
    rigid block on a light stiff one, whose residual fell slowly, but fell, and was taken for
    round-off."""
    expected: float = 0.3
    """After several corrections the last one has to be expected to leave no more than this part
    of the absolute tolerance, by the rate at which the one before it shrank the residual. That rate
    mostly overstates what is left, four times in the median in the demo; and unlike the residual
    itself it is far above round-off, so that one and several ranks take the same number of
    corrections, and their histories differ by no more than round-off."""
    patience: int = 30
    """Iterations that are allowed before progress is required; found with soft strips whose volume
    hardly changes (nu close to 0.5), which converge slowly, but surely, where they are strained or
    turn fast."""
    window: int = 15
    """Iterations within which the residual has to halve once patience is over; found with the same
    strips, beside which iterations that went to and fro never converged, and a shorter step did."""
    most: int = 300
    """Iterations at most, the limit that SNES itself is given; found with the same strips."""
    growth: float = 1e8
    """A residual that has grown to this many times the first residual, the contact forces and the
    tolerance does not fall again; found with a diverging iteration whose squares of forces became
    infinite, while those that did converge grew by 140 times at most. Contact forces are a scale of
    their own because a body without stress and loads has nothing but round-off in its first
    residual when it first touches."""

    def judge(self, record: IterationRecord, tolerances: IterationTolerances) -> IterationVerdict:
        """The verdict after an iteration."""
        past, zero = record.residuals, tolerances.residual
        residual, iterations = past[-1], len(past) - 1
        if not math.isfinite(residual):
            return IterationVerdict.NOT_A_NUMBER
        if iterations == 0:
            # Forces that balance need not obey the contact law of this step: correct at least once.
            return IterationVerdict.ITERATING
        if residual <= zero.norm and self._settled(past, zero.norm):
            if record.acceleration() <= zero.acceleration:
                return IterationVerdict.SMALL_RESIDUAL
        if residual <= tolerances.relative * past[0]:
            return IterationVerdict.SMALL_RELATIVE_RESIDUAL
        if record.correction <= tolerances.correction * record.unknowns:
            return IterationVerdict.SMALL_CORRECTION
        if self._stagnates(past, zero.round_off):
            return IterationVerdict.SMALL_CORRECTION
        if residual > self.growth * max(past[0], record.forces, zero.norm):
            return IterationVerdict.GROWING
        if iterations >= self.patience and residual > 0.5 * past[-1 - self.window]:
            return IterationVerdict.TOO_MANY_ITERATIONS
        return IterationVerdict.ITERATING

    def _settled(self, past: Sequence[float], tolerance: float) -> bool:
        """True if the last correction was expected to leave so little."""
        if len(past) == 2:
            # One correction tells no rate; bodies that do not turn need no more than one.
            return True
        rate = past[-2] / past[-3] if past[-3] else 0.0
        return past[-2] * rate <= self.expected * tolerance

    def _stagnates(self, past: Sequence[float], round_off: float) -> bool:
        """True if round-off keeps the residual from falling any further."""
        if len(past) == 2:
            return False
        return past[-1] > self.stagnation * past[-2] and past[-1] < self.round_offs * round_off
