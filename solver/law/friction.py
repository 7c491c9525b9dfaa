"""Friction: the law of a surface, and the bounds that it sets to the forces of contact points.

A closed point holds |f_t| <= w (c + mu l_n). The coefficient falls from its static to its dynamic
value with the speed v of sliding,

    mu = mu_d + (mu_s - mu_d) exp(-DC v)

or, where DC = 0, as soon as the point has slipped.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from solver.types import Array, Mask


@dataclass(frozen=True, slots=True, kw_only=True)
class FrictionLaw:
    """Coulomb's law with a coefficient that depends on sliding, and cohesion.

    Attributes:
        static: Coefficient at rest, mu_s.
        dynamic: Coefficient of fast sliding, mu_d.
        decay: DC, s/m; 0: the coefficient jumps when a point slips.
        cohesion: c, Pa: what a closed point holds without pressure.
        cohesion_lost: Whether a point that has broken loose has no cohesion any more.
    """

    static: float
    dynamic: float
    decay: float = 0.0
    cohesion: float = 0.0
    cohesion_lost: bool = False

    @classmethod
    def coulomb(cls, mu: float) -> FrictionLaw:
        """One coefficient, no cohesion."""
        return cls(static=mu, dynamic=mu)

    @property
    def constant(self) -> bool:
        """Whether the bound depends on the pressure alone: neither on speed nor on the past."""
        return self.static == self.dynamic and self.cohesion == 0.0

    @property
    def decays(self) -> bool:
        """Whether the coefficient depends on the speed of sliding."""
        return self.decay > 0 and self.static != self.dynamic

    def coefficient(self, speed: Array, slipped: Mask) -> Array:
        """The coefficient mu of each point, (m,).

        Args:
            speed: Of sliding, (m,), m/s.
            slipped: Points that slipped in the step before; of meaning only where DC = 0.
        """
        rise = self.static - self.dynamic
        if self.decay:
            return np.asarray(self.dynamic + rise * np.exp(-self.decay * speed))
        return np.where(slipped, self.dynamic, self.static)

    def adhesion(self, weight: Array, broken: Mask) -> Array:
        """The force w c of each point, (m,), 0 where cohesion is lost.

        Args:
            weight: Length or area of the points, (m,), m or m2.
            broken: Points that have slipped or opened before.
        """
        force = self.cohesion * weight
        return np.where(broken, 0.0, force) if self.cohesion_lost else force


@dataclass(frozen=True, slots=True)
class Bounds:
    """The tangential forces that points can hold where they are closed: |f_t| <= c + mu f_n.

    Attributes:
        mu: Coefficients, (m,).
        cohesion: Forces c, (m,), N (per metre of thickness in 2-D), or impulses.
        frictionless: Whether all of them are zero.
    """

    mu: Array
    cohesion: Array
    frictionless: bool = field(init=False)

    def __post_init__(self) -> None:
        """Look once whether there is any friction."""
        object.__setattr__(self, "frictionless", not (self.mu.any() or self.cohesion.any()))

    @classmethod
    def uniform(cls, mu: float, m: int) -> Bounds:
        """One coefficient for m points, no cohesion."""
        return cls(np.full(m, mu), np.zeros(m))
