"""Gauss-Seidel sweeps for the local problem of `space_friction`, compiled."""

from __future__ import annotations

import math

import numpy as np

from solver.law.compiled import compiled
from solver.law.discs import Discs, radius
from solver.types import Array


@compiled
def one_point(W: Array, q: Array, discs: Discs, i: int) -> Array:
    """The force (3,) at point i alone, exactly: open, sticking, or slipping.

    Slipping forces solve (S + lambda I) f_t = -p, lambda >= 0, with S and p what W and q leave of
    the tangential rows when y_n = 0; |f_t| less the radius has one sign at lambda = 0, the other
    far off, and is halved down.
    """
    f = np.zeros(3)
    if q[0] >= 0:
        return f
    s00 = W[1, 1] - W[1, 0] * W[0, 1] / W[0, 0]
    s01 = W[1, 2] - W[1, 0] * W[0, 2] / W[0, 0]
    s10 = W[2, 1] - W[2, 0] * W[0, 1] / W[0, 0]
    s11 = W[2, 2] - W[2, 0] * W[0, 2] / W[0, 0]
    p0, p1 = q[1] - W[1, 0] * q[0] / W[0, 0], q[2] - W[2, 0] * q[0] / W[0, 0]
    low, high, shift = 0.0, np.inf, 0.0
    for _ in range(200):
        a, d = s00 + shift, s11 + shift
        determinant = a * d - s01 * s10
        f[1], f[2] = (s01 * p1 - d * p0) / determinant, (s10 * p0 - a * p1) / determinant
        f[0] = -(q[0] + W[0, 1] * f[1] + W[0, 2] * f[2]) / W[0, 0]
        inside = f[0] > 0 and math.hypot(f[1], f[2]) <= radius(discs, i, f[0])
        if inside:
            high = shift
        else:
            low = shift
        if inside and (shift == 0.0 or high - low <= 1e-15 * high):
            break
        shift = 4 * shift + s00 + s11 if high == np.inf else 0.5 * (low + high)
        if shift in (low, high):
            break
    return f


@compiled
def sweep(W: Array, q: Array, f: Array, discs: Discs) -> None:
    """One round of nonsmooth Gauss-Seidel on f in place."""
    for i in range(len(discs.mu)):
        n = 3 * i
        own = W[n : n + 3, n : n + 3]
        free = q[n : n + 3].copy()
        for k in range(3):
            for j in range(len(f)):
                if j < n or j > n + 2:
                    free[k] += W[n + k, j] * f[j]
        f[n : n + 3] = one_point(own, free, discs, i)


@compiled
def project(W: Array, q: Array, f: Array, discs: Discs, factor: float) -> None:
    """One round of projected Gauss-Seidel on f in place: normal forces, then tangential ones.

    Args:
        W: Compliance.
        q: Free values.
        f: Forces.
        discs: Friction.
        factor: Of relaxation.
    """
    for n in range(0, len(f), 3):
        y = q[n] + np.sum(W[n] * f)
        f[n] = max(0.0, f[n] - factor * y / W[n, n])
    for i in range(len(discs.mu)):
        s, t = 3 * i + 1, 3 * i + 2
        rate = factor / (W[s, s] + W[t, t])
        first = f[s] - rate * (q[s] + np.sum(W[s] * f))
        second = f[t] - rate * (q[t] + np.sum(W[t] * f))
        size, limit = math.hypot(first, second), radius(discs, i, f[3 * i])
        share = 1.0 if size <= limit else limit / size
        f[s], f[t] = share * first, share * second
