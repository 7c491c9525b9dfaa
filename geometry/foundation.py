"""Shapes of the bodies that carry the blocks."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np

from solver.types import Array


@dataclass(frozen=True, slots=True, kw_only=True)
class RigidFoundation:
    """A rigid plane that moves with the ground: nothing to mesh, no unknowns."""

    point: tuple[float, ...] = (0.0, 0.0)
    """A point of the surface, m; two numbers in the plane, three in space."""
    normal: tuple[float, ...] = (0.0, 1.0)
    """Unit normal, out of the foundation."""

    def __post_init__(self) -> None:
        """Refuse a normal that is not of length 1 or not of the point's dimension."""
        if len(self.point) not in (2, 3) or len(self.normal) != len(self.point):
            raise ValueError(
                f"RigidFoundation: got point {self.point} and normal {self.normal},"
                " allowed two or three numbers each"
            )
        if not math.isclose(math.hypot(*self.normal), 1, rel_tol=1e-12):
            raise ValueError(
                f"RigidFoundation.normal: got {self.normal}, allowed a vector of length 1"
            )

    @classmethod
    def level(cls, dimension: int, up: float = 1.0) -> RigidFoundation:
        """The horizontal plane at level 0, looking up, or down with `up` = -1."""
        normal = (0.0,) * (dimension - 1) + (up,)
        return cls(point=(0.0,) * dimension, normal=normal)

    @property
    def dimension(self) -> int:
        """2 in the plane, 3 in space."""
        return len(self.point)

    @property
    def tangent(self) -> tuple[float, float]:
        """Unit tangent in the plane: the normal turned clockwise, +x where the normal is +y."""
        x, y = self.normal
        return y, -x

    @property
    def frame(self) -> Array:
        """Rows n, t in the plane; n, t1, t2 in space, with t1 = +x and t2 = +y where n = +z."""
        if self.dimension == 2:
            return np.array([self.normal, self.tangent])
        return np.array([self.normal, *_tangents(*self.normal)])

    def gap(self, points: Array) -> Array:
        """Distance of points (n, d) above the surface, m, (n,); negative below it."""
        gap: Array = (points - np.array(self.point)) @ np.array(self.normal)
        return gap


def _tangents(x: float, y: float, z: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """The two that the shortest turn from +z to a unit normal makes of +x and +y.

    After Duff et al. (2017), Building an orthonormal basis, revisited; also for normals that point
    downwards.
    """
    sign = math.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    return (1.0 + sign * x * x * a, sign * b, -sign * x), (b, sign + y * y * a, -y)


def _refuse_what_is_not_positive(shape: Plate | Frame, names: tuple[str, ...]) -> None:
    """Lengths are finite and > 0."""
    for name in names:
        value = getattr(shape, name)
        if not (math.isfinite(value) and value > 0):
            raise ValueError(f"{type(shape).__name__}.{name}: got {value}, allowed a number > 0")


@dataclass(frozen=True, slots=True, kw_only=True)
class Plate:
    """An elastic plate that blocks stand on; origin at the centre of its top."""

    width: float
    """W, m, > 0; along x."""
    height: float
    """h, m, > 0; from -h to 0."""
    thickness: float = 1.0
    """t, m, > 0; across the plane of motion."""

    def __post_init__(self) -> None:
        """Refuse what is no plate."""
        _refuse_what_is_not_positive(self, tuple(field.name for field in fields(self)))

    @property
    def volume(self) -> float:
        """W h t, m^3."""
        return self.width * self.height * self.thickness


@dataclass(frozen=True, slots=True, kw_only=True)
class Frame:
    """A deck on columns that are fixed at their feet; origin at the centre of the deck's top.

    In the plane the columns are as thick as the deck. In space the deck stands on four of them, one
    under each corner (one bay).
    """

    deck: Plate
    """The deck."""
    column_width: float
    """Width of a column along x, m, > 0."""
    storey: float
    """Length of the columns, from their feet to the underside of the deck, m, > 0."""
    bays: int = 1
    """Spaces between columns, >= 1: bays + 1 columns, at equal distances, the outer ones flush."""
    column_thickness: float | None = None
    """Thickness of a column across the plane of motion, m, > 0, in space; None: as its width."""

    def __post_init__(self) -> None:
        """Refuse what is no frame."""
        _refuse_what_is_not_positive(self, ("column_width", "storey"))
        if self.bays < 1:
            raise ValueError(f"Frame.bays: got {self.bays}, allowed a whole number >= 1")
        if not self.bay > 0:
            raise ValueError(
                f"Frame.column_width: got {self.column_width}, allowed less than"
                f" {self.deck.width / (self.bays + 1)}: the columns leave no bay under the deck"
            )
        if self.column_thickness is not None and not (
            0 < 2 * self.column_thickness < self.deck.thickness
        ):
            raise ValueError(
                f"Frame.column_thickness: got {self.column_thickness}, allowed more than 0 and less"
                f" than half the deck's {self.deck.thickness}"
            )

    @property
    def bay(self) -> float:
        """Clear distance between two columns, m."""
        return (self.deck.width - (self.bays + 1) * self.column_width) / self.bays
