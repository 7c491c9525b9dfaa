"""Planes at any tilt: gaps of what stands on them, and their frames."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class TiltedPlane:
    """A plane by a point and its normal."""

    point: tuple[float, ...] = (0.0, 0.0)
    """A point of the surface, m; two numbers in the plane, three in space."""
    normal: tuple[float, ...] = (0.0, 1.0)
    """Unit normal, upwards."""

    def __post_init__(self) -> None:
        """Refuse a normal that is not of length 1 or not of the point's dimension."""
        if len(self.point) not in (2, 3) or len(self.normal) != len(self.point):
            raise ValueError(
                f"TiltedPlane: got point {self.point} and normal {self.normal},"
                " allowed two or three numbers each"
            )
        if not math.isclose(math.hypot(*self.normal), 1, rel_tol=1e-12):
            raise ValueError(f"TiltedPlane.normal: got {self.normal}, allowed a vector of length 1")

    @classmethod
    def level(cls, dimension: int, up: float = 1.0) -> TiltedPlane:
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
