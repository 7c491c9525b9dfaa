"""The closed form of a local problem of one point without cohesion: open, sticking, or slipping."""

from __future__ import annotations

import math

import numpy as np

from solver.law.compiled import compiled
from solver.law.friction import BOUND_ROUND_OFF, at_bound, radius
from solver.law.newton import OPEN, SLIP, STICK, Local
from solver.types import Array, Indices

#: Halvings of the interval of the shift of a slipping point.
HALVINGS = 200


@compiled
def one_point(local: Local) -> Array:
    """The force at the only point, (3,).

    Slipping forces solve (S + lambda I) f_t = -p, lambda >= 0, with S and p what W and q leave of
    the tangential rows when y_n = 0; |f_t| less the radius has one sign at lambda = 0, the other
    far off, and is halved down.
    """
    d, W, q, f, S, p = local.d, local.W, local.q, np.zeros(3), np.eye(2), np.zeros(2)
    if q[0] >= 0:
        return f
    for a in range(d - 1):
        p[a] = q[a + 1] - W[a + 1, 0] * q[0] / W[0, 0]
        for b in range(d - 1):
            S[a, b] = W[a + 1, b + 1] - W[a + 1, 0] * W[0, b + 1] / W[0, 0]
    low, high, shift = 0.0, np.inf, 0.0
    for _ in range(HALVINGS):
        determinant = (S[0, 0] + shift) * (S[1, 1] + shift) - S[0, 1] * S[1, 0]
        f[0] = -q[0] / W[0, 0]
        f[1] = (S[0, 1] * p[1] - (S[1, 1] + shift) * p[0]) / determinant
        f[2] = (S[1, 0] * p[0] - (S[0, 0] + shift) * p[1]) / determinant
        for k in range(1, d):
            f[0] -= W[0, k] * f[k] / W[0, 0]
        inside = f[0] > 0 and math.hypot(f[1], f[2]) <= radius(local.bounds, 0, f[0])
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
def settle_one_point(local: Local, f: Array, states: Indices) -> bool:
    """Write force and state of the only point; False where the closed form does not hold."""
    found = one_point(local)
    size = math.hypot(found[1], found[2])
    limit = radius(local.bounds, 0, found[0]) * (1.0 + BOUND_ROUND_OFF)
    if not (found[0] >= 0.0 and size <= limit):
        return False
    f[:] = found[: local.d]
    states[0] = OPEN
    if found[0] > 0.0:
        slip = -SLIP if local.d == 2 and found[1] < 0.0 else SLIP
        states[0] = slip if at_bound(local.bounds, 0, found[0], size) else STICK
    return True
