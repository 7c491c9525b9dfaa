"""Friction of a block that stays flat, per unit of its mass: an acceleration, m/s^2."""

from __future__ import annotations

import math
from dataclasses import dataclass

from solver.scene import FrictionSpec


@dataclass(frozen=True, slots=True, kw_only=True)
class Resistance:
    """Limit of friction at rest, and its force while the block slides.

    tau = c + mu p, mu = mu_d + (mu_s - mu_d) exp(-DC v). With DC = 0 a block that sticks is held by
    mu_s and one that slides has mu_d, also while its velocity passes through zero.
    """

    law: FrictionSpec
    cohesion: float = 0.0
    """c times the area of the base over the mass, m/s^2."""

    @property
    def none(self) -> bool:
        """True without any friction."""
        return self.law.static == 0 and self.cohesion == 0

    def holds(self, normal: float, slipped: bool) -> float:
        """Largest force on a block that sticks, m/s^2; `slipped`: it has slid before."""
        return self._cohesion(slipped) + self.law.static * normal

    def slides(self, normal: float, speed: float) -> float:
        """Force on a block that slides at a speed |v|, m/s, by its normal force, m/s^2."""
        law = self.law
        jump = law.static - law.dynamic if law.decay > 0 else 0.0
        mu = law.dynamic + jump * math.exp(-law.decay * speed)
        return self._cohesion(slipped=True) + mu * normal

    def _cohesion(self, slipped: bool) -> float:
        return 0.0 if slipped and self.law.cohesion_lost else self.cohesion


def coulomb(friction: float) -> Resistance:
    """Coulomb's law with one coefficient mu."""
    return Resistance(law=FrictionSpec(static=friction))
