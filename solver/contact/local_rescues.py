"""Slower ways to the solution of a local problem: each leads a Newton method to where it settles.

They hold for two and three dimensions. None of them is proved to converge under Coulomb's law,
where the bounds depend on the solution; hence a chain of them stands behind Newton's method.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray

from solver.contact.local_system import Line, LocalSystem, frozen, limits, project
from solver.rigid.local_problem import TOUCHING_SLOPE

FLAT = 0.3
"""Of the slopes of cohesion over force that `gradual` goes through, the first."""

Array = NDArray[np.float64]
Method = Callable[[LocalSystem, Array], "Array | None"]
"""Solves a system from a start; None where it fails."""
Newton = Callable[[LocalSystem, Array, Line], "Array | None"]
"""The same under a given law of friction."""


def tresca(newton: Newton, *, rounds: int = 100) -> Method:
    """Fixed point over problems with frozen friction bounds, each polished by Newton."""

    def solve(system: LocalSystem, start: Array) -> Array | None:
        if system.bounds.frictionless:
            return None  # nothing to freeze: the same problem again
        line = system.line()
        f, bound = start, limits(line, start[:, 0])
        for k in range(rounds):
            solved = newton(system, f, frozen(bound))
            if solved is None:
                bound = 0.5 * bound
                continue
            f, target = solved, limits(line, solved[:, 0])
            found = newton(system, f, line)
            if found is not None:
                return found
            bound = target if k < 20 else 0.5 * (bound + target)
        return None

    return solve


def projected(newton: Newton, *, rounds: int = 10) -> Method:
    """Projected iteration with one step length, a Newton method after every so many rounds."""

    def solve(system: LocalSystem, start: Array) -> Array | None:
        f, line = start, system.line()
        length = 1.0 / float(np.linalg.norm(system.W.reshape(f.size, f.size), 2))
        even = system.scaled(np.full_like(f, length))
        for k in range(1, 251):
            f = project(even.trial(f), line)
            if k % rounds == 0:
                found = newton(system, f, line)
                if found is not None:
                    return found
        return None

    return solve


def continuation(newton: Newton) -> Method:
    """From the problem without friction to that with all of it."""

    def solve(system: LocalSystem, start: Array) -> Array | None:
        line = system.line()
        done, step = 0.0, 0.25
        f = newton(system, start, _part(line, 0.0))
        while f is not None and step > 1e-3:
            share = min(1.0, done + step)
            found = newton(system, f, _part(line, share))
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
            found = newton(system, f, partial(system.touching, slope=slope))
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


def _part(line: Line, share: float) -> Line:
    """A share of the friction of a law."""
    return lambda normal: (share * line(normal)[0], share * line(normal)[1])
