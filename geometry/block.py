"""The rectangular block and the numbers that rigid-body rocking is written in."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

FACES = (
    *((3, 2, 1, 0), (4, 5, 6, 7)),
    *((0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
)
"""Numbers of the corners around each face of a block in space, anticlockwise from outside: those of
the bottom, the top, the sides; corners as `Block.corners` has them, which is VTK's order, too."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """A homogeneous rectangular block, B x H x t; symbols after Housner (1963)."""

    width: float
    """B, m, > 0; in the plane of motion."""
    height: float
    """H, m, > 0."""
    thickness: float
    """t, m, > 0; across the plane of motion."""
    density: float
    """rho, kg/m^3, > 0."""

    def __post_init__(self) -> None:
        """Refuse what is no block."""
        for field in fields(self):
            value = getattr(self, field.name)
            if not (math.isfinite(value) and value > 0):
                raise ValueError(f"Block.{field.name}: got {value}, allowed a number > 0")

    @property
    def volume(self) -> float:
        """Volume V = B H t, m^3."""
        return self.width * self.height * self.thickness

    @property
    def mass(self) -> float:
        """Mass m = rho B H t, kg."""
        return self.density * self.width * self.height * self.thickness

    @property
    def half_diagonal(self) -> float:
        """Half diagonal R = sqrt(B^2 + H^2) / 2, m: from a corner to the centre."""
        return math.hypot(self.width, self.height) / 2

    @property
    def slenderness(self) -> float:
        """Slenderness alpha = atan(B / H), rad: where the block stands above its corner."""
        return math.atan2(self.width, self.height)

    @property
    def rotary_inertia(self) -> float:
        """Rotary inertia I = m (B^2 + H^2) / 12, kg m^2, about the centre."""
        return self.mass * self.half_diagonal**2 / 3

    @property
    def principal_inertias(self) -> tuple[float, float, float]:
        """Rotary inertias of the block in space about its centre, kg m^2, about x, y and z.

        m (t^2 + H^2)/12, m (B^2 + H^2)/12, m (B^2 + t^2)/12: x along the width, y along the
        thickness, z along the height; the inertia tensor in the block's frame is their diagonal.
        """
        b, t, h = self.width**2, self.thickness**2, self.height**2
        return self.mass * (t + h) / 12, self.mass * (b + h) / 12, self.mass * (b + t) / 12

    def half_lengths(self, dimension: int = 2) -> tuple[float, ...]:
        """Half its edges along x, in space y, and upwards, m."""
        b, t, h = self.width / 2, self.thickness / 2, self.height / 2
        return (b, h) if dimension == 2 else (b, t, h)

    def corners(self, dimension: int = 2) -> tuple[tuple[float, ...], ...]:
        """Its corners in its own frame (origin at the bottom centre), m.

        In the plane counterclockwise from the bottom left one; in space those of the bottom, then
        those of the top, both in that order seen from above.
        """
        b, t = self.width / 2, self.thickness / 2
        if dimension == 2:
            return (-b, 0.0), (b, 0.0), (b, self.height), (-b, self.height)
        ring = (-b, -t), (b, -t), (b, t), (-b, t)
        return tuple((x, y, z) for z in (0.0, self.height) for x, y in ring)

    @property
    def rotary_inertia_about_corner(self) -> float:
        """Rotary inertia I_O = 4/3 m R^2, kg m^2, about a bottom corner."""
        return 4 / 3 * self.mass * self.half_diagonal**2

    def frequency(self, gravity: float) -> float:
        """Frequency parameter of rocking p = sqrt(3 g / (4 R)), 1/s, at gravity g (m/s^2)."""
        return math.sqrt(3 * gravity / (4 * self.half_diagonal))

    def weight(self, gravity: float) -> float:
        """Weight W = m g, N, at gravity g (m/s^2)."""
        return self.mass * gravity
