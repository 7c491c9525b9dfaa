"""The contact problem of a few points of rigid bodies, compiled.

Unknown are the forces f = (f_n, f_t) of m points, flat: normal 2 i, tangential 2 i + 1, with

    y = q + W f,  0 <= f_n  complementary to  y_n >= 0,  |f_t| <= c + mu f_n,  y_t opposite to f_t.

A semismooth Newton method decides the state of each point by f - r y, with r one over the ROW SUM
of |W|, as in `solver.law.local_problem`. It starts from the states that it found the last time:
where they hold, that is one small linear solve. Where it cycles follow a Tresca fixed point,
nonsmooth Gauss-Seidel and, for few points, enumeration.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from solver.law.compiled import compiled
from solver.law.discs import TOUCHING_SLOPE
from solver.types import Array, Indices

#: States of a point; slipping ones by the sign of the friction force.
OPEN, STICK, FORWARD, BACKWARD = 0, 1, 2, 3

#: What settled the problem: its place in `rescued`; 0 is Newton's method.
NEWTON, TRESCA, GAUSS_SEIDEL, ENUMERATION, TOUCHING = 0, 1, 2, 3, 4

#: A residual of the natural map below this part of the forces is round-off.
ROUND_OFF = 1e-13
#: Enumeration of 4^m states: 25 ms for the most.
ENUMERATED_POINTS = 7


class Bounds(NamedTuple):
    """Friction of m points: |f_t| <= cohesion + friction f_n."""

    friction: Array
    """mu, (m,)."""
    cohesion: Array
    """c, N, (m,)."""
    given: Indices
    """+1 or -1: f_t is the bound itself with this sign, there is no tangential row; else 0."""


@compiled
def row_sum_scaling(W: Array) -> Array:
    """R, (2 m,): one over the row sums of |W| within a direction."""
    size = len(W)
    scaling = np.empty(size)
    for i in range(size):
        total = 0.0
        for j in range(i % 2, size, 2):
            total += abs(W[i, j])
        scaling[i] = 1.0 / total
    return scaling


@compiled
def image(W: Array, q: Array, f: Array) -> Array:
    """Y = q + W f."""
    return q + W @ f


@compiled
def decide(f: Array, y: Array, scaling: Array, bounds: Bounds, states: Indices) -> float:
    """Write the states by f - r y; returns the largest part of the natural map's residual."""
    worst = 0.0
    for i in range(len(states)):
        n, t = 2 * i, 2 * i + 1
        normal = f[n] - scaling[n] * y[n]
        if normal <= 0.0:
            states[i] = OPEN
            worst = max(worst, abs(f[n]), abs(f[t]))
            continue
        worst = max(worst, abs(scaling[n] * y[n]))
        given = bounds.given[i]
        if given != 0:
            states[i] = FORWARD if given > 0 else BACKWARD
            continue
        tangential = f[t] - scaling[t] * y[t]
        limit = bounds.cohesion[i] + bounds.friction[i] * normal
        if abs(tangential) <= limit:
            states[i] = STICK
            worst = max(worst, abs(scaling[t] * y[t]))
        elif tangential > 0.0:
            states[i] = FORWARD
            worst = max(worst, abs(f[t] - limit))
        else:
            states[i] = BACKWARD
            worst = max(worst, abs(f[t] + limit))
    return worst


@compiled
def solve_dense(A: Array, b: Array, size: int) -> bool:
    """Gauss elimination with partial pivoting, in place; the solution is left in b."""
    for k in range(size):
        pivot, largest = k, abs(A[k, k])
        for i in range(k + 1, size):
            if abs(A[i, k]) > largest:
                pivot, largest = i, abs(A[i, k])
        if not largest > 0.0:
            return False
        if pivot != k:
            for j in range(k, size):
                A[k, j], A[pivot, j] = A[pivot, j], A[k, j]
            b[k], b[pivot] = b[pivot], b[k]
        for i in range(k + 1, size):
            factor = A[i, k] / A[k, k]
            if factor != 0.0:
                for j in range(k + 1, size):
                    A[i, j] -= factor * A[k, j]
                b[i] -= factor * b[k]
    for k in range(size - 1, -1, -1):
        total = b[k]
        for j in range(k + 1, size):
            total -= A[k, j] * b[j]
        b[k] = total / A[k, k]
    return True


@compiled
def forces(W: Array, q: Array, bounds: Bounds, states: Indices, f: Array) -> bool:
    """Forces of given states: y_n = 0 where closed, y_t = 0 where stuck; False where singular."""
    unknown = np.empty(len(q), np.int64)
    size = 0
    for i in range(len(states)):
        if states[i] != OPEN:
            unknown[size] = 2 * i
            size += 1
        if states[i] == STICK:
            unknown[size] = 2 * i + 1
            size += 1
    A, b = np.empty((size, size)), np.empty(size)
    for r in range(size):
        row = unknown[r]
        b[r] = -q[row]
        for s in range(size):
            column = unknown[s]
            A[r, s] = W[row, column]
            i = column // 2
            if column % 2 == 0 and states[i] >= FORWARD:
                sign = 1.0 if states[i] == FORWARD else -1.0
                A[r, s] += sign * bounds.friction[i] * W[row, column + 1]
                b[r] -= sign * bounds.cohesion[i] * W[row, column + 1]
    if not solve_dense(A, b, size):
        return False
    f[:] = 0.0
    for r in range(size):
        f[unknown[r]] = b[r]
    for i in range(len(states)):
        if states[i] >= FORWARD:
            sign = 1.0 if states[i] == FORWARD else -1.0
            f[2 * i + 1] = sign * (bounds.cohesion[i] + bounds.friction[i] * f[2 * i])
    return True


@compiled
def newton(W: Array, q: Array, scaling: Array, bounds: Bounds, states: Indices, f: Array) -> bool:
    """Active-set iteration from `states`; False where the states come back without settling."""
    count = len(states)
    following = np.empty(count, np.int64)
    seen = np.empty((20 + 4 * count, count), np.int64)
    for k in range(len(seen)):
        for j in range(k):
            if np.array_equal(seen[j], states):
                return False
        seen[k] = states
        if not forces(W, q, bounds, states, f):
            return False
        residual = decide(f, image(W, q, f), scaling, bounds, following)
        if residual <= ROUND_OFF * max(np.abs(f).max(), np.abs(scaling * q).max()):
            return True
        if np.array_equal(following, states):
            return True
        states[:] = following
    return False


@compiled
def tresca(W: Array, q: Array, scaling: Array, bounds: Bounds, states: Indices, f: Array) -> bool:
    """Fixed point over problems with frozen friction bounds, each polished by Newton."""
    count = len(states)
    none = np.zeros(count)
    start = f.copy()
    bound = bounds.cohesion + bounds.friction * np.maximum(start[::2], 0.0)
    for k in range(100):
        frozen = Bounds(none, bound, bounds.given)
        decide(start, image(W, q, start), scaling, frozen, states)
        if not newton(W, q, scaling, frozen, states, f):
            bound = 0.5 * bound
            continue
        start[:] = f
        if newton(W, q, scaling, bounds, states, f):
            return True
        target = bounds.cohesion + bounds.friction * np.maximum(start[::2], 0.0)
        bound = target if k < 20 else 0.5 * (bound + target)
    return False


@compiled
def one_point(W: Array, q: Array, f: Array, bounds: Bounds, i: int) -> None:
    """The exact force at point i, where those of the others stand."""
    n, t = 2 * i, 2 * i + 1
    nn, nt, tn, tt = W[n, n], W[n, t], W[t, n], W[t, t]
    free_n = q[n] + W[n] @ f - nn * f[n] - nt * f[t]
    free_t = q[t] + W[t] @ f - tn * f[n] - tt * f[t]
    mu, c, given = bounds.friction[i], bounds.cohesion[i], bounds.given[i]
    f[n], f[t] = 0.0, 0.0
    if given == 0:
        if free_n >= 0.0:
            return
        determinant = nn * tt - nt * tn
        normal = (nt * free_t - tt * free_n) / determinant
        tangential = (tn * free_n - nn * free_t) / determinant
        if normal > 0.0 and abs(tangential) <= c + mu * normal:
            f[n], f[t] = normal, tangential
            return
    for sign in (1.0, -1.0):
        if given * sign < 0:
            continue
        normal = -(free_n + sign * c * nt) / (nn + sign * mu * nt)
        slip = free_t + tn * normal + tt * sign * (c + mu * normal)
        if normal > 0.0 and (given != 0 or sign * slip <= 0.0):
            f[n], f[t] = normal, sign * (c + mu * normal)
            return


@compiled
def gauss_seidel(
    W: Array, q: Array, scaling: Array, bounds: Bounds, states: Indices, f: Array
) -> bool:
    """Nonsmooth Gauss-Seidel, each point solved exactly, Newton every ten sweeps."""
    for sweep in range(1, 501):
        before = f.copy()
        for i in range(len(states)):
            one_point(W, q, f, bounds, i)
        residual = decide(f, image(W, q, f), scaling, bounds, states)
        if residual <= ROUND_OFF * np.abs(f).max():
            return True
        if np.abs(f - before).max() == 0.0:  # by round-off, or where a point has no solution
            return bool(residual <= 1e-9 * max(np.abs(f).max(), np.abs(scaling * q).max()))
        if sweep % 10 == 0:
            before[:] = f
            if newton(W, q, scaling, bounds, states, f):
                return True
            f[:] = before
    return False


@compiled
def enumeration(
    W: Array, q: Array, scaling: Array, bounds: Bounds, states: Indices, f: Array
) -> bool:
    """Try every state of every point, for as few points as that is bearable."""
    count = len(states)
    if count > ENUMERATED_POINTS:
        return False
    following = np.empty(count, np.int64)
    for choice in range(4**count):
        rest = choice
        for i in range(count):
            states[i] = rest % 4
            rest //= 4
        if forces(W, q, bounds, states, f):
            decide(f, image(W, q, f), scaling, bounds, following)
            if np.array_equal(following, states):
                return True
    return False


@compiled
def touching(W: Array, q: Array, scaling: Array, bounds: Bounds, states: Indices, f: Array) -> bool:
    """Cohesion that grows over the first 1e-4 of pressure: all at once it may lift its own point.

    Where it grows it is friction, mu + 1e4; which points have all of it is found by trial.
    """
    count = len(states)
    friction, cohesion = bounds.friction.copy(), bounds.cohesion.copy()
    line = Bounds(friction, cohesion, bounds.given)
    guess = f.copy()
    grows = (bounds.cohesion > 0.0) & (bounds.given == 0)
    for _ in range(10 + 4 * count):
        for i in range(count):
            friction[i] = bounds.friction[i] + (TOUCHING_SLOPE if grows[i] else 0.0)
            cohesion[i] = 0.0 if grows[i] else bounds.cohesion[i]
        f[:] = guess
        if not newton(W, q, scaling, line, states, f):
            f[:] = guess
            if not gauss_seidel(W, q, scaling, line, states, f):
                return False
        fits = True
        for i in range(count):
            should = TOUCHING_SLOPE * f[2 * i] < bounds.cohesion[i]
            if bounds.given[i] == 0 and should != grows[i]:
                grows[i], fits = should, False
        if fits:
            return True
    return False


@compiled
def solve(W: Array, q: Array, bounds: Bounds, states: Indices, f: Array, rescued: Indices) -> bool:
    """Solve for the forces; False where every method failed.

    Args:
        W: Compliance, (2 m, 2 m).
        q: Free values, (2 m,).
        bounds: Friction.
        states: Of the last solution; left as those of this one.
        f: A guess; left as the solution, (2 m,).
        rescued: Counts which method settled it, (5,).
    """
    scaling = row_sum_scaling(W)
    guess = f.copy()
    if newton(W, q, scaling, bounds, states, f):
        rescued[NEWTON] += 1
        return True
    f[:] = guess
    if tresca(W, q, scaling, bounds, states, f):
        rescued[TRESCA] += 1
        return True
    f[:] = guess
    if gauss_seidel(W, q, scaling, bounds, states, f):
        rescued[GAUSS_SEIDEL] += 1
        return True
    if enumeration(W, q, scaling, bounds, states, f):
        rescued[ENUMERATION] += 1
        return True
    f[:] = guess
    if bounds.cohesion.max() > 0.0 and touching(W, q, scaling, bounds, states, f):
        rescued[TOUCHING] += 1
        return True
    return False
