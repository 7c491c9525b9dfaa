"""What the rows of contact points in the plane do to motions and forces. Compiled.

A row has numbers for two bodies only: that of the corner, and that of the face or the platform.
"""

from __future__ import annotations

import numpy as np

from solver.law.compiled import compiled
from solver.rigid.plane.model import PlaneModel, PlaneWork
from solver.types import Array


@compiled
def unknowns_of(system: PlaneModel, work: PlaneWork, i: int) -> tuple[int, int, int]:
    """The first unknown of the corner's block of a near point; that of what has the face, and end.

    The ground has none, the platform one.
    """
    k, n = work.points[i], len(system.mass)
    b, c = 3 * system.corner_of[k], 3 * system.face_of[k]
    return (b, c, c + 3) if c >= 0 else (b, n - n % 3, n)


@compiled
def change(system: PlaneModel, work: PlaneWork, row: int, motion: Array) -> float:
    """A row times a motion: an increment or a velocity of all unknowns."""
    b, other, end = unknowns_of(system, work, row // 2)
    rows = work.rows
    total = rows[row, b] * motion[b] + rows[row, b + 1] * motion[b + 1]
    total += rows[row, b + 2] * motion[b + 2]
    for k in range(other, end):
        total += rows[row, k] * motion[k]
    return total


@compiled
def push(
    system: PlaneModel, work: PlaneWork, force: Array, flexibility: Array, motion: Array
) -> None:
    """Add to a motion what forces or impulses at the near points, flat, move all unknowns by."""
    for i in range(work.counts[0]):
        b, other, end = unknowns_of(system, work, i)
        normal, tangential, rows = force[2 * i], force[2 * i + 1], work.rows
        for k in range(b, b + 3):
            share = normal * rows[2 * i, k] + tangential * rows[2 * i + 1, k]
            motion[k] += flexibility[k] * share
        for k in range(other, end):
            share = normal * rows[2 * i, k] + tangential * rows[2 * i + 1, k]
            motion[k] += flexibility[k] * share


@compiled
def compliance(system: PlaneModel, work: PlaneWork, flexibility: Array) -> Array:
    """G diag(flexibility) G^T of the near points, (2 m, 2 m)."""
    size, rows = 2 * work.counts[0], work.rows
    W = np.empty((size, size))
    for row in range(size):
        b, other, end = unknowns_of(system, work, row // 2)
        for column in range(row + 1):
            total = 0.0
            for k in range(b, b + 3):
                total += rows[row, k] * flexibility[k] * rows[column, k]
            for k in range(other, end):
                total += rows[row, k] * flexibility[k] * rows[column, k]
            W[row, column] = W[column, row] = total
    return W
