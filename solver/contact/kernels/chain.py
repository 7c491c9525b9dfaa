"""Feet of points on a chain of straight facets in the plane; compiled."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from solver.law.compiled import compiled
from solver.types import Array, Indices, Mask

EDGE_BLEND_WIDTH = 0.02
"""Part of a facet: as near as this to its edge, a foot goes over to the slope averaged over the
facets that meet there."""


class Feet(NamedTuple):
    """Where m points stand on the facets of a face; t = d - 1."""

    nodes: Indices
    """Nodes of the facet, (m, k)."""
    weights: Array
    """Shape functions N of these there, (m, k)."""
    slope: Array
    """Rise of the face along the tangents of the frame, (m, t); blended with that of the next
    facet where facets meet, so that it is continuous."""
    stretch: Array
    """Current over undeformed tangential lengths, likewise, (m, t, t)."""
    beyond_edge: Mask
    """Feet beyond the edge of the face by more than its margin, (m,)."""


@compiled
def _blended(before: float, own: float, after: float, where: float) -> float:
    """What is constant on each facet, blended with the neighbour's near the ends: continuous."""
    start = max(0.0, 1.0 - abs(where) / EDGE_BLEND_WIDTH)
    end = max(0.0, 1.0 - abs(1.0 - where) / EDGE_BLEND_WIDTH)
    return (1.0 - start - end) * own + 0.5 * (start * (before + own) + end * (own + after))


@compiled
def stand_on_chain(
    chain: Indices,
    reference: Array,
    margin: float,
    position: Array,
    carrier: Array,
    frame: Array,
    place: Array,
    stand: tuple[Any, ...],
) -> None:
    """Fill in gaps and tangential positions (m, 2) of points over straight facets, and their feet.

    Args:
        chain: Nodes of the face, one after another, (n,).
        reference: Their tangential positions in the undeformed face, (n,), m.
        margin: Part of a facet by which points may be beyond its edge.
        position: Of the points in space, (m, 2), m.
        carrier: Of the nodes in space, (n, 2), m.
        frame: Rows normal and tangent, (2, 2).
        place: (g, s), (m, 2), m.
        stand: The fields of the `Feet` of the points, without names: handed over faster.
    """
    last, feet = len(chain) - 2, Feet(*stand)
    height, along = np.empty(last + 2), np.empty(last + 2)
    for k in range(last + 2):
        x = carrier[chain[k]]
        height[k] = frame[0, 0] * x[0] + frame[0, 1] * x[1]
        along[k] = frame[1, 0] * x[0] + frame[1, 1] * x[1]
    slopes, stretches = np.empty(last + 1), np.empty(last + 1)
    for k in range(last + 1):
        length = along[k + 1] - along[k]
        slopes[k] = (height[k + 1] - height[k]) / length
        stretches[k] = length / (reference[k + 1] - reference[k])
    for p in range(len(position)):
        at = frame[1, 0] * position[p, 0] + frame[1, 1] * position[p, 1]
        k = min(max(np.searchsorted(along, at, side="right") - 1, 0), last)
        where = (at - along[k]) / (along[k + 1] - along[k])
        before, after = max(k - 1, 0), min(k + 1, last)
        feet.nodes[p, 0], feet.nodes[p, 1] = chain[k], chain[k + 1]
        feet.weights[p, 0], feet.weights[p, 1] = 1.0 - where, where
        place[p, 0] = 0.0
        for i in range(2):
            foot = (1.0 - where) * carrier[chain[k], i] + where * carrier[chain[k + 1], i]
            place[p, 0] += frame[0, i] * (position[p, i] - foot)
        place[p, 1] = reference[k] + where * (reference[k + 1] - reference[k])
        feet.slope[p, 0] = _blended(slopes[before], slopes[k], slopes[after], where)
        feet.stretch[p, 0, 0] = _blended(stretches[before], stretches[k], stretches[after], where)
        feet.beyond_edge[p] = where < -margin or where > 1.0 + margin
