"""Differences of the motion over steps; compiled."""

from __future__ import annotations

from solver.law.compiled import compiled
from solver.types import Array


@compiled
def third_differences(
    u: Array,
    u_before: Array,
    mean_before: Array,
    change_before: Array,
    rigid: Array,
    rigid_before: Array,
    rigid_change_before: Array,
    dt: float,
    dt_before: float,
    dt_first: float,
    found: Array,
    rigid_change: Array,
) -> float:
    """Fill in mean velocity, acceleration and third difference of all points; the largest jerk.

    Args:
        u: Displacements after the step, (n,), m.
        u_before: Before it.
        mean_before: Mean velocities in the step before, (n,), m/s.
        change_before: Accelerations there, (n,), m/s2.
        rigid: Velocities of the bodies as a whole after the step, (k,), m/s.
        rigid_before: Before it.
        rigid_change_before: Their mean accelerations in the step before, (k,), m/s2.
        dt: Length of the step, s.
        dt_before: Of the step before.
        dt_first: Of the one before that.
        found: The three, (3, n), m/s, m/s2, m/s3.
        rigid_change: Mean accelerations of the bodies as a whole in the step, (k,), m/s2.
    """
    between, apart = (dt + dt_before) / 2, (dt + 2 * dt_before + dt_first) / 4
    for i in range(len(u)):
        found[0, i] = (u[i] - u_before[i]) / dt
        found[1, i] = (found[0, i] - mean_before[i]) / between
        found[2, i] = (found[1, i] - change_before[i]) / apart
    largest = 0.0
    for k in range(len(rigid)):
        rigid_change[k] = (rigid[k] - rigid_before[k]) / dt
        largest = max(largest, abs(rigid_change[k] - rigid_change_before[k]) / between)
    return largest


@compiled
def largest_change(now: Array, before: Array) -> float:
    """The largest change of any of some numbers; 0 where there are none, or none is a number."""
    largest = 0.0
    for i in range(len(now)):
        largest = max(largest, abs(now[i] - before[i]))
    return largest
