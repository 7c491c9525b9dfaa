"""The local problem with polygons for the discs of friction, by complementary pivoting; compiled.

With k directions d_j of friction at a point (Stewart and Trinkle 1996) and unknowns f_n, b >= 0 and
s >= 0, f_t = sum_j b_j d_j,

    0 <= y_n          complementary to  f_n >= 0,
    0 <= d_j.y_t + s  complementary to  b_j >= 0,
    0 <= c + mu f_n - sum_j b_j  complementary to  s >= 0,

is a linear complementarity problem that Lemke's method solves by pivots, wherever it starts and
however unlike the bodies are: Anitescu and Potra (1997) prove that it ends. Its answer has forces
in the right states; Newton's method with discs goes on from there.
"""

from __future__ import annotations

import math

import numpy as np

from solver.law.compiled import compiled
from solver.law.newton import Local
from solver.types import Array

PERTURBATION = 1e-6
"""Of the right-hand side, relative to its largest entry: without ties the pivots cannot cycle."""

GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
"""Multiples of it, less their whole part, are all different."""

PIVOT_ROUND_OFF = 1e-11
"""Entries of a column below this part of its largest one are round-off."""


@compiled
def _pivot(tableau: Array, row: int, column: int) -> None:
    """Make a column that of identity, with its one in this row."""
    tableau[row] /= tableau[row, column]
    for i in range(len(tableau)):
        if i != row and tableau[i, column] != 0:
            tableau[i] -= tableau[i, column] * tableau[row]


@compiled
def _leaving_row(tableau: Array, column: int) -> int:
    """The row whose variable reaches 0 first when the one of a column grows; -1 if none does."""
    entering, found, least = tableau[:, column], -1, np.inf
    smallest = PIVOT_ROUND_OFF * np.max(np.abs(entering))
    for i in range(len(tableau)):
        if entering[i] > smallest and tableau[i, -1] / entering[i] < least:
            found, least = i, tableau[i, -1] / entering[i]
    return found


@compiled
def lemke(matrix: Array, right: Array) -> tuple[bool, Array]:
    """Solve 0 <= z complementary to M z + q >= 0 (Cottle, Pang and Stone 1992, section 4.4).

    Args:
        matrix: M, (n, n).
        right: q, (n,).

    Returns:
        Whether a solution was found, and z.
    """
    n = len(right)
    answer, artificial = np.zeros(n), 2 * n
    if np.min(right) >= 0:
        return True, answer
    tableau, basis = np.zeros((n, 2 * n + 2)), np.arange(n)
    for i in range(n):
        tableau[i, i] = 1.0
        tableau[i, n : 2 * n] = -matrix[i]
    tableau[:, artificial], tableau[:, -1] = -1.0, right
    row, entering = int(np.argmin(right)), artificial
    for _ in range(20 * n):
        leaving = basis[row]
        _pivot(tableau, row, entering)
        basis[row] = entering
        if leaving == artificial:
            for i in range(n):
                if basis[i] >= n:
                    answer[basis[i] - n] = tableau[i, -1]
            return True, answer
        entering = leaving + n if leaving < n else leaving - n
        row = _leaving_row(tableau, entering)
        if row < 0:
            break
    return False, answer


@compiled
def polygonal(local: Local, sides: int) -> tuple[bool, Array]:
    """Whether there are forces (d m,) with polygons of so many sides for discs, and they.

    Args:
        local: The problem; in the plane two sides are the interval itself.
        sides: Number of directions of friction at a point.
    """
    d, m, bounds = local.d, len(local.bounds.mu), local.bounds
    forces, n = m + sides * m, m + sides * m + m
    columns, matrix, right = np.zeros((d * m, forces)), np.zeros((n, n)), np.zeros(n)
    for i in range(m):
        # Forces of each point are scaled by the root of its tangential compliance.
        scale = 1.0 / math.sqrt(local.W[d * i + 1, d * i + 1])
        columns[d * i, i] = scale
        limit = forces + i
        matrix[limit, i], right[limit] = bounds.mu[i], bounds.cohesion[i] / scale
        for j in range(sides):
            at, angle = m + sides * i + j, 2 * math.pi * j / sides
            columns[d * i + 1, at] = scale * math.cos(angle)
            if d == 3:
                columns[d * i + 2, at] = scale * math.sin(angle)
            matrix[at, limit], matrix[limit, at] = 1.0, -1.0
    matrix[:forces, :forces] += columns.T @ (local.W @ columns)
    right[:forces] = columns.T @ local.q
    size = np.max(np.abs(right))
    if size == 0:
        return True, np.zeros(d * m)
    right /= size
    for i in range(n):
        right[i] += PERTURBATION * (1.0 + (i + 1) * GOLDEN % 1.0)
    found, answer = lemke(matrix, right)
    return found, size * (columns @ answer[:forces])
