"""Newton's method for the local problem, on the natural map in units of force.

Unknown are the forces f = (normal, tangential) of m points, d numbers each, with

    y = q + W f,   0 <= f_n  complementary to  y_n >= 0,
    |f_t| <= mu f_n + min(c, s f_n),   y_t opposite to f_t where |f_t| is at its bound, 0 elsewhere,

and f_t = 0 where f_n = 0: cohesion needs contact. They are the root of f - P(f - r y), with P the
projection on the admissible forces: normal part first, then the disc, which is an interval for
d = 2 and absent for d = 1. The method is that of Alart and Curnier (1991). For d <= 2 it is the
active-set method: the state of each point, by f - r y, decides its forces, and the states are right
when they repeat themselves.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from solver.law.compiled import compiled
from solver.law.friction import Bounds, line
from solver.types import Array, Indices

#: States of a point. For d = 2 those of slip carry the sign of the friction force.
OPEN, STICK, SLIP, SLIP_TOUCHING = 0, 1, 2, 3

#: Error of a force that ends the iteration, relative to the largest of its point.
TOLERANCE = 1e-12
#: The same relative to the largest force and to the largest r y of all points.
ROUND_OFF = 64 * 2.0**-52
#: Part of these errors that no further step makes smaller.
EXACT = 0.02


#: Most rows of what is done by loops: a call of BLAS or LAPACK takes longer than these sums.
FEW = 24


class Local(NamedTuple):
    """A local problem."""

    d: int
    """Rows of a point: 3 in space, 2 in the plane, 1 without friction."""
    W: Array
    """Compliance, (d m, d m), m/N; rows of a point side by side, normal first."""
    q: Array
    """Free values, (d m,), m."""
    bounds: Bounds
    """Friction."""


@compiled
def product(matrix: Array, vector: Array) -> Array:
    """The product of a square matrix and a vector."""
    size = len(vector)
    if size > FEW:
        return matrix @ vector
    found = np.empty(size)
    for i in range(size):
        total = 0.0
        for k in range(size):
            total += matrix[i, k] * vector[k]
        found[i] = total
    return found


@compiled
def solve_dense(matrix: Array, right: Array) -> bool:
    """Solve a linear system, `right` becoming the solution; False where it is singular.

    The matrix is used up.
    """
    if len(right) > FEW:
        return _solve_by_lapack(matrix, right)
    for k in range(len(right)):
        if not _eliminate(matrix, right, k):
            return False
    for k in range(len(right) - 1, -1, -1):
        for j in range(k + 1, len(right)):
            right[k] -= matrix[k, j] * right[j]
        right[k] /= matrix[k, k]
        if not abs(right[k]) < np.inf:
            return False
    return True


@compiled
def _solve_by_lapack(matrix: Array, right: Array) -> bool:
    """As `solve_dense`, for many rows."""
    try:
        right[:] = np.linalg.solve(matrix, right)
    except Exception:  # LinAlgError; numba has no narrower class
        return False
    return True


@compiled
def _eliminate(matrix: Array, right: Array, k: int) -> bool:
    """Eliminate unknown k from the rows below, by the largest pivot; False where there is none."""
    size, pivot = len(right), k
    for i in range(k + 1, size):
        if abs(matrix[i, k]) > abs(matrix[pivot, k]):
            pivot = i
    if not 0.0 < abs(matrix[pivot, k]) < np.inf:
        return False
    if pivot != k:
        for j in range(k, size):
            matrix[k, j], matrix[pivot, j] = matrix[pivot, j], matrix[k, j]
        right[k], right[pivot] = right[pivot], right[k]
    for i in range(k + 1, size):
        factor = matrix[i, k] / matrix[k, k]
        if factor != 0.0:
            for j in range(k + 1, size):
                matrix[i, j] -= factor * matrix[k, j]
            right[i] -= factor * right[k]
    return True


@compiled
def lengths(d: int, W: Array, shared: bool) -> Array:
    """The lengths r, normal and tangential, (m, 2): one over the diagonal of W, or over row sums.

    Points of a stiff body share its rigid modes: W is nearly of low rank, and one over its diagonal
    too large by about the number of points. Row sums are those of |W| within a direction.
    """
    m = len(W) // d
    compliance: Array = np.zeros((m, 2)) if d > 1 else np.ones((m, 2))
    for i in range(m):
        for k in range(d):  # one length for both tangential directions: a disc has no favourite
            row, way = d * i + k, min(k, 1)
            own = 0.0 if shared else W[row, row]
            for j in range(k, len(W) if shared else 0, d):
                own += abs(W[row, j])
            compliance[i, way] = own if k < 2 else max(compliance[i, way], own)
        compliance[i, 0], compliance[i, 1] = 1.0 / compliance[i, 0], 1.0 / compliance[i, 1]
    return compliance


@compiled
def trial_of(local: Local, r: Array, f: Array) -> Array:
    """F - r y, which decides the state of each point."""
    d, trial = local.d, product(local.W, f)
    for i in range(len(r)):
        for k in range(d * i, d * i + d):
            trial[k] = f[k] - r[i, min(k - d * i, 1)] * (local.q[k] + trial[k])
    return trial


@compiled
def project(local: Local, trial: Array, nearest: Array, states: Indices) -> None:
    """Write the admissible forces nearest to trial ones, and the states these stand for."""
    d, bounds = local.d, local.bounds
    nearest[:] = 0.0
    for i in range(len(states)):
        n, states[i] = d * i, OPEN
        normal = trial[n]
        if not normal > 0.0:
            continue
        nearest[n] = normal
        slope, intercept = line(bounds, i, normal)
        limit, size = slope * normal + intercept, 0.0
        for k in range(n + 1, n + d):
            size = math.hypot(size, trial[k])
        if size <= limit and limit > 0.0:
            states[i] = STICK
            for k in range(n + 1, n + d):
                nearest[k] = trial[k]
            continue
        states[i] = SLIP if intercept > 0.0 or bounds.cohesion[i] == 0.0 else SLIP_TOUCHING
        if d == 2 and trial[n + 1] < 0.0:
            states[i] = -states[i]
        for k in range(n + 1, n + d):
            nearest[k] = limit / size * trial[k] if limit > 0.0 else 0.0


@compiled
def unknowns(local: Local, states: Indices) -> Indices:
    """Rows that have to be solved for, given the states; the other forces follow from these."""
    rows, count, d = np.empty(len(local.q), np.int64), 0, local.d
    for i in range(len(states)):
        smooth = local.bounds.mu[i] == 0.0 and local.bounds.cohesion[i] == 0.0
        has_direction = states[i] == STICK or (d == 3 and not smooth)
        for k in range(0 if states[i] == OPEN else d if has_direction else 1):
            rows[count] = d * i + k
            count += 1
    return rows[:count]


@compiled
def _sliding(bounds: Bounds, trial: Array, i: int) -> tuple[float, float, float, float, float]:
    """Direction e of the friction of a point that slips in space, l/|tau|, and l = s f_n + c."""
    slope, intercept = line(bounds, i, trial[3 * i])
    size = math.hypot(trial[3 * i + 1], trial[3 * i + 2])
    share = (slope * trial[3 * i] + intercept) / size
    return trial[3 * i + 1] / size, trial[3 * i + 2] / size, share, slope, intercept


@compiled
def _slip_rows(
    bounds: Bounds, trial: Array, rows: Indices, a: int, matrix: Array, right: Array
) -> None:
    """Turn rows a and a + 1, r W and -r q of a point that slips in space, into those of slip.

    P = l e with e = tau/|tau|, of derivative e dl + (l/|tau|)(I - e e^T) dtau; I - e e^T = b b^T.
    """
    along, aside, share, slope, intercept = _sliding(bounds, trial, rows[a] // 3)
    e, b = (along, aside), (-aside, along)
    across = share * (b[0] * matrix[a] + b[1] * matrix[a + 1])
    value = share * (b[0] * right[a] + b[1] * right[a + 1])
    for k in range(2):
        matrix[a + k] = b[k] * across
        matrix[a + k, a + k] += 1.0
        matrix[a + k, a] -= share * b[k] * b[0]
        matrix[a + k, a + 1] -= share * b[k] * b[1]
        matrix[a + k, a - 1] -= slope * e[k]
        right[a + k] = e[k] * intercept + b[k] * value


@compiled
def equations(
    local: Local, r: Array, trial: Array, states: Indices, rows: Indices
) -> tuple[Array, Array]:
    """Matrix A and right-hand side b of f - P(f - r y) = 0, linearised at `trial`: A x = b.

    The unknowns x are the forces of some rows, those of `unknowns`.
    """
    d, W, size = local.d, local.W, len(rows)
    matrix, right = np.empty((size, size)), np.empty(size)
    for a in range(size):
        row = rows[a]
        # Rows r y = 0: unscaled ones beside rows of forces would lose digits.
        weight = r[row // d, min(row % d, 1)]
        right[a] = -weight * local.q[row]
        for b in range(size):
            matrix[a, b] = weight * W[row, rows[b]]
        if d == 2:
            for b in range(size):
                i = rows[b] // 2
                if rows[b] % 2 == 0 and states[i] != STICK:
                    slope, intercept = line(local.bounds, i, trial[2 * i])
                    coupling = weight * W[row, 2 * i + 1] * (1.0 if states[i] > 0 else -1.0)
                    matrix[a, b] += slope * coupling
                    right[a] -= intercept * coupling
    for a in range(size):
        if d == 3 and rows[a] % 3 == 1 and states[rows[a] // 3] != STICK:
            _slip_rows(local.bounds, trial, rows, a, matrix, right)
    return matrix, right


@compiled
def write_forces(
    local: Local,
    trial: Array,
    states: Indices,
    rows: Indices,
    x: Array,
    f: Array,
) -> None:
    """Write all forces by the unknowns x of the equations; the sliding ones follow in the plane."""
    f[:] = 0.0
    for a in range(len(rows)):
        f[rows[a]] = x[a]
    for i in range(len(states)):
        if local.d == 2 and abs(states[i]) >= SLIP:
            slope, intercept = line(local.bounds, i, trial[2 * i])
            sign = 1.0 if states[i] > 0 else -1.0
            f[2 * i + 1] = (slope * f[2 * i] + intercept) * sign


@compiled
def linearised(local: Local, r: Array, trial: Array, states: Indices, f: Array) -> bool:
    """Write the root f of f - P(f - r y), linearised at `trial`; False where there is none."""
    rows = unknowns(local, states)
    matrix, right = equations(local, r, trial, states, rows)
    if not solve_dense(matrix, right):
        return False
    write_forces(local, trial, states, rows, right, f)
    return True


@compiled
def error_of(d: int, f: Array, trial: Array, nearest: Array) -> float:
    """Difference between f and P(f - r y), 1 being what is tolerated; infinite beyond numbers."""
    noise, worst = 0.0, 0.0
    for k in range(len(f)):
        if not abs(f[k]) + abs(trial[k]) < np.inf:
            return np.inf
        noise = max(noise, abs(f[k]), abs(f[k] - trial[k]))
    for n in range(0, len(f), d):
        largest = difference = 0.0
        for k in range(n, n + d):
            largest = max(largest, abs(f[k]))
            difference = max(difference, abs(f[k] - nearest[k]))
        if difference > 0.0:
            worst = max(worst, difference / (TOLERANCE * largest + ROUND_OFF * noise))
    return worst


@compiled
def best_step(local: Local, r: Array, f: Array, target: Array, halvings: int) -> float:
    """The part of the way from f to its target that lowers |f - P(f - r y)| enough, else most."""
    nearest, states = np.empty_like(f), np.empty(len(r), np.int64)
    step, best, least, before = 1.0, 1.0, np.inf, np.inf
    for k in range(halvings + 2):
        force = f if k == 0 else f + step * (target - f)
        project(local, trial_of(local, r, force), nearest, states)
        left = float(np.linalg.norm(force - nearest))
        if k == 0:
            before = left
            continue
        if left < least:
            least, best = left, step
        if left <= (1.0 - 0.1 * step) * before:
            return step
        step *= 0.5
    return best


@compiled
def _alike(states: Indices, others: Indices) -> bool:
    """True if all points are in the same states."""
    for i in range(len(states)):
        if states[i] != others[i]:
            return False
    return True


@compiled
def newton(local: Local, r: Array, f: Array, states: Indices, rounds: int, halvings: int) -> bool:
    """Newton's method from f; whether it settled. If so f is the solution, else it stays as it is.

    `rounds` is the most linear solves, `halvings` how often the line search may halve a step; with
    0 steps are full.
    """
    nearest, force, trial = np.empty_like(f), f, trial_of(local, r, f)
    project(local, trial, nearest, states)
    error = error_of(local.d, f, trial, nearest)
    if error <= EXACT:
        return True
    target, before, seen = np.empty_like(f), np.empty_like(states), np.full_like(states, -9)
    for k in range(rounds):
        if not linearised(local, r, trial, states, target):
            return False
        step = 1.0 if halvings == 0 else best_step(local, r, force, target, halvings)
        force = target.copy() if step == 1.0 else force + step * (target - force)
        before[:], last = states, error
        trial = trial_of(local, r, force)
        project(local, trial, nearest, states)
        error = error_of(local.d, force, trial, nearest)
        if local.d < 3 and step == 1.0 and error < np.inf and _alike(states, before):
            f[:] = force
            return True
        # Forces that only balance each other show last: it goes on while that makes it better.
        if error <= EXACT or (error <= 1.0 and error > 0.5 * last):
            f[:] = nearest
            return True
        if local.d < 3 and halvings == 0:
            if _alike(states, seen):  # a cycle
                return False
            if k & (k + 1) == 0:
                seen[:] = states
    return False
