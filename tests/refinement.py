"""Contact points on the common refinement of two surfaces, which alone passes the patch test."""

from __future__ import annotations

from itertools import pairwise

import basix
import numpy as np

from solver.contact.facets import Facets
from solver.contact.quadrature import Cut, Rule, facet_rule, on_facets
from solver.types import Array

ON_FACET = 1e-6
"""A cut belongs to the facets that it is nearer to than this part of their length."""


def outlines(face: Facets) -> Array:
    """Places that cut the facets of a surface opposite, m.

    In the plane where facets end, (facets + 1, 2); in space corners in turn, (facets, k, 3).
    """
    if face.cell == "interval":
        return face.positions[[*face.nodes[:, 0], face.nodes[-1, -1]]]
    ring = [0, 1, 2] if face.cell == "triangle" else [0, 1, 3, 2]
    return face.positions[face.nodes[:, ring]]


def cut_by(cuts: Array) -> Cut:
    """The rule for facets that are cut by those opposite, by the `outlines` of these."""

    def rule(corners: Array, facet: basix.CellType, degree: int) -> Rule:
        """Gauss points on pieces of facets."""
        start, legs = corners[:, 0], corners[:, 1:] - corners[:, :1]
        if legs.shape[1] == 1:
            return on_pieces(start, legs[:, 0], cuts, degree)
        return on_polygons(start, legs, cuts, degree, facet)

    return rule


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


FACET_SIDES = {
    basix.CellType.quadrilateral: ((0, (1, 0)), (1, (-1, 0)), (0, (0, 1)), (1, (0, -1))),
    basix.CellType.triangle: ((0, (1, 0)), (0, (0, 1)), (1, (-1, -1))),
}
"""Constant a and direction b of each side of the reference facets, inside of which a + b.x >= 0."""

SMALLEST_PIECE = 1e-10
"""Area over that of the reference square below which a piece, or a triangle of it, is left out."""


def on_polygons(
    start: Array, legs: Array, polygons: Array, degree: int, facet: basix.CellType
) -> Rule:
    """Gauss points on the parts of facets that lie in convex polygons.

    A facet with no polygon on it stays whole. What of another no polygon covers has no points:
    nothing is opposite to it. Facets are triangles or parallelograms, given by their first corners,
    (facets, 3), and the legs from there to the next two, (facets, 2, 3); polygons by the corners of
    the facets opposite, in turn, (n, k, 3), m, without overlap.
    """
    whole = facet_rule("gauss", degree, facet)
    piece = basix.make_quadrature(basix.CellType.triangle, 2 * degree)
    pieces = [
        _concatenated([_on_polygon(part, piece) for part in parts]) if parts else whole
        for parts in (
            _parts(start[k], legs[k], polygons, FACET_SIDES[facet]) for k in range(len(start))
        )
    ]
    if not pieces:
        return on_facets(0, whole)
    row = np.repeat(np.arange(len(pieces)), [len(weights) for _, weights in pieces])
    return row, *_concatenated(pieces)


def _concatenated(rules: list[tuple[Array, Array]]) -> tuple[Array, Array]:
    """Points and weights of several rules."""
    points, weights = zip(*rules, strict=True)
    return np.concatenate(points), np.concatenate(weights)


def _parts(
    start: Array, legs: Array, polygons: Array, sides: tuple[tuple[int, tuple[int, int]], ...]
) -> list[Array]:
    """Parts of one facet that lie in the polygons, each by its corners on the reference facet."""
    off = polygons - start
    local = off @ np.linalg.pinv(legs)
    away = np.abs(off - local @ legs).max(axis=(1, 2)) > ON_FACET * np.abs(legs).max()
    beside = (local.max(axis=1) <= 0).any(axis=1) | (local.min(axis=1) >= 1).any(axis=1)
    parts = []
    for polygon in local[~(away | beside)]:
        for constant, direction in sides:
            polygon = _half(polygon, constant + polygon @ direction)
        if len(polygon) > 2 and abs(_doubled_area(polygon)) > 2 * SMALLEST_PIECE:
            parts.append(polygon)
    return parts


def _half(polygon: Array, height: Array) -> Array:
    """The part of a convex polygon, (n, 2) in turn, where a linear function is not negative.

    By its values at the corners, (n,) (Sutherland, Hodgman).
    """
    corners = []
    for k in range(len(polygon)):
        here, there = height[k - 1], height[k]
        if here * there < 0:
            corners.append(polygon[k - 1] + here / (here - there) * (polygon[k] - polygon[k - 1]))
        if there >= 0:
            corners.append(polygon[k])
    return np.array(corners).reshape(-1, 2)


def _doubled_area(polygon: Array) -> float:
    """Twice the area of a polygon, positive where its corners run counterclockwise."""
    x, y = (polygon - polygon[0]).T
    return float(x[:-1] @ y[1:] - x[1:] @ y[:-1])


def _on_polygon(polygon: Array, rule: tuple[Array, Array]) -> tuple[Array, Array]:
    """A rule for triangles on each triangle of a fan over a convex polygon.

    Corners that coincide or lie in one line, which clipping leaves, make triangles without area:
    they are left out, since a point without weight could bear no pressure.
    """
    edges = np.stack([polygon[1:-1] - polygon[0], polygon[2:] - polygon[0]], axis=1)
    doubled = np.abs(np.linalg.det(edges))
    edges, doubled = edges[doubled > 2 * SMALLEST_PIECE], doubled[doubled > 2 * SMALLEST_PIECE]
    points = polygon[0] + np.einsum("qj,tji->tqi", rule[0], edges)
    weights = doubled[:, None] * rule[1]
    return points.reshape(-1, 2), weights.ravel()
