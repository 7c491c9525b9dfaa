"""Slower ways to the solution of a local problem: each leads Newton's method to where it settles.

None of them is proved to converge under Coulomb's law, where the bounds depend on the solution;
hence a chain of them stands behind Newton's method. docs/method.md has what each of them settles.
"""

from __future__ import annotations

import math

import numpy as np

from solver.law.compiled import compiled
from solver.law.friction import Bounds, radius
from solver.law.lemke import polygonal
from solver.law.newton import (
    OPEN,
    SLIP,
    STICK,
    Local,
    lengths,
    linearised,
    newton,
    project,
    trial_of,
)
from solver.types import Array, Indices

#: Names of the methods, in the order in which they are tried.
RESCUES = (
    "line search", "other r", "continuation", "proximal", "Gauss-Seidel", "enumeration", "polygons",
    "loosely",
)  # fmt: skip

#: Linear solves of Newton's method, and two more for each point.
ROUNDS = 20
#: Halvings of a step by the line search.
HALVINGS = 12
#: r of `_with_other_lengths`, normal and tangential, over one over the diagonal of W.
LENGTHS = ((1e-3, 10.0), (1e-2, 10.0), (1e-3, 0.1), (1e-3, 1.0), (0.1, 100.0), (1.0, 10.0))
#: What is added to the diagonal of W, relative to it, by the proximal term.
SOFTNESS = 1e-2
#: The same behind the polygons: they are near the solution already.
POLYGON_SOFTNESS = 1e-5
#: Error over the largest force with which a solution is accepted when all else has failed.
LOOSE = 1e-8
#: Sides of the polygons that stand for discs, one after another.
POLYGON_SIDES = (6, 8, 12)
#: Enumeration of 4^m states: 25 ms for the most points.
ENUMERATED_POINTS = 7


@compiled
def rescue(method: int, local: Local, f: Array, states: Indices) -> bool:
    """Solve by the method at this place in `RESCUES`; f is the guess and becomes the answer."""
    if method == 0:
        r = lengths(local.d, local.W, False)
        return newton(local, r, f, states, ROUNDS + len(states), HALVINGS)
    if method == 1:
        return _with_other_lengths(local, f, states)
    if method == 2:
        return _by_continuation(local, f, states)
    if method == 3:
        return _with_proximal_term(local, f, states, SOFTNESS)
    if method == 4:
        return _by_sweeps(local, f, states)
    if method == 5:
        return _by_enumeration(local, f, states)
    if method == 6:
        return _from_polygons(local, f, states)
    return _loosely(local, f, states)


@compiled
def _from_polygons(local: Local, f: Array, states: Indices) -> bool:
    """Newton's method from the solution with polygons for discs, then with a proximal term."""
    if local.d == 1:
        return False
    for sides in POLYGON_SIDES if local.d == 3 else (2, 2, 2):
        found, trial = polygonal(local, sides)
        if found and (
            _polished(local, trial, states, 2 * ROUNDS)
            or _with_proximal_term(local, trial, states, POLYGON_SOFTNESS)
        ):
            f[:] = trial
            return True
    return False


@compiled
def _approached(local: Local, guess: Array, rounds: int, best: Array, least: float) -> float:
    """Take Newton's best iterate from a guess for `best` where its error is below `least`.

    Returns:
        The error of `best`, over the largest force.
    """
    nearest, target = np.empty_like(guess), np.empty_like(guess)
    states = np.empty(len(local.bounds.mu), np.int64)
    for shared in (True, False):
        r, now = lengths(local.d, local.W, shared), guess.copy()
        for _ in range(rounds):
            trial = trial_of(local, r, now)
            project(local, trial, nearest, states)
            error = np.max(np.abs(now - nearest)) / max(np.max(np.abs(now)), 1e-300)
            if error < least:
                least = error
                best[:] = nearest
            if not linearised(local, r, trial, states, target):
                break
            now[:] = target
    return least


@compiled
def _loosely(local: Local, f: Array, states: Indices) -> bool:
    """The best of Newton's iterates, where its error is small enough.

    They start from the guess, from polygons, and from problems with a proximal term. Forces that
    balance each other within a rigid body, which only the small diagonal of W decides, may still go
    to and fro in their last digits; they move nothing.
    """
    best = f.copy()
    least = _approached(local, f, 2 * ROUNDS, best, np.inf)
    if local.d == 3:
        for sides in POLYGON_SIDES:
            least = _approached(local, polygonal(local, sides)[1], 2 * ROUNDS, best, least)
    for softness in (1e-5, 1e-4, 1e-6):
        soft, now = local.W.copy(), f.copy()
        added = softness * np.diag(soft)
        for k in range(len(f)):
            soft[k, k] += added[k]
        for _ in range(20):
            if least <= LOOSE:
                break
            eased = Local(local.d, soft, local.q - added * now, local.bounds)
            if _approached(eased, now.copy(), ROUNDS, now, np.inf) > LOOSE:
                break
            least = _approached(local, now, 6, best, least)
    f[:] = best
    nearest = np.empty_like(f)
    project(local, trial_of(local, lengths(local.d, local.W, True), f), nearest, states)
    return least <= LOOSE


@compiled
def _polished(local: Local, f: Array, states: Indices, rounds: int) -> bool:
    """Newton's method with either r, with full steps; f stays the guess where neither settles."""
    for shared in (True, False):
        trial = f.copy()
        if newton(local, lengths(local.d, local.W, shared), trial, states, rounds, 0):
            f[:] = trial
            return True
    return False


@compiled
def _with_other_lengths(local: Local, f: Array, states: Indices) -> bool:
    """Newton's method with other r; the usual ones then polish what it finds.

    The root is the same for all r, but which states are tried on the way to it is not.
    """
    usual, rounds = lengths(local.d, local.W, False), ROUNDS + len(states)
    for normal, tangential in LENGTHS:
        r, trial = usual * np.array([normal, tangential]), f.copy()
        if newton(local, r, trial, states, rounds, 0) and newton(
            local, usual, trial, states, rounds, 0
        ):
            f[:] = trial
            return True
    return False


@compiled
def _by_continuation(local: Local, f: Array, states: Indices) -> bool:
    """From the problem without friction to that with all of it, with line search."""
    bounds, r = local.bounds, lengths(local.d, local.W, True)
    done, step, share, now = 0.0, 0.25, 0.0, f.copy()
    while step > 1e-3:
        slope = bounds.slope if bounds.slope == np.inf else share * bounds.slope
        part = Bounds(share * bounds.mu, share * bounds.cohesion, slope)
        eased, trial = Local(local.d, local.W, local.q, part), now.copy()
        if newton(eased, r, trial, states, ROUNDS + 10 + len(states), HALVINGS):
            if share == 1.0:
                f[:] = trial
                return True
            now, done, step = trial, share, 1.5 * step
        elif share == 0.0:
            return False
        else:
            step *= 0.5
        share = min(1.0, done + step)
    return False


@compiled
def _with_proximal_term(local: Local, f: Array, states: Indices, softness: float) -> bool:
    """Newton's method with a larger diagonal on the change of the forces since the last round.

    It holds back forces that only balance each other, for which W says next to nothing.
    """
    soft, now = local.W.copy(), f.copy()
    added = softness * np.diag(soft)
    for k in range(len(f)):
        soft[k, k] += added[k]
    for _ in range(20):
        eased = Local(local.d, soft, local.q - added * now, local.bounds)
        if not _polished(eased, now, states, ROUNDS + 10):
            return False
        trial = now.copy()
        if _polished(local, trial, states, 6):
            f[:] = trial
            return True
    return False


@compiled
def one_point(d: int, W: Array, q: Array, bounds: Bounds, i: int) -> Array:
    """The force at point i alone, (3,), exactly: open, sticking, or slipping.

    Slipping forces solve (S + lambda I) f_t = -p, lambda >= 0, with S and p what W and q leave of
    the tangential rows when y_n = 0; |f_t| less the radius has one sign at lambda = 0, the other
    far off, and is halved down.
    """
    f, S, p = np.zeros(3), np.eye(2), np.zeros(2)
    if q[0] >= 0:
        return f
    for a in range(d - 1):
        p[a] = q[a + 1] - W[a + 1, 0] * q[0] / W[0, 0]
        for b in range(d - 1):
            S[a, b] = W[a + 1, b + 1] - W[a + 1, 0] * W[0, b + 1] / W[0, 0]
    low, high, shift = 0.0, np.inf, 0.0
    for _ in range(200):
        determinant = (S[0, 0] + shift) * (S[1, 1] + shift) - S[0, 1] * S[1, 0]
        f[0] = -q[0] / W[0, 0]
        f[1] = (S[0, 1] * p[1] - (S[1, 1] + shift) * p[0]) / determinant
        f[2] = (S[1, 0] * p[0] - (S[0, 0] + shift) * p[1]) / determinant
        for k in range(1, d):
            f[0] -= W[0, k] * f[k] / W[0, 0]
        inside = f[0] > 0 and math.hypot(f[1], f[2]) <= radius(bounds, i, f[0])
        if inside:
            high = shift
        else:
            low = shift
        if inside and (shift == 0.0 or high - low <= 1e-15 * high):
            break
        shift = 4 * shift + S[0, 0] + S[1, 1] if high == np.inf else 0.5 * (low + high)
        if shift in (low, high):
            break
    return f


@compiled
def _by_sweeps(local: Local, f: Array, states: Indices) -> bool:
    """Nonsmooth Gauss-Seidel, each point solved exactly; Newton's method after every few sweeps."""
    d, W, now = local.d, local.W, f.copy()
    for k in range(1, 201):
        for n in range(0, len(f), d):
            own, free = W[n : n + d, n : n + d], np.zeros(d)
            for a in range(d):
                free[a] = local.q[n + a] + np.sum(W[n + a] * now) - np.sum(own[a] * now[n : n + d])
            now[n : n + d] = one_point(d, own, free, local.bounds, n // d)[:d]
        if k % 5 == 0:
            f[:] = now
            if _polished(local, f, states, 10):
                return True
    return False


@compiled
def _by_enumeration(local: Local, f: Array, states: Indices) -> bool:
    """Try every state of every point, in the plane, for as few points as that is bearable."""
    m = len(states)
    if m > ENUMERATED_POINTS or local.d != 2:
        return False
    r, somewhere = lengths(2, local.W, True), np.full_like(f, np.inf)
    nearest, following = np.empty_like(f), np.empty_like(states)
    for choice in range(4**m):
        rest = choice
        for i in range(m):
            states[i] = (OPEN, STICK, SLIP, -SLIP)[rest % 4]
            rest //= 4
        if linearised(local, r, somewhere, states, f):
            project(local, trial_of(local, r, f), nearest, following)
            if np.array_equal(following, states):
                return True
    return False
