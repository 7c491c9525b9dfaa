"""Where on its facets a surface has contact points, and with which weights."""

from __future__ import annotations

from itertools import pairwise

import basix
import numpy as np

from solver.types import Array, Indices

Rule = tuple[Indices, Array, Array]
"""Facet of each point (n,), its place on the reference facet (n, d - 1), its weight (n,)."""

ON_FACET = 1e-6
"""A cut belongs to the facets that it is nearer to than this part of their length."""


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


def on_pieces(start: Array, leg: Array, cuts: Array, degree: int) -> Rule:
    """Gauss points on the pieces into which points cut straight facets in the plane.

    A product of two piecewise polynomials is integrated exactly on the common refinement of both
    meshes only; this is what passes the patch test. Facets are given by their first ends and the
    legs to the other ones, (facets, 2), m; cuts, (n, 2), m, that are on no facet do nothing.
    """
    points, weights = facet_rule("gauss", degree, basix.CellType.interval)
    square = np.einsum("fi,fi->f", leg, leg)[:, None]
    off = cuts[None] - start[:, None]
    along = np.einsum("fni,fi->fn", off, leg) / square
    across = (off[..., 0] * leg[:, None, 1] - off[..., 1] * leg[:, None, 0]) / square
    inside = (np.abs(across) < ON_FACET) & (along > 1e-9) & (along < 1 - 1e-9)
    pieces: list[tuple[int, float, float]] = []
    for facet, (place, chosen) in enumerate(zip(along, inside, strict=True)):
        ends = np.concatenate([[0.0], np.unique(place[chosen].round(12)), [1.0]])
        pieces += [(facet, a, b - a) for a, b in pairwise(ends)]
    if not pieces:
        return on_facets(0, (points, weights))
    facets, begin, length = (np.array(column) for column in zip(*pieces, strict=True))
    row, local, weight = on_facets(len(pieces), (points, weights))
    return facets[row], begin[row, None] + length[row, None] * local, length[row] * weight
