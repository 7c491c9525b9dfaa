"""Signorini and Coulomb with a friction disc at the few contact points of rigid blocks, compiled.

Unknown are the forces f = (normal, two tangential) of m points with

    y = q + W f,   0 <= f_n  complementary to  y_n >= 0,   |f_t| <= c + mu f_n, y_t opposite to f_t,

the disc being open (no force, no cohesion) where f_n = 0. Newton's method of Alart and Curnier
(1991) works on the natural map in units of force,

    phi_n = f_n - [f_n - r_n y_n]_+,        phi_t = f_t - projection of f_t - r_t y_t on the disc,

with full steps: a line search on |phi| stops it four times as often. Four corners of one block are
12 rows on 6 unknowns, so the caller adds a small diagonal to W. Started from nothing on random
loads near the limits of friction, Newton settles 94 of 100. The others start again from the forces
of polygons instead of discs (`solver.law.lemke`), which bodies of very different masses need; then
follow Newton with a proximal term, and projected or nonsmooth Gauss-Seidel sweeps.

Vectors have 3 m entries, those of a point side by side.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from solver.law.compiled import compiled
from solver.law.discs import TOUCHING_SLOPE, Discs, line
from solver.law.lemke import polygonal
from solver.law.space_sweeps import project, sweep
from solver.types import Array, Indices

TOLERANCE = 1e-10
"""Of phi, relative to the largest force."""

UNSETTLED, NEWTON, POLYGONS, PROXIMAL, SWEEPS, TOUCHING = 0, 1, 2, 3, 4, 5
"""What settled a local problem: `TOUCHING` is cohesion that grows over the first forces."""

LOOSE = 1e-8
"""The same when all else has failed: forces that balance each other within a body, which the added
diagonal alone decides, are then still on their way, and move nothing."""


class Patience(NamedTuple):
    """Of Newton's method; errors are relative to the largest force."""

    steps: int
    """The most there are."""
    enough: float
    """Error that ends it."""
    good: float
    """Error that will do after the last step."""


@compiled
def natural_map(y: Array, f: Array, discs: Discs, rate: Array, phi: Array) -> None:
    """Fill in phi."""
    for i in range(len(discs.mu)):
        n = 3 * i
        normal = f[n] - rate[i, 0] * y[n]
        if normal <= 0:
            phi[n : n + 3] = f[n : n + 3]
            continue
        phi[n] = rate[i, 0] * y[n]
        first, second = f[n + 1] - rate[i, 1] * y[n + 1], f[n + 2] - rate[i, 1] * y[n + 2]
        slope, intercept = line(discs, i, normal)
        size, limit = math.hypot(first, second), slope * normal + intercept
        share = 1.0 if size <= limit else limit / size
        phi[n + 1], phi[n + 2] = f[n + 1] - share * first, f[n + 2] - share * second


@compiled
def _tangent(W: Array, y: Array, f: Array, discs: Discs, rate: Array, matrix: Array) -> None:
    """Fill in a generalized derivative of phi with respect to f."""
    matrix[:, :] = 0.0
    for i in range(len(discs.mu)):
        n, s, t = 3 * i, 3 * i + 1, 3 * i + 2
        matrix[n, n], matrix[s, s], matrix[t, t] = 1.0, 1.0, 1.0
        normal = f[n] - rate[i, 0] * y[n]
        if normal <= 0:
            continue
        matrix[n] = rate[i, 0] * W[n]
        first, second = f[s] - rate[i, 1] * y[s], f[t] - rate[i, 1] * y[t]
        slope, intercept = line(discs, i, normal)
        size, limit = math.hypot(first, second), slope * normal + intercept
        if size <= limit:
            matrix[s], matrix[t] = rate[i, 1] * W[s], rate[i, 1] * W[t]
            continue
        first, second, share = first / size, second / size, limit / size
        # Of the trial: normal, and tangential across and along its direction.
        by_normal = -rate[i, 0] * W[n]
        by_normal[n] += 1.0
        by_first, by_second = -rate[i, 1] * W[s], -rate[i, 1] * W[t]
        by_first[s] += 1.0
        by_second[t] += 1.0
        across = share * (second * by_first - first * by_second)
        matrix[s] -= slope * first * by_normal + second * across
        matrix[t] -= slope * second * by_normal - first * across


@compiled
def eliminate(matrix: Array, right: Array) -> bool:
    """Solve a linear system, `right` becoming the solution; False where it is singular."""
    try:
        right[:] = np.linalg.solve(matrix, right)
    except Exception:  # LinAlgError; numba knows no narrower word
        return False
    return True


@compiled
def _closed_rows(y: Array, f: Array, rate: Array) -> Indices:
    """The rows of points whose trial force presses."""
    rows = np.empty(len(f), np.int64)
    count = 0
    for i in range(len(rate)):
        if f[3 * i] - rate[i, 0] * y[3 * i] > 0:
            for k in range(3):
                rows[count] = 3 * i + k
                count += 1
    return rows[:count]


@compiled
def _divide(matrix: Array, phi: Array, rows: Indices) -> bool:
    """Phi becomes the inverse of the matrix times phi; all but these rows are those of identity."""
    size = len(rows)
    small, right, rest = np.empty((size, size)), np.empty(size), phi.copy()
    for k in range(size):
        rest[rows[k]] = 0.0
    for k in range(size):
        row = matrix[rows[k]]
        right[k] = phi[rows[k]] - np.sum(row * rest)
        for j in range(size):
            small[k, j] = row[rows[j]]
    if not eliminate(small, right):
        return False
    for k in range(size):
        phi[rows[k]] = right[k]
    return True


@compiled
def image(W: Array, q: Array, f: Array) -> Array:
    """What the forces make of the free values: q + W f."""
    y = q.copy()
    for i in range(len(f)):
        for j in range(len(f)):
            y[i] += W[i, j] * f[j]
    return y


@compiled
def _largest(x: Array) -> float:
    """Largest absolute value."""
    found = 0.0
    for value in x:
        found = max(found, abs(value))
    return found


@compiled
def newton(W: Array, q: Array, f: Array, discs: Discs, rate: Array, patience: Patience) -> bool:
    """Alart and Curnier's Newton method with full steps, on f in place; whether it settled.

    Where it does not, f is the best that was found.

    Args:
        W: Compliance.
        q: Free values.
        f: Guess and answer.
        discs: Friction.
        rate: Lengths r of the natural map.
        patience: When to stop.
    """
    phi, matrix = np.empty_like(f), np.empty_like(W)
    best, least, now = f.copy(), np.inf, f.copy()
    for k in range(patience.steps + 1):
        y = image(W, q, now)
        natural_map(y, now, discs, rate, phi)
        error = _largest(phi) / max(_largest(now), 1e-300)
        if error < least:
            least = error
            best[:] = now
        # At least one step: forces that balance each other hardly show in the error of a guess.
        if error == 0 or (k > 0 and error <= patience.enough):
            break
        _tangent(W, y, now, discs, rate, matrix)
        if not _divide(matrix, phi, _closed_rows(y, now, rate)):
            break
        now -= phi
    f[:] = best
    return least <= patience.good


@compiled
def _strict(steps: int) -> Patience:
    """So many steps, and no looser error after the last one."""
    return Patience(steps, TOLERANCE, TOLERANCE)


@compiled
def _newton_twice(W: Array, q: Array, f: Array, discs: Discs, patience: Patience) -> bool:
    """Newton with both lengths; f stays the guess where neither settles."""
    for row_sums in (True, False):
        trial = f.copy()
        if newton(W, q, trial, discs, lengths(W, row_sums), patience):
            f[:] = trial
            return True
    return False


@compiled
def lengths(W: Array, row_sums: bool) -> Array:
    """The lengths r of each point, (m, 2): one over the diagonal of W, or over its row sums."""
    m = len(W) // 3
    rate = np.empty((m, 2))
    for i in range(m):
        n, s, t = 3 * i, 3 * i + 1, 3 * i + 2
        normal, tangential = W[n, n], 0.5 * (W[s, s] + W[t, t])
        if row_sums:
            normal = np.sum(np.abs(W[n, 0::3]))
            tangential = np.sum(np.abs(W[s, 1::3])) + np.sum(np.abs(W[t, 2::3]))
        rate[i, 0], rate[i, 1] = 1 / normal, 1 / tangential
    return rate


@compiled
def _proximal(W: Array, q: Array, f: Array, discs: Discs, softness: float) -> bool:
    """Newton with a larger diagonal on the change of the forces since the last round.

    It holds back forces that only balance each other, for which W says next to nothing.
    """
    soft, now = W.copy(), f.copy()
    diagonal = softness * np.diag(W)
    for i in range(len(f)):
        soft[i, i] += diagonal[i]
    for _ in range(20):
        if not _newton_twice(soft, q - diagonal * now, now, discs, _strict(30)):
            return False
        trial = now.copy()
        if _newton_twice(W, q, trial, discs, _strict(6)):
            f[:] = trial
            return True
    return False


@compiled
def settle(W: Array, q: Array, f: Array, mu: Array, cohesion: Array) -> int:
    """Solve the local problem, f being the guess and the answer; returns what settled it.

    All cohesion at once may lift its own point, and then there is no solution: it grows over the
    first forces instead, and `cohesion` becomes what acts.

    Args:
        W: Compliance (3 m, 3 m), m/N.
        q: Free values (3 m,), m.
        f: Forces (3 m,), N.
        mu: Coefficients of friction (m,).
        cohesion: Cohesive forces (m,), N.
    """
    guess = f.copy()
    method = settle_with(W, q, f, Discs(mu, cohesion, np.inf))
    if method != UNSETTLED or not np.any(cohesion > 0):
        return method
    f[:] = guess
    method = settle_with(W, q, f, Discs(mu, cohesion, TOUCHING_SLOPE))
    cohesion[:] = np.minimum(cohesion, TOUCHING_SLOPE * f[::3])
    return TOUCHING if method != UNSETTLED else UNSETTLED


@compiled
def settle_with(W: Array, q: Array, f: Array, discs: Discs) -> int:
    """The same with one law of friction: Newton's method, then all the slower ones."""
    if _newton_twice(W, q, f, discs, _strict(20)):
        return NEWTON
    for sides in (6, 8, 12):
        found, guess = polygonal(W, q, discs, sides)
        if not found:
            continue
        nearer = _newton_twice(W, q, guess, discs, _strict(40))
        if nearer or _proximal(W, q, guess, discs, 1e-5):
            f[:] = guess
            return POLYGONS
    for softness in (1e-5, 1e-4, 1e-6):
        if _proximal(W, q, f, discs, softness):
            return PROXIMAL
    patience, projected, swept = _strict(10), f.copy(), f.copy()
    factors = np.array([1.2, 0.5, 1.0, 1.5])
    for k in range(60):
        if k == 20:
            patience = Patience(10, TOLERANCE, LOOSE)
        if k < 20 or k % 8 < 4:
            for _ in range(5):
                project(W, q, projected, discs, factors[k % 4])
            f[:] = projected
        else:
            for _ in range(4):
                sweep(W, q, swept, discs)
            f[:] = swept
        if _newton_twice(W, q, f, discs, patience):
            return SWEEPS
    return UNSETTLED
