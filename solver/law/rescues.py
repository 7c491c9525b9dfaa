"""Slower ways to the solution of a local problem: each leads Newton's method to where it settles.

Neither is proved to converge under Coulomb's law, where the bounds depend on the solution; hence
there are two of them behind Newton's method. docs/method.md has what each of them settles.
"""

from __future__ import annotations

import numpy as np

from solver.law.compiled import compiled
from solver.law.friction import Bounds
from solver.law.newton import Local, lengths, newton
from solver.types import Array, Indices

#: Names of the methods, in the order in which they are tried.
RESCUES = ("proximal", "continuation")

#: Linear solves of Newton's method for an eased problem.
ROUNDS = 30
#: The same for the problem itself, from the solution of an eased one.
POLISHING_ROUNDS = 6
#: Halvings of a step by the line search.
HALVINGS = 12

#: Problems with a proximal term that are tried.
PROXIMAL_ROUNDS = 100
#: The first proximal term: what it adds to the diagonal of W, relative to it.
SOFTNESS = 1e-2
#: The least and the largest one.
SOFTNESSES = (1e-8, 1e4)
#: Factors of the term after a problem that was solved and after one that was not.
HARDENING, SOFTENING = 0.1, 3.0

#: Smallest part of friction by which the continuation goes on.
SMALLEST_SHARE = 1e-3


@compiled
def rescue(method: int, local: Local, f: Array, states: Indices) -> bool:
    """Solve by the method at this place in `RESCUES`; f is the guess, and the answer if settled."""
    if method == 0:
        return _by_proximal_terms(local, f, states)
    return _by_continuation(local, f, states)


@compiled
def _settles(local: Local, f: Array, states: Indices, rounds: int, searches: bool) -> bool:
    """Newton's method with either r, with full steps and then with line search if it `searches`."""
    for k in range(4 if searches else 2):
        r = lengths(local.d, local.W, k % 2 == 0)
        if newton(local, r, f, states, rounds, 0 if k < 2 else HALVINGS):
            return True
    return False


@compiled
def _by_proximal_terms(local: Local, f: Array, states: Indices) -> bool:
    """The proximal point algorithm, with a term that follows how well Newton's method does.

    The term D (f - f_last) makes the diagonal of W larger for the change of the forces since the
    last solution. It holds back forces that only balance each other, of which W says next to
    nothing: Newton's method would throw them about. As the motion settles the term can become
    smaller, and once it is near the diagonal that makes these forces unique, they settle, too.
    """
    softness, now = SOFTNESS, f.copy()
    for _ in range(PROXIMAL_ROUNDS):
        soft, added = local.W.copy(), softness * np.diag(local.W)
        for k in range(len(f)):
            soft[k, k] += added[k]
        eased = Local(local.d, soft, local.q - added * now, local.bounds)
        if _settles(eased, now, states, ROUNDS, True):
            trial = now.copy()
            if _settles(local, trial, states, POLISHING_ROUNDS, False):
                f[:] = trial
                return True
            softness = max(SOFTNESSES[0], HARDENING * softness)
        else:
            softness *= SOFTENING
            if softness > SOFTNESSES[1]:
                return False
    return False


@compiled
def _by_continuation(local: Local, f: Array, states: Indices) -> bool:
    """From the problem without friction to that with all of it."""
    bounds, done, step, share, now = local.bounds, 0.0, 0.25, 0.0, f.copy()
    while step > SMALLEST_SHARE:
        slope = bounds.slope if bounds.slope == np.inf else share * bounds.slope
        part = Bounds(share * bounds.mu, share * bounds.cohesion, slope)
        if _settles(Local(local.d, local.W, local.q, part), now, states, ROUNDS, True):
            if share == 1.0:
                f[:] = now
                return True
            done, step = share, 1.5 * step
        elif share == 0.0:
            return False
        else:
            step *= 0.5
        share = min(1.0, done + step)
    return False
