"""St. Venant-Kirchhoff: Hooke's law between second Piola-Kirchhoff stress and Green strain.

The law of the paper's plane elements with large deflection: linear elasticity in a body that may
rotate by any angle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

Plane: TypeAlias = Literal["strain", "stress", "solid"]
"""Plane strain, plane stress, or a body in space."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Material:
    """Isotropic elastic material.

    Attributes:
        young: Young's modulus E, Pa.
        poisson: Poisson's ratio nu, 0 <= nu < 0.5.
        density: rho, kg/m3.
        plane: "strain", "stress", or "solid" in 3-D.
    """

    young: float
    poisson: float
    density: float
    plane: Plane = "strain"

    @property
    def shear(self) -> float:
        """Second Lame constant mu, Pa."""
        return self.young / (2 * (1 + self.poisson))

    @property
    def lame(self) -> float:
        """First Lame constant lambda, Pa; in plane stress 2 lambda mu/(lambda + 2 mu)."""
        nu = self.poisson
        lame = self.young * nu / ((1 + nu) * (1 - 2 * nu))
        if self.plane == "stress":
            return 2 * lame * self.shear / (lame + 2 * self.shear)
        return lame

    @property
    def longitudinal(self) -> float:
        """Lambda + 2 mu, Pa: the stiffness against a contact pressure."""
        return self.lame + 2 * self.shear

    @property
    def wave_speed(self) -> float:
        """Speed of sound along a bar c = sqrt(E/rho), m/s."""
        return math.sqrt(self.young / self.density)

    def times(self, thickness: float) -> Material:
        """The material of a plate of this thickness: forces per metre become whole forces."""
        return replace(self, young=self.young * thickness, density=self.density * thickness)
