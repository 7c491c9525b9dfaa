"""All intervals of amplitude in which a pulse overturns a block, by scanning and bisection."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Self

from scipy.optimize import minimize_scalar

STAYS, DIRECTLY, LATER = "stays", "overturns without impact", "overturns after an impact"
"""Fates of a block under a pulse."""

WIDEST = 0.4
"""Part of the rigid block's threshold beyond which no boundary of another engine is sought."""

NARROW = 2e-3
"""Relative width of the narrowest interval that is sought between two numbers of impacts."""


def fate_of(*, overturns: bool, impacts: int) -> str:
    """The fate of a block in words, by its impacts before it overturns."""
    return (LATER if impacts else DIRECTLY) if overturns else STAYS


@dataclass(frozen=True, slots=True)
class Response:
    """Fate of a block under one pulse."""

    overturns: bool
    impacts: int
    """Impacts before the block overturns, or all of them up to where its fate is certain."""
    margin: float
    """Positive where it overturns, negative where not; continuous in the amplitude as far as known:
    energy beyond that over the corner, over that which it takes to get there from upright."""

    @classmethod
    def of(cls, overturns: bool, impacts: int, margin: float) -> Self:
        """The response whose margin has this size; 1 where that is not known."""
        size = abs(margin) or 1.0
        return cls(overturns, impacts, size if overturns else -size)

    @property
    def label(self) -> str:
        """The fate in words."""
        return fate_of(overturns=self.overturns, impacts=self.impacts)


Respond = Callable[[float], Response]
"""Response to a pulse of an amplitude."""


@dataclass(frozen=True, slots=True)
class Boundary:
    """An amplitude at which the fate of the block changes."""

    amplitude: float
    below: str
    """Label of the responses below."""
    above: str


def boundaries(respond: Respond, amplitudes: Sequence[float], tolerance: float) -> list[Boundary]:
    """All amplitudes at which the fate changes, as far as a scan finds them.

    Between two neighbours of one fate another one may hide. Where the margin has an extremum
    towards zero among the samples, that extremum is sought.

    Args:
        respond: Runs a pulse.
        amplitudes: Of the scan, increasing.
        tolerance: Relative, of amplitudes.
    """
    found = [(amplitude, respond(amplitude)) for amplitude in amplitudes]
    hidden = [
        sample
        for three in zip(found, found[1:], found[2:], strict=False)
        if _turns_towards_zero([response for _, response in three])
        for sample in _extremum(respond, *three, tolerance)
    ]
    samples = sorted(found + hidden, key=lambda sample: sample[0])
    return [
        boundary
        for low, high in pairwise(samples)
        for boundary in _between(respond, low, high, tolerance)
    ]


Sample = tuple[float, Response]


def _turns_towards_zero(three: Sequence[Response]) -> bool:
    """True if the middle of three responses of one fate is the nearest to the other fate."""
    if len({response.overturns for response in three}) > 1:
        return False
    first, middle, last = (abs(response.margin) for response in three)
    return middle <= min(first, last) and middle < 1


def _extremum(
    respond: Respond, low: Sample, middle: Sample, high: Sample, tolerance: float
) -> list[Sample]:
    """Samples towards the least |margin| between three."""
    tried = list[Sample]()

    def size(amplitude: float) -> float:
        tried.append((amplitude, respond(amplitude)))
        return abs(tried[-1][1].margin)

    ends, near_enough = (low[0], high[0]), 10 * tolerance * middle[0]
    minimize_scalar(size, bounds=ends, options={"maxiter": 12, "xatol": near_enough})
    return tried


def _between(respond: Respond, low: Sample, high: Sample, tolerance: float) -> list[Boundary]:
    """Boundaries between two samples, as far as their fates or numbers of impacts show any.

    By bisection. Two numbers of impacts may have a narrow interval between them in which the block
    stays.
    """
    while _differ(low, high) and high[0] - low[0] > _width(low, high, tolerance) * high[0]:
        at = 0.5 * (low[0] + high[0])
        sample = at, respond(at)
        if not _differ(low, sample):
            low = sample
        elif not _differ(sample, high):
            high = sample
        else:
            return [
                *_between(respond, low, sample, tolerance),
                *_between(respond, sample, high, tolerance),
            ]
    if low[1].label == high[1].label:
        return []
    return [Boundary(0.5 * (low[0] + high[0]), low[1].label, high[1].label)]


def _differ(low: Sample, high: Sample) -> bool:
    """True if two samples have different fates, or overturn after different numbers of impacts."""
    both = low[1].overturns and high[1].overturns
    return low[1].label != high[1].label or (both and low[1].impacts != high[1].impacts)


def _width(low: Sample, high: Sample, tolerance: float) -> float:
    """Relative width down to which two samples that differ are drawn together."""
    return tolerance if low[1].label != high[1].label else max(tolerance, NARROW)


def near(
    fate: Callable[[float], str], rigid: float, below: str, above: str, tolerance: float
) -> tuple[float, float] | None:
    """The two amplitudes between which the fate changes next to a rigid block's boundary.

    Args:
        fate: What comes of an amplitude, in the words of boundaries.
        rigid: The boundary of a rigid block.
        below: What comes of it below the boundary.
        above: What comes of it above.
        tolerance: Relative, of the distance between both; twice as far from the rigid block's
            boundary are the first two that are tried.

    Returns:
        The lower and the higher one; None where none is found within `WIDEST`.
    """
    part, low, high = 2 * tolerance, rigid, rigid
    while part < WIDEST:
        if low == rigid and fate(rigid * (1 - part)) == below:
            low = rigid * (1 - part)
        if high == rigid and fate(rigid * (1 + part)) == above:
            high = rigid * (1 + part)
        if low < rigid < high:
            break
        part *= 2
    else:
        return None
    while high - low > tolerance * rigid:
        middle = 0.5 * (low + high)
        found = fate(middle)
        if found not in (below, above):  # another boundary lies between
            return None
        low, high = (low, middle) if found == above else (middle, high)
    return low, high
