"""Discs of friction: how much tangential force points hold at a normal force."""

from __future__ import annotations

from typing import NamedTuple

from solver.law.compiled import compiled
from solver.types import Array

#: Cohesion over the force from which on all of it acts, where all at once has no solution.
TOUCHING_SLOPE = 1e4


class Discs(NamedTuple):
    """Friction of m points: |f_t| <= mu f_n + min(c, s f_n)."""

    mu: Array
    """Coefficients of friction, (m,)."""
    cohesion: Array
    """c, N, (m,)."""
    slope: float
    """s, how cohesion grows with the force at first; infinite: all of it acts wherever f_n > 0."""


@compiled
def line(discs: Discs, i: int, normal: float) -> tuple[float, float]:
    """Slope and intercept of the radius of disc i at a normal force > 0."""
    if discs.slope * normal < discs.cohesion[i]:
        return discs.mu[i] + discs.slope, 0.0
    return discs.mu[i], discs.cohesion[i]


@compiled
def radius(discs: Discs, i: int, normal: float) -> float:
    """Radius of disc i, N; 0 at an open point."""
    if normal <= 0:
        return 0.0
    slope, intercept = line(discs, i, normal)
    return slope * normal + intercept
