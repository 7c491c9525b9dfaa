"""What carries the blocks."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, kw_only=True)
class RigidFoundation:
    """A rigid plane that moves with the ground: nothing to mesh, no unknowns."""

    point: tuple[float, float] = (0.0, 0.0)
    """A point of the surface, m."""
    normal: tuple[float, float] = (0.0, 1.0)
    """Unit normal, out of the foundation."""

    def __post_init__(self) -> None:
        """Refuse a normal that is not of length 1."""
        if not math.isclose(math.hypot(*self.normal), 1, rel_tol=1e-12):
            raise ValueError(
                f"RigidFoundation.normal: got {self.normal}, allowed a vector of length 1"
            )

    @property
    def tangent(self) -> tuple[float, float]:
        """Unit tangent: the normal turned clockwise, +x where the normal is +y."""
        return self.normal[1], -self.normal[0]

    def gap(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Distance of points (n, 2) above the surface, m, (n,); negative below it."""
        gap: NDArray[np.float64] = (points - np.array(self.point)) @ np.array(self.normal)
        return gap
