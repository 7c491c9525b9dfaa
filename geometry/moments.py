"""Volume, centre and second moments of what flat facets enclose, in the plane and in space."""

from __future__ import annotations

import math
from collections.abc import Iterable
from copy import copy
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from solver.types import Array, Indices

Shape = TypeVar("Shape")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Moments:
    """The moments of a region or of a mass; in the plane of an area, or of a mass per thickness."""

    volume: float
    """Integral of 1, m^3, in the plane m^2; of a mass its density is in it, kg or kg/m."""
    centre: Array
    """Centroid c, (d,), m."""
    spread: Array
    """Integral of (x - c) (x - c)^T, (d, d), m^5, in the plane m^4; kg m^2 or kg m of a mass."""

    def times(self, factor: float) -> Moments:
        """Moments of a region of uniform density, or of a plane region of some thickness."""
        return Moments(volume=factor * self.volume, centre=self.centre, spread=factor * self.spread)

    def moved(self, by: Array) -> Moments:
        """Moments of the region moved by a vector (d,), m."""
        return Moments(volume=self.volume, centre=self.centre + by, spread=self.spread)

    def rotated(self, rotation: Array) -> Moments:
        """Moments of the region turned about the origin by a rotation matrix (d, d)."""
        spread = rotation @ self.spread @ rotation.T
        return Moments(volume=self.volume, centre=rotation @ self.centre, spread=spread)

    @property
    def inertia(self) -> Array | float:
        """Inertia about the centre: tr(S) 1 - S of the spread S, (3, 3); in the plane tr(S)."""
        trace = float(np.trace(self.spread))
        return trace if len(self.centre) == 2 else trace * np.eye(3) - self.spread


def changed(shape: Shape, **fields: object) -> Shape:
    """A copy of a frozen shape with other fields, known to be as good: not checked again."""
    other = copy(shape)
    for name, value in fields.items():
        if isinstance(value, np.ndarray):
            value.setflags(write=False)
        object.__setattr__(other, name, value)
    return other


def moments_of(points: Array, facets: Indices) -> Moments:
    """Moments of the region that facets enclose: edges in the plane, triangles in space.

    Exact: each facet and one point near the middle make a simplex of signed volume V with corners
    v_i, and x x^T has there the integral V (sum v_i v_i^T + s s^T) / ((d + 1) (d + 2)), s = sum v_i
    (Eberly, "Polyhedral mass properties", 2002; Tonon, J. Math. Stat. 1, 2005).

    Args:
        points: (n, d), m.
        facets: Numbers of points, (m, d), anticlockwise: outwards is to the right of an edge, and
            where a triangle is seen from. The volume is negative where they are all turned round.
    """
    dimension = points.shape[1]
    used = points[facets]
    origin = used.reshape(-1, dimension).mean(axis=0)
    simplices = used - origin
    # By components: numpy's determinants of many small matrices are slower, and round as little.
    if dimension == 2:
        a, b = simplices[:, 0], simplices[:, 1]
        parts = (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2
    else:
        a, b, c = simplices[:, 0], simplices[:, 1], simplices[:, 2]
        parts = np.einsum("ni,ni->n", a, np.cross(b, c)) / 6
    volume = float(parts.sum())
    sums = simplices.sum(axis=1)
    first = parts @ sums / (dimension + 1)
    about_origin = (
        np.einsum("n,nki,nkj->ij", parts, simplices, simplices, optimize=True)
        + np.einsum("n,ni,nj->ij", parts, sums, sums, optimize=True)
    ) / ((dimension + 1) * (dimension + 2))
    if volume == 0:
        return Moments(volume=0.0, centre=origin, spread=about_origin)
    centre = first / volume
    spread = about_origin - volume * np.outer(centre, centre)
    return Moments(volume=volume, centre=origin + centre, spread=(spread + spread.T) / 2)


def together(all_of_them: Iterable[Moments]) -> Moments:
    """Moments of regions or masses that do not overlap, by Steiner's theorem."""
    parts = list(all_of_them)
    volume = math.fsum(part.volume for part in parts)
    # No product of matrices, which may fuse: what lies evenly has its centre exactly in the middle.
    centre: Array = np.sum([part.volume / volume * part.centre for part in parts], axis=0)
    spread: Array = np.zeros_like(parts[0].spread)
    for part in parts:
        arm = part.centre - centre
        spread += part.spread + part.volume * np.outer(arm, arm)
    return Moments(volume=volume, centre=centre, spread=spread)
