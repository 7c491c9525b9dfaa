"""Points that may come into contact in a correction, and what becomes of their forces; compiled."""

from __future__ import annotations

from solver.law.compiled import compiled
from solver.types import Array, Indices, Mask


@compiled
def candidates(
    y: Array, reach: Array, may_touch: Mask, force: Array, number: Indices, pressed: Mask
) -> int:
    """Fill in numbers of points that may touch at augmented positions y, (points, d); how many.

    Also which of these carry a force, or would sink in under the forces so far; both arrays have
    room for all.
    """
    count = 0
    for p in range(len(y)):
        if (y[p, 0] < reach[p] and may_touch[p]) or force[p, 0] > 0.0:
            number[count] = p
            pressed[count] = y[p, 0] < 0.0 or force[p, 0] > 0.0
            count += 1
    return count


@compiled
def put_away(y: Array, beyond: Mask, size: Array) -> None:
    """Put points beyond an edge as far from their carrier as the size of their body, m, in y."""
    for p in range(len(y)):
        if beyond[p]:
            y[p, 0] = size[p]


@compiled
def free_values(
    near: Indices,
    W: Array,
    y: Array,
    force: Array,
    anchor: Array,
    softness: Array,
    softening: Array,
    held: Array,
    round_off: Array,
    start: Array,
    q: Array,
) -> None:
    """Fill in a guess of the forces of near points, and free values q with y = q + W f, (m, d).

    Args:
        near: Numbers of the points.
        W: Their compliance, (m, d, m, d), m/N; it holds softness and softening.
        y: Augmented positions of all points after the free step, (points, d), m.
        force: Their forces so far, (points, d), N.
        anchor: Their stick memory, (points, d-1), m.
        softness: Of the interface at all points, (points,), m/N: no part of y.
        softening: Of the near points, (m,), m/N: acts on what forces differ by from held ones.
        held: Forces of all points that they are compared with, (points, d), N.
        round_off: Of the gaps of all points, (points,), m.
        start: The guess, (m, d), N.
        q: The free values, (m, d), m.
    """
    m, d = q.shape
    pressed = False
    for i in range(m):
        for k in range(d):
            start[i, k] = force[near[i], k]
            pressed = pressed or start[i, k] != 0.0
    for i in range(m):
        p = near[i]
        for k in range(d):
            q[i, k] = y[p, k] + softness[p] * start[i, k]
            q[i, k] += softening[i] * (start[i, k] - held[p, k])
            for j in range(m):
                for n in range(d):
                    q[i, k] -= W[i, k, j, n] * start[j, n]
            if k > 0:
                q[i, k] -= anchor[p, k - 1]
        if not pressed and abs(q[i, 0]) < round_off[p]:  # nothing tells that such a gap is small
            q[i, 0] = 0.0


@compiled
def take_over(force: Array, near: Indices, new: Array, change: Array) -> float:
    """Replace the forces of near points; returns the sum of the squares of the new ones, N2.

    Args:
        force: Of all points, (points, d), N.
        near: Numbers of the points.
        new: Their forces from now on, (m, d), N.
        change: Filled in: new forces less those before, (m, d), N.
    """
    squares = 0.0
    for i in range(len(near)):
        for k in range(new.shape[1]):
            change[i, k] = new[i, k] - force[near[i], k]
            force[near[i], k] = new[i, k]
            squares += new[i, k] ** 2
    return squares


@compiled
def add_softness(W: Array, near: Indices, softness: Array, added: Array) -> None:
    """Add to the diagonal of near points' compliance W, (m, d, m, d), m/N.

    Args:
        W: What is added to.
        near: Numbers of the points.
        softness: Of the interface at all points, (points,), m/N.
        added: Further terms at the near ones, (m,), m/N.
    """
    for i in range(len(near)):
        for k in range(W.shape[1]):
            W[i, k, i, k] += softness[near[i]] + added[i]
