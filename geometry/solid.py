"""Bodies of any shape, of convex parts: mass, centre and inertia.

A solid stands for a body in its own frame, in the plane (x, upwards) or in space (x, y, upwards).
Contact sees its convex parts; its mass properties come from them, too, or from a surface of its own
where the parts are only a hull around it. `geometry.shapes` makes them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from geometry.convex import Convex, refuse_density
from geometry.moments import Moments, together
from geometry.polygon import NEAR, size_of
from geometry.surface import Surface
from solver.types import Array

SINGLE = 1e-6
"""What a number of single precision, as most files of surfaces have them, is good for as a part of
the size: corners so near to a plane are on it."""

MOST_PARTS = 512
"""Convex parts that a body may have: contacts are told apart by their numbers (`Feature::id`)."""

MOST_EDGES = 1 << 16
"""Edges that a part may have, for the same reason; it has fewer corners and faces."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Solid:
    """A rigid body's shape and mass, of convex parts that do not overlap.

    Raises:
        ValueError: no parts, parts of the plane and of space, a thickness or density <= 0, a
            surface without density or the other way round.
    """

    parts: tuple[Convex, ...]
    """What contact sees."""
    thickness: float = 1.0
    """t, m, > 0, across the plane; not used in space."""
    surface: Surface | None = None
    """The true surface, in space, that volume, mass, centre and inertia are of; else of parts."""
    density: float | None = None
    """rho within the surface, kg/m^3, > 0; None without one: each part has its own."""
    coarse: float = 0.0
    """How far points of the surface may be outside of the parts, m."""
    masses: Moments = field(init=False)
    """Mass, centre and its second moments about it."""

    def __post_init__(self) -> None:
        """Refuse what is no body, and integrate."""
        if not self.parts:
            raise ValueError("Solid.parts: got none, allowed one or more")
        if len({part.dimension for part in self.parts}) > 1:
            raise ValueError(
                "Solid.parts: got polygons and polyhedra, allowed parts of one dimension"
            )
        refuse_not_positive("Solid.thickness", self.thickness)
        _refuse_too_many(self.parts)
        if self.surface is None:
            if self.density is not None:
                raise ValueError(
                    f"Solid.density: got {self.density}, allowed None without a surface:"
                    " parts have densities of their own"
                )
            deep = self.thickness if self.dimension == 2 else 1.0
            masses = together(part.moments.times(part.density * deep) for part in self.parts)
        else:
            refuse_density(self.density, "Solid.density")
            if self.dimension == 2:
                raise ValueError("Solid.surface: got a surface, allowed None in the plane")
            masses = self.surface.moments.times(self.density or 0.0)
        object.__setattr__(self, "masses", masses)

    @property
    def dimension(self) -> int:
        """2 in the plane, 3 in space."""
        return self.parts[0].dimension

    @property
    def volume(self) -> float:
        """V, m^3; of the surface where there is one."""
        return self.parts_volume if self.surface is None else self.surface.volume

    @property
    def parts_volume(self) -> float:
        """Volume of the convex parts, m^3."""
        deep = self.thickness if self.dimension == 2 else 1.0
        return deep * math.fsum(part.moments.volume for part in self.parts)

    @property
    def hull_excess(self) -> float:
        """Volume of the parts over that of the surface, minus 1; 0 without a surface.

        Below 0 where a coarse hull is smaller than a convex surface.
        """
        return 0.0 if self.surface is None else self.parts_volume / self.surface.volume - 1

    @property
    def is_convex(self) -> bool:
        """True if it is one convex part, and no more than that."""
        return len(self.parts) == 1 and self.hull_excess <= SINGLE

    @property
    def mass(self) -> float:
        """Mass m, kg."""
        return self.masses.volume

    @property
    def centre(self) -> Array:
        """Centre of mass, (d,), m."""
        return self.masses.centre

    @property
    def inertia(self) -> Array | float:
        """Inertia about the centre, kg m^2: the tensor (3, 3); in the plane a number, across it."""
        return self.masses.inertia

    @property
    def corners(self) -> Array:
        """Corners of all parts, part after part, (n, d), m; twice where two parts have one."""
        return np.concatenate([part.corners for part in self.parts])

    @property
    def low(self) -> Array:
        """Lower corner of the box around the parts, (d,), m."""
        return np.asarray(self.corners.min(axis=0))

    @property
    def high(self) -> Array:
        """Upper corner of the box around the parts, (d,), m."""
        return np.asarray(self.corners.max(axis=0))

    @property
    def size(self) -> float:
        """The longest side of the box around the parts, m."""
        return size_of(self.corners)

    @property
    def bottom(self) -> Array:
        """Corners at the lowest level, within 1e-9 of the size, (n, d), m; each place once."""
        corners = self.corners
        level = corners[:, -1].min() + NEAR * self.size
        return np.unique(corners[corners[:, -1] <= level], axis=0)

    def moved(self, by: ArrayLike) -> Solid:
        """This body moved by a vector (d,), m."""
        surface = None if self.surface is None else self.surface.moved(by)
        return replace(self, parts=tuple(part.moved(by) for part in self.parts), surface=surface)

    def rotated(self, rotation: ArrayLike) -> Solid:
        """This body turned about the origin by a rotation matrix (d, d)."""
        matrix = np.asarray(rotation, dtype=np.float64)
        dimension = self.dimension
        right = matrix.shape == (dimension, dimension) and np.allclose(
            matrix @ matrix.T, np.eye(dimension), atol=1e-9
        )
        if not (right and np.linalg.det(matrix) > 0):
            raise ValueError(
                f"rotation: got {matrix.tolist()}, allowed a rotation matrix"
                f" ({dimension}, {dimension})"
            )
        surface = None if self.surface is None else self.surface.rotated(matrix)
        return replace(
            self, parts=tuple(part.rotated(matrix) for part in self.parts), surface=surface
        )

    def with_mass(self, mass: float) -> Solid:
        """This body with a mass, kg: all densities by one factor."""
        refuse_not_positive("mass", mass)
        factor = mass / self.mass
        parts = tuple(part.with_density(factor * part.density) for part in self.parts)
        density = None if self.density is None else factor * self.density
        return replace(self, parts=parts, density=density)

    def standing(self) -> Solid:
        """This body in the own frame of a block: the origin in the middle of its bottom.

        Its lowest level is 0, and the middle of the rectangle around its bottom is at x = (y =) 0.
        """
        bottom = self.bottom
        middle = (bottom.min(axis=0) + bottom.max(axis=0)) / 2
        return self.moved(-np.append(middle[:-1], self.low[-1]))


def refuse_not_positive(name: str, value: float) -> None:
    """Lengths and masses are finite and > 0."""
    if not (math.isfinite(value) and value > 0):
        raise ValueError(f"{name}: got {value}, allowed a number > 0")


def _refuse_too_many(parts: Sequence[Convex]) -> None:
    """More parts, or edges of a part, than contacts can have numbers of."""
    if len(parts) > MOST_PARTS:
        raise ValueError(f"Solid.parts: got {len(parts)}, allowed at most {MOST_PARTS}")
    edges = max(len(part.corners) + len(part.faces) - 2 for part in parts)
    if edges > MOST_EDGES:
        raise ValueError(
            f"Solid.parts: got one of {edges} edges, allowed at most {MOST_EDGES}; make it coarser"
        )
