"""Feet of points on a chain of straight facets in the plane; compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from solver.law.compiled import compiled
from solver.types import Array, Indices, Mask

EDGE_BLEND_WIDTH = 0.02
"""Part of a facet: as near as this to its edge, a foot goes over to the slope averaged over the
facets that meet there."""


class ChainFeet(NamedTuple):
    """Where m points stand on the facets of a chain."""

    facet: Indices
    """Number of the facet, (m,)."""
    weights: Array
    """Shape functions of its two nodes there, (m, 2)."""
    along: Array
    """Tangential position in the undeformed chain, (m, 1), m."""
    slope: Array
    """Rise of the chain over its tangential length, (m, 1)."""
    stretch: Array
    """Current over undeformed tangential length, (m, 1, 1)."""
    outside: Mask
    """Whether the foot is beyond the end of its facet by more than the margin, (m,)."""


@compiled
def _blended(before: float, own: float, after: float, where: float) -> float:
    """What is constant on each facet, blended with the neighbour's near the ends: continuous."""
    start = max(0.0, 1.0 - abs(where) / EDGE_BLEND_WIDTH)
    end = max(0.0, 1.0 - abs(1.0 - where) / EDGE_BLEND_WIDTH)
    return (1.0 - start - end) * own + 0.5 * (start * (before + own) + end * (own + after))


@compiled
def feet_on_chain(along: Array, chain: Array, reference: Array, margin: float) -> ChainFeet:
    """Feet of points on straight facets, in closed form.

    `along` are tangential positions of the points, (m,), `chain` the nodes in the frame, one after
    another, (n, 2), `reference` their tangential positions in the undeformed chain, (n,), m; the
    margin is a part of a facet.
    """
    m, last = len(along), len(chain) - 2
    slopes, stretches = np.empty(last + 1), np.empty(last + 1)
    for k in range(last + 1):
        length = chain[k + 1, 1] - chain[k, 1]
        slopes[k] = (chain[k + 1, 0] - chain[k, 0]) / length
        stretches[k] = length / (reference[k + 1] - reference[k])
    facet, weights, place = np.empty(m, np.int64), np.empty((m, 2)), np.empty((m, 1))
    slope, stretch = np.empty((m, 1)), np.empty((m, 1, 1))
    outside = np.empty(m, np.bool_)
    for i in range(m):
        k = min(max(np.searchsorted(chain[:, 1], along[i], side="right") - 1, 0), last)
        where = (along[i] - chain[k, 1]) / (chain[k + 1, 1] - chain[k, 1])
        before, after = max(k - 1, 0), min(k + 1, last)
        facet[i], weights[i, 0], weights[i, 1] = k, 1.0 - where, where
        place[i, 0] = reference[k] + where * (reference[k + 1] - reference[k])
        slope[i, 0] = _blended(slopes[before], slopes[k], slopes[after], where)
        stretch[i, 0, 0] = _blended(stretches[before], stretches[k], stretches[after], where)
        outside[i] = where < -margin or where > 1.0 + margin
    return ChainFeet(facet, weights, place, slope, stretch, outside)
