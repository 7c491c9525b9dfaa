"""Contact at velocity level at the closed points of a step, in one pass; compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from solver.law.compiled import compiled
from solver.law.friction import Bounds
from solver.law.velocity import correct_impulses, slip_reversal
from solver.types import Array, Indices


class ClosedPoints(NamedTuple):
    """Points that are pressed at the end of a step, and all points in that step."""

    number: Indices
    """Numbers of the closed points, rising, (m,)."""
    first: Indices
    """Number of the first point of each interface, and of all points."""
    force: Array
    """Forces of all points in their frames, (points, d), N."""
    mu: Array
    """Their coefficients of friction, (points,)."""
    cohesion: Array
    """What they hold besides, (points,), N."""


@compiled
def impulses(closed: Indices, force: Array, step: float) -> Array:
    """Impulses dt f of closed points in a step of some length (s), (d m,), N s.

    Forces are those of all points, (points, d), N.
    """
    m, d = len(closed), force.shape[1]
    found = np.empty(m * d)
    for i in range(m):
        for k in range(d):
            found[d * i + k] = step * force[closed[i], k]
    return found


@compiled
def impulse_bounds(closed: Indices, mu: Array, cohesion: Array, step: float) -> Bounds:
    """Bounds of these impulses, by coefficients and cohesion (N) of all points, (points,)."""
    own_mu, own_cohesion = np.empty(len(closed)), np.empty(len(closed))
    for i in range(len(closed)):
        own_mu[i], own_cohesion[i] = mu[closed[i]], step * cohesion[closed[i]]
    return Bounds(own_mu, own_cohesion, np.inf)


@compiled
def largest_reversal(closed: Indices, first: Indices, force: Array, velocity: Array) -> float:
    """The largest slip reversal of an interface at the end of a step, m/s.

    Arguments as in `ClosedPoints`; `velocity` is that of the closed points at the end of the step,
    (m, d), m/s.
    """
    largest, start = 0.0, 0
    friction = np.empty((len(closed), force.shape[1] - 1))
    for i in range(len(closed)):
        friction[i] = force[closed[i], 1:]
    for interface in range(len(first) - 1):
        end = start
        while end < len(closed) and closed[end] < first[interface + 1]:
            end += 1
        if end > start:
            largest = max(largest, slip_reversal(friction[start:end], velocity[start:end, 1:]))
        start = end
    return largest


@compiled
def correct_closed_points(
    closed: Indices,
    first: Indices,
    force: Array,
    mu: Array,
    cohesion: Array,
    velocity: Array,
    W: Array,
    mobility: Array,
    step: float,
    taken: float,
    lands: bool,
    counts: Indices,
    q: Array,
) -> tuple[bool, float, float, float]:
    """Fill in the correction q of the impulses of closed points, (m, d), N s, as the law has it.

    Returns whether there is one, what it takes in the normal and in the tangential directions (J),
    and the largest slip reversal (m/s).

    Args:
        closed: As in `ClosedPoints`, one by one, like all up to `cohesion`.
        first: Of interfaces.
        force: Of all points.
        mu: Of all points.
        cohesion: Of all points.
        velocity: Of the closed points after the step, in their frames, (m, d), m/s.
        W: What the law takes for G M^-1 G^T of the closed points, (m, d, m, d), 1/kg.
        mobility: G M^-1 G^T itself.
        step: Length of the step, s.
        taken: Energy that friction took in it, J.
        lands: Whether a rigid body landed in it.
        counts: Of outcomes of local problems.
        q: The correction.
    """
    m, d = q.shape
    found = correct_impulses(
        d,
        W.reshape(d * m, d * m),
        velocity.reshape(d * m),
        impulses(closed, force, step),
        impulse_bounds(closed, mu, cohesion, step),
        taken,
        counts,
        lands,
    )
    if not found.found:
        return False, 0.0, 0.0, 0.0
    flat = q.reshape(d * m)
    flat[:] = found.q
    after = velocity + (mobility.reshape(d * m, d * m) @ flat).reshape((m, d))
    reversal = largest_reversal(closed, first, force, after)
    return True, found.contact, found.friction, reversal
