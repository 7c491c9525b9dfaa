"""Shape functions of the facets of a face, their slopes and stretches; compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from solver.law.compiled import compiled
from solver.types import Array, Indices


class FacetShapes(NamedTuple):
    """What stays the same of the facets of a face; t = d - 1 coordinates on each."""

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
