"""Points that may come into contact in a correction, and what becomes of their forces; compiled."""

from __future__ import annotations

import numpy as np

from solver.law.compiled import compiled
from solver.law.local_problem import solve_points
from solver.types import Array, Indices, Mask

#: What can become of a correction's contact problem: no point is near; others are than those whose
#: compliance there is; its free values are there, and it is left to the caller; no method settled
#: it; it is solved.
NOTHING_NEAR, OTHERS_NEAR, LEFT_OPEN, UNSETTLED, SETTLED = range(5)


@compiled
def candidates(y: Array, margin: Array, may_touch: Mask, force: Array, number: Indices) -> int:
    """Fill in numbers of points that may come into contact; returns how many there are.

    Args:
        y: Augmented positions after the free step, (points, d), m.
        margin: Gaps below which points may come into contact, (points,), m.
        may_touch: Points that may touch, (points,).
        force: Forces so far, (points, d), N.
        number: Filled in with the numbers, rising; it has room for all, (points,).
    """
    count = 0
    for p in range(len(y)):
        if (y[p, 0] < margin[p] and may_touch[p]) or force[p, 0] > 0.0:
            number[count] = p
            count += 1
    return count


@compiled
def sinks_in(y: Array, round_off: Array, may_touch: Mask, seen: Mask) -> bool:
    """True if points that may touch, but were never near, are in their carrier at positions y."""
    for p in range(len(y)):
        if y[p, 0] < -round_off[p] and may_touch[p] and not seen[p]:
            return True
    return False


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
    bed: Array,
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
        bed: Softness of the beds below all points, (points,), m/N; W holds it, too.
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
        q[i, 0] += bed[p] * start[i, 0]


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
def settle(
    y: Array,
    near: Indices,
    W: Array,
    softening: Array,
    margin: Array,
    may_touch: Mask,
    anchor: Array,
    softness: Array,
    held: Array,
    bed: Array,
    round_off: Array,
    force: Array,
    number: Indices,
    mu: Array,
    cohesion: Array,
    alone: bool,
    counts: Indices,
    q: Array,
    change: Array,
) -> tuple[int, int, float]:
    """Let the forces of near points obey the contact law after the free step to y, in one pass.

    Returns what became of that, how many points are near, and the sum of the squares of their
    forces, N2.

    Args:
        y: Augmented positions of all points after the free step, (points, d), m.
        near: Points that W belongs to; where others are near nothing is changed.
        W: As in `free_values`.
        softening: Likewise, of the near points.
        margin: As in `candidates`.
        may_touch: As in `candidates`.
        anchor: As in `free_values`, like all up to `round_off`, of all points.
        softness: Of the interface.
        held: Forces that those so far are compared with.
        bed: Softness of the beds.
        round_off: Of the gaps.
        force: Forces of all points, replaced by those that obey the law, (points, d), N.
        number: As in `candidates`.
        mu: Coefficients of friction of all points, (points,).
        cohesion: What they hold besides, (points,), N.
        alone: True to solve the problem here, or to leave that to the caller.
        counts: Of outcomes of local problems.
        q: Free values, filled in, (m, d), m.
        change: How much the forces of near points changed, filled in, (m, d), N.
    """
    count = candidates(y, margin, may_touch, force, number)
    if count == 0:
        return NOTHING_NEAR, count, 0.0
    if count != len(near):
        return OTHERS_NEAR, count, 0.0
    own_mu, own_cohesion = np.empty(count), np.empty(count)
    for i in range(count):
        if number[i] != near[i]:
            return OTHERS_NEAR, count, 0.0
        own_mu[i], own_cohesion[i] = mu[near[i]], cohesion[near[i]]
    new = np.empty(q.shape)
    free_values(near, W, y, force, anchor, softness, softening, held, bed, round_off, new, q)
    if not alone:
        return LEFT_OPEN, count, 0.0
    if not solve_points(W, q, own_mu, own_cohesion, np.inf, new, counts):
        return UNSETTLED, count, 0.0
    return SETTLED, count, take_over(force, near, new, change)


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
