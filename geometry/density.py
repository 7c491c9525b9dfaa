"""Density of a block that is not the same everywhere: linear, or other in some parts.

Points are given in the block's own frame, whose origin is the middle of its bottom.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

if TYPE_CHECKING:
    from geometry.convex import Convex
    from solver.types import Array

Vector: TypeAlias = tuple[float, float, float]
Tensor: TypeAlias = tuple[Vector, Vector, Vector]


class Part(NamedTuple):
    """A box of another density; in the plane it is as thick as the block."""

    low: tuple[float, ...]
    """Its lowest corner, m."""
    high: tuple[float, ...]
    """Its highest corner, m."""
    density: float
    """kg/m3."""

    @property
    def volume(self) -> float:
        """m3; in the plane m2."""
        found = 1.0
        for low, high in zip(self.low, self.high, strict=True):
            found *= high - low
        return found

    @property
    def middle(self) -> tuple[float, ...]:
        """M."""
        return tuple((low + high) / 2 for low, high in zip(self.low, self.high, strict=True))


class Mass(NamedTuple):
    """Mass properties of a body in space."""

    mass: float
    """kg."""
    centre: Vector
    """Of mass, m."""
    tensor: Tensor
    """Inertia tensor about the centre, kg m2."""


def linear_tensor(mass: float, about_middle: Vector, off: Vector) -> Tensor:
    """Inertia tensor about the centre of mass of a box whose density varies linearly, kg m2.

    The second moments about the middle are those of the homogeneous box: what is odd adds nothing.

    Args:
        mass: kg.
        about_middle: Rotary inertias of the homogeneous box about its middle, kg m2.
        off: Centre of mass from the middle, m.
    """
    moved = _point_tensor(mass, off)
    diagonal = [[about_middle[i] if i == k else 0.0 for k in range(3)] for i in range(3)]
    return _tensor([[diagonal[i][k] - moved[i][k] for k in range(3)] for i in range(3)])


def mass_of_parts(sizes: Vector, rest: float, parts: Sequence[Part]) -> Mass:
    """Mass, centre and inertia of a block of a density with parts of others, in space.

    Args:
        sizes: B, t and H, m.
        rest: Density of the rest, kg/m3.
        parts: In space.
    """
    b, t, h = sizes
    whole = Part((-b / 2, -t / 2, 0.0), (b / 2, t / 2, h), rest)
    boxes = [whole, *(part._replace(density=part.density - rest) for part in parts)]
    masses = [box.density * box.volume for box in boxes]
    mass = sum(masses)
    middles = [box.middle for box in boxes]
    x, y, z = (
        sum(m * middle[i] for m, middle in zip(masses, middles, strict=True)) / mass
        for i in range(3)
    )
    total = [[0.0] * 3 for _ in range(3)]
    for box, own, middle in zip(boxes, masses, middles, strict=True):
        squares = [(high - low) ** 2 / 12 for low, high in zip(box.low, box.high, strict=True)]
        moved = _point_tensor(own, (middle[0] - x, middle[1] - y, middle[2] - z))
        for i in range(3):
            total[i][i] += own * (sum(squares) - squares[i])
            for k in range(3):
                total[i][k] += moved[i][k]
    return Mass(mass, (x, y, z), _tensor(total))


def _point_tensor(mass: float, place: Vector) -> list[list[float]]:
    """Inertia tensor of a mass (kg) at a place (m) about the origin, kg m2."""
    square = sum(part * part for part in place)
    return [
        [mass * ((square if i == k else 0.0) - place[i] * place[k]) for k in range(3)]
        for i in range(3)
    ]


def _tensor(rows: Sequence[Sequence[float]]) -> Tensor:
    """Rows as a tensor."""
    first, second, third = ((row[0], row[1], row[2]) for row in rows)
    return first, second, third


@dataclass(frozen=True, slots=True, kw_only=True)
class LinearDensity:
    """rho over its mean: 1 + a (x - middle), which moves the centre of mass of a box.

    With the centre off by e, a = 12 e/L^2 along an edge of length L.
    """

    off: tuple[float, ...]
    """Centre of mass from the middle, m."""
    sizes: tuple[float, ...]
    """Edges of the box, m."""

    @property
    def reach(self) -> float:
        """Sum of |e|/L, up to 1/6 of which the density is nowhere negative."""
        return sum(abs(e) / length for e, length in zip(self.off, self.sizes, strict=True))

    def least(self, counts: Sequence[float]) -> float:
        """The least mean over a cell, by the numbers of equal cells along the edges."""
        return 1 - sum(
            6 * abs(e) / length * (1 - 1 / count)
            for e, length, count in zip(self.off, self.sizes, counts, strict=True)
        )

    def at(self, points: Array) -> Array:
        """Its values at points (n, d), (n,)."""
        import numpy as np

        sizes, middle = np.array(self.sizes), np.zeros(len(self.sizes))
        middle[-1] = sizes[-1] / 2
        return np.asarray(1 + (points - middle) @ (12 * np.array(self.off) / sizes**2))


@dataclass(frozen=True, slots=True, kw_only=True)
class PartedDensity:
    """rho over its mean: that of the rest, and those of the parts."""

    rest: float
    """Density of the rest over the mean."""
    parts: tuple[Part, ...]
    """Their densities are over the mean."""

    def means(self, cells: Array, *, simplices: bool) -> Array:
        """Its mean over each of some cells, (n,), by their vertices (n, k, d), m.

        Cells are simplices, or boxes along the axes.
        """
        import numpy as np

        low, high = cells.min(axis=1), cells.max(axis=1)
        found = np.full(len(cells), self.rest)
        for part in self.parts:
            inside = np.minimum(high, part.high) - np.maximum(low, part.low)
            share = np.prod(np.clip(inside, 0.0, None) / (high - low), axis=1)
            if simplices:
                # Round-off of vertices on a face of the part makes no sliver.
                cut = np.all(inside > 1e-12 * (high - low), axis=1) & (share < 1)
                for number in np.flatnonzero(cut):
                    share[number] = share_in_box(cells[number], part.low, part.high)
            found += share * (part.density - self.rest)
        return found


@dataclass(frozen=True, slots=True, kw_only=True)
class PiecewiseDensity:
    """rho over its mean: that of each of some convex parts that make up a body."""

    parts: tuple[Convex, ...]
    """The parts, which have densities of their own."""
    mean: float
    """Mean of the body, kg/m^3."""

    @property
    def least(self) -> float:
        """The least of them."""
        return min(part.density for part in self.parts) / self.mean

    def means(self, cells: Array) -> Array:
        """Its value in cells of which each is in one part, (n,), by their vertices (n, k, d), m."""
        import numpy as np

        middles = cells.mean(axis=1)
        off = [part.beyond(middles) for part in self.parts]
        values = np.array([part.density for part in self.parts]) / self.mean
        return np.asarray(values[np.argmin(off, axis=0)])


@dataclass(frozen=True, slots=True, kw_only=True)
class FootedDensity:
    """rho over its mean of a box between its feet, which hold next to none of the mass."""

    low: float
    """Level of the bottom of the box, m."""
    high: float
    """Level of its top, m."""
    box: float
    """Mean of the box over that of the whole."""
    feet: float
    """That of the feet over that of the whole."""
    law: LinearDensity | PartedDensity | None
    """How it varies in the box, over the mean there; None: it does not."""

    @property
    def least(self) -> float:
        """The least of it, that of the feet."""
        return self.feet

    def at_vertices(self, cells: Array) -> Array:
        """Its value in simplices at their vertices (n, k, d), m, (n, k)."""
        import numpy as np

        lifted = cells.copy()
        lifted[:, :, -1] -= self.low
        values = np.full(cells.shape[:2], self.box)
        if isinstance(self.law, LinearDensity):
            values *= self.law.at(lifted)
        elif self.law is not None:
            values *= self.law.means(lifted, simplices=True)[:, None]
        middle = cells[:, :, -1].mean(axis=1)
        values[(middle < self.low) | (middle > self.high)] = self.feet
        return values


def share_in_box(simplex: Array, low: Sequence[float], high: Sequence[float]) -> float:
    """Part of a simplex, (d + 1, d), that is in a box, by cutting it along the faces."""
    import numpy as np

    pieces = [simplex]
    for axis, (first, last) in enumerate(zip(low, high, strict=True)):
        for sign, bound in ((1.0, first), (-1.0, last)):
            pieces = [half for piece in pieces for half in _beyond(piece, axis, sign, bound)]
    volumes = [abs(np.linalg.det(piece[1:] - piece[0])) for piece in [simplex, *pieces]]
    return float(sum(volumes[1:]) / volumes[0])


def _beyond(simplex: Array, axis: int, sign: float, bound: float) -> list[Array]:
    """Simplices that make up the part of one where sign (x - bound) > 0 along an axis.

    An edge that crosses the plane is cut there, which leaves two simplices with fewer such edges.
    """
    height = sign * (simplex[:, axis] - bound)
    if height.max() <= 0:
        return []
    if height.min() >= 0:
        return [simplex]
    for i, k in combinations(range(len(simplex)), 2):
        if height[i] * height[k] < 0:
            cut = (height[i] * simplex[k] - height[k] * simplex[i]) / (height[i] - height[k])
            cut[axis] = bound
            halves = simplex.copy(), simplex.copy()
            halves[0][i], halves[1][k] = cut, cut
            return [piece for half in halves for piece in _beyond(half, axis, sign, bound)]
    return []
