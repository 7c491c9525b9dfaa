"""Quadrature rules of contact points on facets."""

from __future__ import annotations

from collections.abc import Callable

import basix
import numpy as np

from solver.types import Array, Indices

Rule = tuple[Indices, Array, Array]
"""Facet of each point (n,), its place on the reference facet (n, d - 1), its weight (n,)."""

Cut = Callable[[Array, basix.CellType, int], Rule]
"""A rule on pieces of facets, by their first d corners in space, (facets, d, d), m, their shape and
the degree of the displacement."""


def facet_rule(points: str, degree: int, facet: basix.CellType) -> tuple[Array, Array]:
    """Points and weights on the reference facet, exact for the contact of polynomials.

    Points are "nodes" (Gauss-Lobatto: the nodes of the displacement, of degree 1 or 2) or "gauss".

    Raises:
        ValueError: For the nodes of triangles of degree 2: a rule there is exact for constants and
            linear fields only with weight 0 at the corners, which could then not touch.
    """
    if points == "gauss" and facet == basix.CellType.triangle:
        return basix.make_quadrature(facet, 2 * degree)  # symmetric, 3 or 6 points
    if points == "gauss":
        return basix.make_quadrature(facet, 2 * degree + 1, basix.QuadratureType.gauss_jacobi)
    if facet != basix.CellType.triangle:
        return basix.make_quadrature(facet, 2 * degree - 1, basix.QuadratureType.gll)
    if degree > 1:
        raise ValueError(
            "contact points at the nodes of tetrahedra of degree 2: no rule with positive weights"
            " has them; allowed degree 1, hexahedra, or points at 'gauss'"
        )
    return basix.geometry(facet), np.full(3, basix.cell.volume(facet) / 3)


def on_facets(count: int, rule: tuple[Array, Array]) -> Rule:
    """A rule with the points of one facet on each of `count` facets."""
    points, weights = rule
    row = np.repeat(np.arange(count), len(weights))
    return row, np.tile(points, (count, 1)), np.tile(weights, count)
