"""Feet of points on the facets of a face, straight or bent, in the plane and in space; compiled."""

from __future__ import annotations

from typing import Any

import numpy as np

from solver.contact.kernels.chain import EDGE_BLEND_WIDTH, Feet, stand_on_chain
from solver.contact.kernels.shapes import (
    FacetShapes,
    average_at,
    gradient_of,
    inverted,
    shape_functions,
    slope_and_stretch,
)
from solver.law.compiled import compiled
from solver.types import Array, Indices

FOOT_SETTLED = 1e-12
"""Part of a facet: Newton's method for a foot ends when it moves the foot by less; what is left is
the square of that."""

FOOT_ITERATIONS = 4
"""Corrections of Newton's method for a foot, at most."""

FACETS_TRIED = 4
"""Facets around a point, the nearest ones first, among which its foot is looked for."""

FARTHER = 0.5
"""Part of a facet: one that is farther than the nearest one by more is not tried.

Taken as spanned by two edges, a facet misses points on it by no more than its last corner is off
the parallelogram of the others: by strains, a few per cent of a facet.
"""


@compiled
def outside_by(shapes: FacetShapes, where: Array) -> float:
    """How far a point is outside of a facet, in its own coordinates; negative inside."""
    total, miss = 0.0, -np.inf
    for j in range(len(where)):
        total += where[j]
        miss = max(miss, -where[j])
        if shapes.corners != 3:
            miss = max(miss, where[j] - 1.0)
    return max(miss, total - 1.0) if shapes.corners == 3 else miss


@compiled
def spanned(shapes: FacetShapes, placed: Array, inverses: Array) -> None:
    """Fill in the inverses (facets, t, t) of facets taken as spanned by edges from one corner."""
    t = placed.shape[1] - 1
    edges = np.empty((t, t))
    for facet in range(len(inverses)):
        nodes = shapes.facets[facet]
        for i in range(t):
            for j in range(t):
                edges[i, j] = placed[nodes[1 + j], 1 + i] - placed[nodes[0], 1 + i]
        inverted(edges, inverses[facet])


@compiled
def coordinates_on(
    shapes: FacetShapes, facet: int, point: Array, placed: Array, inverse: Array, where: Array
) -> None:
    """Fill in coordinates (t,) of a point on a facet taken as spanned by two of its edges."""
    first = shapes.facets[facet, 0]
    where[:] = 0.0
    for i in range(len(where)):
        for j in range(len(where)):
            where[i] += inverse[i, j] * (point[j] - placed[first, 1 + j])


@compiled
def settle_on(shapes: FacetShapes, facet: int, point: Array, placed: Array, where: Array) -> None:
    """Let coordinates (t,) on a facet become those of a point, by Newton's method."""
    t, nodes = len(where), shapes.facets[facet]
    values, derivatives = np.empty(len(nodes)), np.empty((t, len(nodes)))
    gradient, inverse, miss = np.empty((t + 1, t)), np.empty((t, t)), np.empty(t)
    for _ in range(FOOT_ITERATIONS):
        shape_functions(shapes, where, values, derivatives)
        gradient_of(nodes, placed, derivatives, gradient)
        inverted(gradient[1:], inverse)
        for j in range(t):
            miss[j] = point[j]
            for k in range(len(nodes)):
                miss[j] -= values[k] * placed[nodes[k], 1 + j]
        largest = 0.0
        for i in range(t):
            change = 0.0
            for j in range(t):
                change += inverse[i, j] * miss[j]
            where[i] += change
            largest = max(largest, abs(change))
        if largest < FOOT_SETTLED:
            break


@compiled
def nearest_facet(
    shapes: FacetShapes, point: Array, placed: Array, inverses: Array, tried: Indices, where: Array
) -> int:
    """The facet that a point is on or nearest to, with its coordinates there filled in.

    Nearness is judged on facets taken as spanned by two edges; bent ones end elsewhere, so that
    the nearest few are tried where the first one does not hold the point.

    Args:
        shapes: The facets.
        point: Tangential position, (t,), m.
        placed: Where all nodes are in the frame, (n, t + 1), m.
        inverses: As from `spanned`.
        tried: Room for the numbers of the facets that are tried.
        where: The coordinates, (t,).
    """
    misses, guess = np.full(len(tried), np.inf), np.empty_like(where)
    tried[:] = 0
    for facet in range(len(inverses)):
        coordinates_on(shapes, facet, point, placed, inverses[facet], guess)
        miss, last = outside_by(shapes, guess), len(tried) - 1
        if not miss < misses[last]:
            continue
        while last > 0 and miss < misses[last - 1]:
            misses[last], tried[last] = misses[last - 1], tried[last - 1]
            last -= 1
        misses[last], tried[last] = miss, facet
    least, best = np.inf, tried[0]
    for k in range(len(tried)):
        if misses[k] > least + FARTHER:
            break
        facet = tried[k]
        coordinates_on(shapes, facet, point, placed, inverses[facet], guess)
        settle_on(shapes, facet, point, placed, guess)
        miss = outside_by(shapes, guess)
        if miss < least or k == 0:
            least, best = miss, facet
            where[:] = guess
        if k == 0 and miss <= shapes.margin:
            break
    return best


@compiled
def facet_under(shapes: FacetShapes, point: Array, placed: Array, where: Array) -> int:
    """The facet of a chain in the plane that a point is over, its coordinate there filled in."""
    last = len(shapes.facets) - 1
    facet = 0
    while facet < last and placed[shapes.facets[facet + 1, 0], 1] <= point[0]:
        facet += 1
    start = placed[shapes.facets[facet, 0], 1]
    where[0] = (point[0] - start) / (placed[shapes.facets[facet, 1], 1] - start)
    settle_on(shapes, facet, point, placed, where)
    return facet


@compiled
def stand_on_facets(
    face: tuple[Any, ...],
    room: tuple[Array, Array, Array, Array],
    position: Array,
    carrier: Array,
    frame: Array,
    place: Array,
    stand: tuple[Any, ...],
) -> None:
    """Fill in gaps and tangential positions (m, d) of points over a face, and their feet.

    Args:
        face: The fields of its `FacetShapes`; tuples without names are handed over faster.
        room: For the nodes in the frame, (n, d), for a (d-1, d-1) matrix of each facet, and for
            slopes, (n, d-1), and stretches, (n, d-1, d-1), averaged at the nodes.
        position: Of the points in space, (m, d), m.
        carrier: Of its nodes in space, (n, d), m.
        frame: Rows normal and tangents, (d, d).
        place: (g, s), (m, d), m.
        stand: The fields of the `Feet` of the points.
    """
    shapes, feet = FacetShapes(*face), Feet(*stand)
    placed, inverses, mean_slope, mean_stretch = room
    d, t, k = len(frame), len(frame) - 1, shapes.facets.shape[1]
    placed[:], points = carrier @ frame.T, position @ frame.T
    if shapes.corners > 2:
        spanned(shapes, placed, inverses)
    where, values, derivatives = np.empty(t), np.empty(k), np.empty((t, k))
    tried = np.zeros(min(FACETS_TRIED, len(shapes.facets)), np.int64)
    gradient, undeformed = np.empty((t, t)), np.empty((t, t))
    for node in range(len(placed)):
        average_at(shapes, node, placed, mean_slope[node], mean_stretch[node])
    for p in range(len(points)):
        point = points[p, 1:]
        if shapes.corners == 2:
            facet = facet_under(shapes, point, placed, where)
        else:
            facet = nearest_facet(shapes, point, placed, inverses, tried, where)
        nodes = shapes.facets[facet]
        shape_functions(shapes, where, values, derivatives)
        feet.nodes[p], feet.weights[p] = nodes, values
        place[p, 0], place[p, 1:] = points[p, 0], 0.0
        for a in range(k):
            place[p, 0] -= values[a] * placed[nodes[a], 0]
            for j in range(1, d):
                place[p, j] += values[a] * shapes.along[nodes[a], j - 1]
        miss, slope, stretch = outside_by(shapes, where), feet.slope[p], feet.stretch[p]
        feet.beyond_edge[p] = miss > shapes.margin
        gradient_of(nodes, shapes.along, derivatives, gradient)
        inverted(gradient, undeformed)
        slope_and_stretch(nodes, placed, derivatives, undeformed, slope, stretch)
        share = min(max(1.0 + miss / EDGE_BLEND_WIDTH, 0.0), 1.0)
        if share > 0.0:
            slope *= 1.0 - share
            stretch *= 1.0 - share
            for a in range(k):
                slope += share * values[a] * mean_slope[nodes[a]]
                stretch += share * values[a] * mean_stretch[nodes[a]]


Chain = tuple[Indices, Array, float]
"""Straight facets in the plane, as `stand_on_chain` takes them."""

Facets = tuple[tuple[Any, ...], tuple[Array, Array, Array, Array]]
"""Facets of any kind, as `stand_on_facets` takes them."""


@compiled
def stand_on_face(
    chain: Chain | None,
    facets: Facets | None,
    position: Array,
    carrier: Array,
    frame: Array,
    place: Array,
    stand: tuple[Any, ...],
) -> None:
    """Fill in what `stand_on_chain` does, or `stand_on_facets`: a face is one of the two."""
    if chain is not None:
        stand_on_chain(*chain, position, carrier, frame, place, stand)
    if facets is not None:
        stand_on_facets(*facets, position, carrier, frame, place, stand)
