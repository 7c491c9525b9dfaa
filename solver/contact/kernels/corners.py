"""Which faces look against a carrier, and which points that share a place may touch; compiled."""

from __future__ import annotations

import numpy as np

from solver.law.compiled import compiled
from solver.types import Array, Indices, Mask


@compiled
def facing(normal: Array, rotation: Array, towards: Array) -> float:
    """Cosine of the angle between a normal of a turned body and that of a carrier, (d,) each."""
    cosine = 0.0
    for i in range(len(towards)):
        for j in range(len(towards)):
            cosine += normal[j] * rotation[i, j] * towards[i]
    return cosine


@compiled
def look_against(normal: Array, rotation: Array, towards: Array, cosine: float, mask: Mask) -> None:
    """Fill in which faces of a turned body look against a carrier.

    Args:
        normal: Outward normals on the undeformed body, (n, d).
        rotation: Of the body, (d, d).
        towards: Normal of the carrier, (d,).
        cosine: Of the angle between the two, below which a face does.
        mask: These faces, (n,).
    """
    for p in range(len(normal)):
        mask[p] = facing(normal[p], rotation, towards) < cosine


@compiled
def choose_points(
    member: Indices, first: Indices, normal: Array, rotation: Array, towards: Array, mask: Mask
) -> None:
    """Fill in one point of each group, whose face looks most against the carrier, and all others.

    Args:
        member: Points of all groups, group after group.
        first: Place of the first of each group there, and their end, (groups + 1,).
        normal: Outward normals of all points on the undeformed body, (points, d).
        rotation: Of the body, (d, d).
        towards: Normal of the carrier, (d,).
        mask: Points that may touch, (points,).
    """
    mask[:] = True
    for group in range(len(first) - 1):
        least, best = np.inf, member[first[group]]
        for k in range(first[group], first[group + 1]):
            p = member[k]
            mask[p], cosine = False, facing(normal[p], rotation, towards)
            if cosine < least:
                least, best = cosine, p
        mask[best] = True


@compiled
def exclude_groups(member: Indices, first: Indices, may_touch: Mask, outside: Mask) -> int:
    """Fill in the points that may not touch, but for those in whose group another one may.

    Returns how many there are.
    """
    for p in range(len(outside)):
        outside[p] = not may_touch[p]
    for group in range(len(first) - 1):
        closed = True
        for k in range(first[group], first[group + 1]):
            closed = closed and not may_touch[member[k]]
        for k in range(first[group], first[group + 1]):
            outside[member[k]] = closed
    count = 0
    for p in range(len(outside)):
        count += outside[p]
    return count
