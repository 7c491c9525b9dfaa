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
def one_point(local: Local) -> tuple[float, float, float]:
    """The force at the only point, normal and two tangential, of which those not in d are 0.

    Slipping forces solve (S + lambda I) f_t = -p, lambda >= 0, with S and p what W and q leave of
    the tangential rows when y_n = 0; |f_t| less the radius has one sign at lambda = 0, the other
    far off, and is halved down.
    """
    d, W, q = local.d, local.W, local.q
    normal = first = second = 0.0
    if q[0] >= 0:
        return normal, first, second
    # S = ((a, b), (c, e)) and p = (g, h)
    a, b, c, e, g, h = 1.0, 0.0, 0.0, 1.0, 0.0, 0.0
    if d > 1:
        g = q[1] - W[1, 0] * q[0] / W[0, 0]
        a = W[1, 1] - W[1, 0] * W[0, 1] / W[0, 0]
    if d > 2:
        h = q[2] - W[2, 0] * q[0] / W[0, 0]
        b, c = W[1, 2] - W[1, 0] * W[0, 2] / W[0, 0], W[2, 1] - W[2, 0] * W[0, 1] / W[0, 0]
        e = W[2, 2] - W[2, 0] * W[0, 2] / W[0, 0]
    low, high, shift = 0.0, np.inf, 0.0
    for _ in range(HALVINGS):
        determinant = (a + shift) * (e + shift) - b * c
        normal = -q[0] / W[0, 0]
        first = (b * h - (e + shift) * g) / determinant
        second = (c * g - (a + shift) * h) / determinant
        if d > 1:
            normal -= W[0, 1] * first / W[0, 0]
        if d > 2:
            normal -= W[0, 2] * second / W[0, 0]
        inside = normal > 0 and math.hypot(first, second) <= radius(local.bounds, 0, normal)
        if inside:
            high = shift
        else:
            low = shift
        if inside and (shift == 0.0 or high - low <= 1e-15 * high):
            break
        shift = 4 * shift + a + e if high == np.inf else 0.5 * (low + high)
        if shift in (low, high):
            break
    return normal, first, second


@compiled
def settle_one_point(local: Local, f: Array, states: Indices) -> bool:
    """Write force and state of the only point; False where the closed form does not hold."""
    normal, first, second = one_point(local)
    size = math.hypot(first, second)
    limit = radius(local.bounds, 0, normal) * (1.0 + BOUND_ROUND_OFF)
    if not (normal >= 0.0 and size <= limit):
        return False
    f[0] = normal
    if local.d > 1:
        f[1] = first
    if local.d > 2:
        f[2] = second
    states[0] = OPEN
    if normal > 0.0:
        slip = -SLIP if local.d == 2 and first < 0.0 else SLIP
        states[0] = slip if at_bound(local.bounds, 0, normal, size) else STICK
    return True
