"""The rectangular block and the numbers that rigid-body rocking is written in."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields


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
    def rotary_inertia_about_corner(self) -> float:
        """Rotary inertia I_O = 4/3 m R^2, kg m^2, about a bottom corner."""
        return 4 / 3 * self.mass * self.half_diagonal**2

    def frequency(self, gravity: float) -> float:
        """Frequency parameter of rocking p = sqrt(3 g / (4 R)), 1/s, at gravity g (m/s^2)."""
        return math.sqrt(3 * gravity / (4 * self.half_diagonal))

    def weight(self, gravity: float) -> float:
        """Weight W = m g, N, at gravity g (m/s^2)."""
        return self.mass * gravity
