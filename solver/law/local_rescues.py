"""Slower ways to the solution of a local problem: each leads a Newton method to where it settles.

They hold for two and three dimensions. None of them is proved to converge under Coulomb's law,
where the bounds depend on the solution; hence a chain of them stands behind Newton's method.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from solver.law.discs import TOUCHING_SLOPE, Discs
from solver.law.local_system import LocalSystem, diagonal_scaling, frozen, limits, project
from solver.types import Array

FLAT = 0.3
"""Of the slopes of cohesion over force that `gradual` goes through, the first."""

Method = Callable[[LocalSystem, Array], "Array | None"]
"""Solves a system from a start; None where it fails."""
Newton = Callable[[LocalSystem, Array, Discs], "Array | None"]
"""The same under a given law of friction."""


def other_r(newton: Newton, lengths: Sequence[tuple[float, float]]) -> Method:
    """Newton's method with other r, those of the system then polish what it finds.

    The root is the same for all r, but which states are tried on the way to it is not.

    Args:
        newton: The method.
        lengths: R in the normal and the tangential directions over one over the diagonal of W.
    """

    def solve(system: LocalSystem, start: Array) -> Array | None:
        for normal, tangential in lengths:
            scaling = diagonal_scaling(system.W)
            scaling[:, 0] *= normal
            scaling[:, 1:] *= tangential
            found = newton(system.scaled(scaling), start, system.discs)
            polished = None if found is None else newton(system, found, system.discs)
            if polished is not None:
                return polished
        return None

    return solve


def tresca(newton: Newton, *, rounds: int = 100) -> Method:
    """Fixed point over problems with frozen friction bounds, each polished by Newton."""

    def solve(system: LocalSystem, start: Array) -> Array | None:
        if system.bounds.frictionless:
            return None  # nothing to freeze: the same problem again
        discs = system.discs
        f, bound = start, limits(discs, start[:, 0])
        for k in range(rounds):
            solved = newton(system, f, frozen(bound))
            if solved is None:
                bound = 0.5 * bound
                continue
            f, target = solved, limits(discs, solved[:, 0])
            found = newton(system, f, discs)
            if found is not None:
                return found
            bound = target if k < 20 else 0.5 * (bound + target)
        return None

    return solve


def projected(newton: Newton, *, rounds: int = 10) -> Method:
    """Projected iteration with one step length, a Newton method after every so many rounds."""

    def solve(system: LocalSystem, start: Array) -> Array | None:
        f, discs = start, system.discs
        length = 1.0 / float(np.linalg.norm(system.W.reshape(f.size, f.size), 2))
        even = system.scaled(np.full_like(f, length))
        for k in range(1, 251):
            f = project(even.trial(f), discs)
            if k % rounds == 0:
                found = newton(system, f, discs)
                if found is not None:
                    return found
        return None

    return solve


def continuation(newton: Newton) -> Method:
    """From the problem without friction to that with all of it."""

    def solve(system: LocalSystem, start: Array) -> Array | None:
        discs = system.discs
        done, step = 0.0, 0.25
        f = newton(system, start, _part(discs, 0.0))
        while f is not None and step > 1e-3:
            share = min(1.0, done + step)
            found = newton(system, f, _part(discs, share))
            if found is None:
                step *= 0.5
            elif share == 1.0:
                return found
            else:
                f, done, step = found, share, 1.5 * step
        return None

    return solve


def gradual(newton: Newton) -> Method:
    """From cohesion that grows slowly with the pressure to that which is there at once."""

    def solve(system: LocalSystem, start: Array) -> Array | None:
        f, done, slope, growth = start, 0.0, FLAT, 100.0
        while growth > 1.1:
            found = newton(system, f, system.touching(slope))
            if found is not None:
                if slope == TOUCHING_SLOPE:
                    return found
                f, done = found, slope
            elif done == 0.0:
                return None
            else:
                growth = math.sqrt(growth)
            slope = min(TOUCHING_SLOPE, done * growth)
        return None

    return solve


def _part(discs: Discs, share: float) -> Discs:
    """A share of the friction of a law."""
    slope = np.inf if discs.slope == np.inf else share * discs.slope
    return Discs(share * discs.mu, share * discs.cohesion, slope)
