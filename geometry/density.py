"""Density of a block that is not the same everywhere: linear, or other in some parts.

Points are given in the block's own frame, whose origin is the middle of its bottom.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING, ClassVar, NamedTuple, Protocol, TypeAlias

if TYPE_CHECKING:
    from geometry.convex import Convex
    from geometry.moments import Moments
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
    def moments(self) -> Moments:
        """Mass, centre and second moments of one in space."""
        import numpy as np

        from geometry.moments import Moments

        sides = np.subtract(self.high, self.low)
        mass = self.density * float(np.prod(sides))
        centre = np.add(self.low, self.high) / 2
        return Moments(volume=mass, centre=centre, spread=np.diag(mass * sides**2 / 12))


def tensor_of(rows: Array | Sequence[Sequence[float]]) -> Tensor:
    """Rows of numbers as a tensor."""
    first, second, third = ((float(row[0]), float(row[1]), float(row[2])) for row in rows)
    return first, second, third


def linear_tensor(mass: float, about_middle: Vector, off: Vector) -> Tensor:
    """Inertia tensor about the centre of mass of a box whose density varies linearly, kg m2.

    The second moments about the middle are those of the homogeneous box: what is odd adds nothing.

    Args:
        mass: kg.
        about_middle: Rotary inertias of the homogeneous box about its middle, kg m2.
        off: Centre of mass from the middle, m.
    """
    square = sum(part * part for part in off)
    return tensor_of(
        [
            [
                (about_middle[i] if i == k else 0.0)
                - mass * ((square if i == k else 0.0) - off[i] * off[k])
                for k in range(3)
            ]
            for i in range(3)
        ]
    )


def mass_of_parts(sizes: Vector, rest: float, parts: Sequence[Part]) -> Moments:
    """Mass, centre and second moments of a block of a density with parts of others, in space.

    Args:
        sizes: B, t and H, m.
        rest: Density of the rest, kg/m3.
        parts: In space.
    """
    from geometry.moments import together

    b, t, h = sizes
    whole = Part((-b / 2, -t / 2, 0.0), (b / 2, t / 2, h), rest)
    others = (part._replace(density=part.density - rest) for part in parts)
    return together(box.moments for box in (whole, *others))


class Density(Protocol):
    """How the density of a block varies in its own frame, over the mean."""

    degree: ClassVar[int]
    """0: it is the same all over a cell of a mesh; 1: it varies linearly there."""

    def in_cells(self, cells: Array) -> Array:
        """Its values in cells by their vertices (n, k, d), m: there, (n, k), or in each, (n,)."""

    def least(self, cell: Sequence[float]) -> float:
        """The least of its means over cells with edges of these lengths (m) along the axes."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LinearDensity:
    """rho over its mean: 1 + a (x - middle), which moves the centre of mass of a box.

    With the centre off by e, a = 12 e/L^2 along an edge of length L.
    """

    degree: ClassVar[int] = 1

    off: tuple[float, ...]
    """Centre of mass from the middle, m."""
    sizes: tuple[float, ...]
    """Edges of the box, m."""

    @property
    def reach(self) -> float:
        """Sum of |e|/L, up to 1/6 of which the density is nowhere negative."""
        return sum(abs(e) / length for e, length in zip(self.off, self.sizes, strict=True))

    def least(self, cell: Sequence[float]) -> float:
        """The least of its means over cells with edges of these lengths (m) along the axes."""
        return 1 - sum(
            6 * abs(e) / length * (1 - edge / length)
            for e, length, edge in zip(self.off, self.sizes, cell, strict=True)
        )

    def in_cells(self, cells: Array) -> Array:
        """Its values at the vertices of cells (n, k, d), m, (n, k)."""
        import numpy as np

        sizes, middle = np.array(self.sizes), np.zeros(len(self.sizes))
        middle[-1] = sizes[-1] / 2
        return np.asarray(1 + (cells - middle) @ (12 * np.array(self.off) / sizes**2))


@dataclass(frozen=True, slots=True, kw_only=True)
class PartedDensity:
    """rho over its mean: that of the rest, and those of the parts."""

    degree: ClassVar[int] = 0

    rest: float
    """Density of the rest over the mean."""
    parts: tuple[Part, ...]
    """Their densities are over the mean."""

    def least(self, cell: Sequence[float]) -> float:
        """The least density of all parts over the mean."""
        return min(self.rest, *(part.density for part in self.parts))

    def in_cells(self, cells: Array) -> Array:
        """Its mean over each of some cells, (n,), by their vertices (n, k, d), m.

        Cells are simplices, or boxes along the axes.
        """
        import numpy as np

        low, high = cells.min(axis=1), cells.max(axis=1)
        simplices = cells.shape[1] == cells.shape[2] + 1
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

    degree: ClassVar[int] = 0

    parts: tuple[Convex, ...]
    """The parts, which have densities of their own."""
    mean: float
    """Mean of the body, kg/m^3."""

    def least(self, cell: Sequence[float]) -> float:
        """The least density of all parts over the mean."""
        return min(part.density for part in self.parts) / self.mean

    def in_cells(self, cells: Array) -> Array:
        """Its value in cells of which each is in one part, (n,), by their vertices (n, k, d), m."""
        import numpy as np

        middles = cells.mean(axis=1)
        off = [part.beyond(middles) for part in self.parts]
        values = np.array([part.density for part in self.parts]) / self.mean
        return np.asarray(values[np.argmin(off, axis=0)])


@dataclass(frozen=True, slots=True, kw_only=True)
class FootedDensity:
    """rho over its mean of a box between its feet, which hold next to none of the mass."""

    degree: ClassVar[int] = 1

    low: float
    """Level of the bottom of the box, m."""
    high: float
    """Level of its top, m."""
    box: float
    """Mean density of the box over that of the whole."""
    feet: float
    """The density of the feet over that of the whole."""
    law: Density | None
    """How it varies in the box, over the mean there; None: it does not."""

    def least(self, cell: Sequence[float]) -> float:
        """The least of it, that of the feet."""
        return self.feet

    def in_cells(self, cells: Array) -> Array:
        """Its values in simplices at their vertices (n, k, d), m, (n, k)."""
        import numpy as np

        lifted = cells.copy()
        lifted[:, :, -1] -= self.low
        values = np.full(cells.shape[:2], self.box)
        if self.law is not None:
            values *= self.law.in_cells(lifted).reshape(len(cells), -1)
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
