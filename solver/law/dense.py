"""Products and solutions of small dense matrices. Compiled.

Up to a few rows they are loops: a call of BLAS or LAPACK takes longer than these sums.
"""

from __future__ import annotations

import numpy as np

from solver.law.compiled import compiled
from solver.types import Array

#: Most rows of what is done by loops.
FEW = 24


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
    except Exception:  # LinAlgError; numba knows no narrower word
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
