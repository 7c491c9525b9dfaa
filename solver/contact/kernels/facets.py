"""Closest points on the facets of a face, and what follows from how they move; compiled.

With the shape functions N at the closest points before and after a step, the nodes x_c of the face,
the frame (n, t) of the step, bars for means and d for increments over the step (docs/method.md,
"What carries"),

    e = dN . mean x_c = (e_n, e_t)                increment of the closest point on the mean surface
    dg = (n - kappa t) . (dx - mean N dx_c),      kappa = e_n/e_t        the mean slope
    ds = (t/a) . (dx - mean N dx_c),              a = e_t/ds             the mean stretch

hold exactly, whatever the step and however many facets it crosses.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from solver.law.compiled import compiled
from solver.types import Array, Indices, Mask


class FacetShapes(NamedTuple):
    """Shape functions of the facets of a face; t = d - 1 coordinates on each."""

    facets: Indices
    """Nodes of each facet, (facets, k)."""
    powers: Indices
    """Powers of the coordinates in the monomials of a shape function, (k, t)."""
    factors: Array
    """Factors of these monomials in each shape function, (k, k)."""
    derivatives: Array
    """Derivatives of the shape functions at a facet's own nodes, (k, t, k)."""
    undeformed: Array
    """Inverses of the derivatives of undeformed tangential positions at each facet's nodes,
    (facets, k, t, t), 1/m."""
    meeting: Indices
    """Facets that meet at nodes, and which of a facet's nodes that is, node after node, (.., 2)."""
    first: Indices
    """Number of the first of them at each node, and of all, (n + 1,)."""
    along: Array
    """Tangential positions of the nodes in the undeformed face, (n, t), m."""
    corners: int
    """Number of corners of a facet: 2 for intervals, 3 for triangles, 4 for quadrilaterals."""
    margin: float
    """Part of a facet by which points may be beyond its edge."""


@compiled
def power_of(base: float, exponent: int) -> float:
    """A small power; `**` takes ten times as long."""
    result = 1.0
    for _ in range(exponent):
        result *= base
    return result


@compiled
def shape_functions(shapes: FacetShapes, where: Array, values: Array, derivatives: Array) -> None:
    """Fill in shape functions (k,) and their derivatives (t, k) at coordinates (t,)."""
    values[:], derivatives[:] = 0.0, 0.0
    for c in range(len(shapes.powers)):
        monomial = 1.0
        for j in range(len(where)):
            monomial *= power_of(where[j], shapes.powers[c, j])
        for k in range(len(values)):
            values[k] += shapes.factors[k, c] * monomial
        for j in range(len(where)):
            power = shapes.powers[c, j]
            if power == 0:
                continue
            slope = power * power_of(where[j], power - 1)
            for i in range(len(where)):
                if i != j:
                    slope *= power_of(where[i], shapes.powers[c, i])
            for k in range(len(values)):
                derivatives[j, k] += shapes.factors[k, c] * slope


@compiled
def inverted(matrix: Array, inverse: Array) -> None:
    """Fill in the inverse of a matrix (1, 1) or (2, 2); not numbers where there is none."""
    if len(matrix) == 1:
        inverse[0, 0] = 1.0 / matrix[0, 0]
        return
    determinant = matrix[0, 0] * matrix[1, 1] - matrix[0, 1] * matrix[1, 0]
    inverse[0, 0], inverse[1, 1] = matrix[1, 1] / determinant, matrix[0, 0] / determinant
    inverse[0, 1], inverse[1, 0] = -matrix[0, 1] / determinant, -matrix[1, 0] / determinant


@compiled
def gradient_of(nodes: Indices, values: Array, derivatives: Array, gradient: Array) -> None:
    """Fill in derivatives of nodal values (n, c) along the coordinates of a facet, (c, t)."""
    gradient[:] = 0.0
    for k in range(len(nodes)):
        for i in range(len(gradient)):
            for j in range(len(derivatives)):
                gradient[i, j] += derivatives[j, k] * values[nodes[k], i]


@compiled
def slope_and_stretch(
    nodes: Indices,
    placed: Array,
    derivatives: Array,
    undeformed: Array,
    slope: Array,
    stretch: Array,
) -> None:
    """Fill in rise (t,) and stretch (t, t) of a facet over its tangential coordinates.

    Args:
        nodes: Of the facet, (k,).
        placed: Where all nodes are in the frame, normal first, (n, t + 1), m.
        derivatives: Of the shape functions, (t, k).
        undeformed: Inverse of the derivatives of the undeformed tangential positions, (t, t), 1/m.
        slope: (t,).
        stretch: (t, t).
    """
    t = len(derivatives)
    rise, flat, inverse = np.zeros(t), np.zeros((t, t)), np.empty((t, t))
    for k in range(len(nodes)):
        for j in range(t):
            rise[j] += derivatives[j, k] * placed[nodes[k], 0]
            for i in range(t):
                flat[i, j] += derivatives[j, k] * placed[nodes[k], 1 + i]
    inverted(flat, inverse)
    for j in range(t):
        slope[j] = 0.0
        for i in range(t):
            slope[j] += rise[i] * inverse[i, j]
            stretch[i, j] = 0.0
            for k in range(t):
                stretch[i, j] += flat[i, k] * undeformed[k, j]


@compiled
def average_at(shapes: FacetShapes, node: int, placed: Array, slope: Array, stretch: Array) -> None:
    """Fill in slope (t,) and stretch (t, t) at a node, means of the facets that meet there."""
    t, meeting = len(slope), 0
    own_slope, own_stretch = np.empty(t), np.empty((t, t))
    slope[:], stretch[:] = 0.0, 0.0
    for m in range(shapes.first[node], shapes.first[node + 1]):
        facet, corner = shapes.meeting[m, 0], shapes.meeting[m, 1]
        slope_and_stretch(
            shapes.facets[facet],
            placed,
            shapes.derivatives[corner],
            shapes.undeformed[facet, corner],
            own_slope,
            own_stretch,
        )
        slope += own_slope
        stretch += own_stretch
        meeting += 1
    slope /= max(meeting, 1)
    stretch /= max(meeting, 1)


EDGE_BLEND_WIDTH = 0.02
"""Part of a facet: as near as this to its edge, the slope at a closest point goes over to the
mean of the facets that meet there."""

PROJECTION_TOLERANCE = 1e-12
"""Part of a facet: Newton's method for a closest point ends when it moves it by less; the rest
is the square of that."""

PROJECTION_ITERATIONS = 4
"""Corrections of Newton's method for a closest point, at most."""

FACETS_TRIED = 4
"""Facets around a point, the nearest ones first, that are searched for its closest point."""

FARTHER = 0.5
"""Part of a facet: one that is farther than the nearest one by more is not tried.

Taken as spanned by two edges, a facet misses points on it by no more than its last corner is off
the parallelogram of the others: by strains, a few per cent of a facet.
"""


class ClosestPoints(NamedTuple):
    """Closest points of m points on the facets of a face; t = d - 1."""

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
    """Points beyond the edge of the face by more than its margin, (m,)."""


@compiled
def outside_by(shapes: FacetShapes, where: Array) -> float:
    """Distance of a point outside of a facet, in its own coordinates; negative inside."""
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
    for _ in range(PROJECTION_ITERATIONS):
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
        if largest < PROJECTION_TOLERANCE:
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
def project_onto_facets(
    face: tuple[Any, ...],
    room: tuple[Array, Array],
    position: Array,
    carrier: Array,
    frame: Array,
    place: Array,
    stand: tuple[Any, ...],
) -> None:
    """Fill in gaps and tangential positions (m, d) of points over a face, and their closest.

    Args:
        face: The fields of its `FacetShapes`; tuples without names are handed over faster.
        room: For the nodes in the frame, (n, d), and for a (d-1, d-1) matrix of each facet.
        position: Of the points in space, (m, d), m.
        carrier: Of its nodes in space, (n, d), m.
        frame: Rows normal and tangents, (d, d).
        place: (g, s), (m, d), m.
        stand: The fields of the `ClosestPoints` of the points.
    """
    shapes, closest = FacetShapes(*face), ClosestPoints(*stand)
    placed, inverses = room
    d, t, k = len(frame), len(frame) - 1, shapes.facets.shape[1]
    placed[:], points = carrier @ frame.T, position @ frame.T
    if shapes.corners > 2:
        spanned(shapes, placed, inverses)
    where, values, derivatives = np.empty(t), np.empty(k), np.empty((t, k))
    tried = np.zeros(min(FACETS_TRIED, len(shapes.facets)), np.int64)
    gradient, undeformed = np.empty((t, t)), np.empty((t, t))
    mean_slope, mean_stretch = np.empty(t), np.empty((t, t))
    for p in range(len(points)):
        point = points[p, 1:]
        if shapes.corners == 2:
            facet = facet_under(shapes, point, placed, where)
        else:
            facet = nearest_facet(shapes, point, placed, inverses, tried, where)
        nodes = shapes.facets[facet]
        shape_functions(shapes, where, values, derivatives)
        closest.nodes[p], closest.weights[p] = nodes, values
        place[p, 0], place[p, 1:] = points[p, 0], 0.0
        for a in range(k):
            place[p, 0] -= values[a] * placed[nodes[a], 0]
            for j in range(1, d):
                place[p, j] += values[a] * shapes.along[nodes[a], j - 1]
        miss, slope, stretch = outside_by(shapes, where), closest.slope[p], closest.stretch[p]
        closest.beyond_edge[p] = miss > shapes.margin
        gradient_of(nodes, shapes.along, derivatives, gradient)
        inverted(gradient, undeformed)
        slope_and_stretch(nodes, placed, derivatives, undeformed, slope, stretch)
        share = min(max(1.0 + miss / EDGE_BLEND_WIDTH, 0.0), 1.0)
        if share > 0.0:
            slope *= 1.0 - share
            stretch *= 1.0 - share
            for a in range(k):
                average_at(shapes, nodes[a], placed, mean_slope, mean_stretch)
                slope += share * values[a] * mean_slope
                stretch += share * values[a] * mean_stretch


STANDING_STILL = 1e-4
"""Part of a facet: a closest point that moves by less has the local slope and stretch, one that
moves by twice as much or more those of its increment; in between there is a transition."""


class FootPoints(NamedTuple):
    """Foot points on a face at one instant."""

    nodes: Indices
    """Nodes of the facet of each point, (m, k)."""
    weights: Array
    """Shape functions N of these there, (m, k)."""
    slope: Array
    """Rise of the face along the tangents of the frame, (m, d-1)."""
    stretch: Array
    """Current over undeformed tangential lengths, (m, d-1, d-1)."""
    place: Array
    """(g, s), (m, d), m."""
    position: Array
    """Positions of the nodes of the face, (n, d), m."""


FootPointArrays = tuple[Indices, Array, Array, Array, Array, Array]
"""The fields of a `FootPoints` as Python hands them over: without names they take half the time."""


@compiled
def interpolated(nodes: Indices, weights: Array, values: Array, found: Array) -> None:
    """Fill in what nodal values (n, d) are at places (m, d), by nodes and weights (m, k)."""
    found[:] = 0.0
    for p in range(len(nodes)):
        for a in range(nodes.shape[1]):
            for i in range(values.shape[1]):
                found[p, i] += weights[p, a] * values[nodes[p, a], i]


@compiled
def add_spread(
    nodes: Indices, weights: Array, factor: float, vectors: Array, target: Array
) -> None:
    """Add a factor times forces at places, (m, d), to those on the nodes, (n, d)."""
    for p in range(len(nodes)):
        for a in range(nodes.shape[1]):
            for i in range(vectors.shape[1]):
                target[nodes[p, a], i] += factor * weights[p, a] * vectors[p, i]


@compiled
def projection_increment(
    p: int,
    old: FootPoints,
    new: FootPoints,
    frame: Array,
    facet: float,
    increment: Array,
    ds: Array,
    kappa: Array,
    a: Array,
) -> float:
    """Fill in the increment of point p's closest point; returns the share of its own slope.

    Args:
        p: Number of the point.
        old: FootPoints at t_n.
        new: At t_{n+1}.
        frame: Rows normal and tangents of the face, (d, d).
        facet: Length of the smallest facet, m.
        increment: e = (e_n, e_t), (d,), m.
        ds: Increment in the undeformed face, (d-1,), m.
        kappa: Slope of the increment where the closest point moves, else of the surface, (d-1,).
        a: Stretch likewise, (d-1, d-1).
    """
    d, moved = len(frame), np.zeros(len(frame))
    for k in range(new.nodes.shape[1]):
        first, last = old.nodes[p, k], new.nodes[p, k]
        for i in range(d):
            before = 0.5 * (old.position[first, i] + new.position[first, i])
            after = 0.5 * (old.position[last, i] + new.position[last, i])
            moved[i] += new.weights[p, k] * after - old.weights[p, k] * before
    increment[:] = 0.0
    for i in range(d):
        for j in range(d):
            increment[i] += frame[i, j] * moved[j]
    squares = along = 0.0
    for i in range(d - 1):
        ds[i] = new.place[p, 1 + i] - old.place[p, 1 + i]
        kappa[i] = 0.5 * (old.slope[p, i] + new.slope[p, i])
        squares, along = squares + ds[i] ** 2, along + increment[1 + i] ** 2
        for j in range(d - 1):
            a[i, j] = 0.5 * (old.stretch[p, i, j] + new.stretch[p, i, j])
    share = min(max(math.sqrt(squares) / (STANDING_STILL * facet) - 1.0, 0.0), 1.0)
    if share > 0.0:
        # The least changes after which kappa . e_t = e_n and a ds = e_t.
        lift = increment[0]
        for i in range(d - 1):
            lift -= kappa[i] * increment[1 + i]
        for i in range(d - 1):
            kappa[i] += share * lift / along * increment[1 + i]
            missing = increment[1 + i]
            for j in range(d - 1):
                missing -= a[i, j] * ds[j]
            for j in range(d - 1):
                a[i, j] += share * missing * ds[j] / squares
    return share


@compiled
def forces_in_space(
    before: FootPointArrays,
    after: FootPointArrays,
    frame: Array,
    facet: float,
    force: Array,
    vectors: Array,
) -> None:
    """Fill in vectors in space (m, d) of normal and tangential forces, whose work is exact.

    They are f_n (n - kappa t) + a^-T f_t; arguments as in `projection_increment`.
    """
    d, old, new = len(frame), FootPoints(*before), FootPoints(*after)
    increment, ds, kappa, local = np.empty(d), np.empty(d - 1), np.empty(d - 1), np.empty(d)
    a, inverse = np.empty((d - 1, d - 1)), np.empty((d - 1, d - 1))
    vectors[:] = 0.0
    for p in range(len(force)):
        loaded = False
        for i in range(d):
            loaded = loaded or force[p, i] != 0.0
        if not loaded:
            continue
        projection_increment(p, old, new, frame, facet, increment, ds, kappa, a)
        inverted(a, inverse)
        local[0] = force[p, 0]
        for i in range(d - 1):
            local[1 + i] = -force[p, 0] * kappa[i]
            for j in range(d - 1):
                local[1 + i] += inverse[j, i] * force[p, 1 + j]
        for i in range(d):
            for j in range(d):
                vectors[p, j] += local[i] * frame[i, j]


@compiled
def work_defect(
    before: FootPointArrays, after: FootPointArrays, frame: Array, facet: float, force: Array
) -> float:
    """Work of these vectors less that of the forces (m, d), N, on (g, s), J.

    Only closest points of closed points that hardly move have any: kappa . e_t is not e_n there,
    nor a^-1 e_t ds. Arguments as in `projection_increment`.
    """
    d, total, old, new = (
        len(frame),
        0.0,
        FootPoints(*before),
        FootPoints(*after),
    )
    increment, ds, kappa = np.empty(d), np.empty(d - 1), np.empty(d - 1)
    a, inverse = np.empty((d - 1, d - 1)), np.empty((d - 1, d - 1))
    for p in range(len(force)):
        if (
            not force[p, 0] > 0.0
            or projection_increment(p, old, new, frame, facet, increment, ds, kappa, a) >= 1.0
        ):
            continue
        inverted(a, inverse)
        total += force[p, 0] * increment[0]
        for i in range(d - 1):
            drag = -ds[i]
            for j in range(d - 1):
                drag += inverse[i, j] * increment[1 + j]
            total += force[p, 1 + i] * drag - force[p, 0] * kappa[i] * increment[1 + i]
    return total
