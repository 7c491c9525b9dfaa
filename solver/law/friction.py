"""Friction: Coulomb's law with cohesion, and the bounds that it sets to the forces of points.

A closed point holds the shear stress tau = c + mu p. The coefficient falls from its static to its
dynamic value with the speed v of sliding,

    mu = mu_d + (mu_s - mu_d) exp(-DC v)

or, where DC = 0, as soon as the point has slipped.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from solver.law.compiled import compiled
from solver.types import Array, Mask

if TYPE_CHECKING:
    from solver.scene import FrictionSpec

#: Slope s of cohesion over the normal force where all of it at once has no solution: it is then
#: built up over the first 1e-4 of the pressure.
TOUCHING_SLOPE = 1e4

#: A force this close to its bound, relative to it, is at the bound.
BOUND_ROUND_OFF = 1e-9

#: A point at its bound slips where it moves by more than this part of what its own force moves it
#: by; less only settles which of several points of a rigid body holds how much.
SLIP_ROUND_OFF = 1e-5


class FrictionLaw(NamedTuple):
    """Friction of one surface."""

    static: float
    """Coefficient at rest, mu_s."""
    dynamic: float
    """Coefficient of fast sliding, mu_d."""
    decay: float = 0.0
    """DC, s/m; 0: the coefficient jumps when a point slips."""
    cohesion: float = 0.0
    """c, Pa: what a closed point holds without pressure."""
    cohesion_lost: bool = False
    """Whether a point that has broken loose has no cohesion any more."""

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
        """The coefficients of points by their speeds (m/s) and whether they slipped, (m,)."""
        return coefficients(self, speed, slipped)

    def adhesion(self, area: Array, broken: Mask) -> Array:
        """The cohesive forces c A (N) of points by their areas (m, m2), 0 where lost, (m,)."""
        return np.where(broken & self.cohesion_lost, 0.0, self.cohesion * area)


class FrictionLaws(NamedTuple):
    """Friction of several surfaces, one entry each; the fields are those of `FrictionLaw`."""

    static: Array
    dynamic: Array
    decay: Array
    cohesion: Array
    cohesion_lost: Mask

    @classmethod
    def of(cls, laws: Sequence[FrictionLaw | FrictionSpec]) -> FrictionLaws:
        """Laws one after another."""
        numbers = np.array([(w.static, w.dynamic, w.decay, w.cohesion) for w in laws], np.float64)
        static, dynamic, decay, cohesion = numbers.T.copy()
        lost = np.array([law.cohesion_lost for law in laws], np.bool_)
        return cls(static, dynamic, decay, cohesion, lost)


@compiled
def law_of(laws: FrictionLaws, k: int) -> FrictionLaw:
    """The law of surface k."""
    return FrictionLaw(
        laws.static[k], laws.dynamic[k], laws.decay[k], laws.cohesion[k], laws.cohesion_lost[k]
    )


@compiled
def coefficient(law: FrictionLaw, speed: float, slipped: bool) -> float:
    """The coefficient mu at a speed (m/s), or where DC = 0 by whether the point slipped."""
    if law.decay > 0.0:
        return law.dynamic + (law.static - law.dynamic) * math.exp(-law.decay * speed)
    return law.dynamic if slipped else law.static


@compiled
def coefficients(law: FrictionLaw, speed: Array, slipped: Mask) -> Array:
    """Coefficients of m points of one surface."""
    mu = np.empty(len(speed))
    for i in range(len(mu)):
        mu[i] = coefficient(law, speed[i], slipped[i])
    return mu


@compiled
def followed(law: FrictionLaw, mu: float, speed: float, slips: bool) -> float:
    """The coefficient of a point within a step, of the motion that `mu` led to.

    With DC = 0 it only falls, from mu_s to mu_d: no choice between the two can then repeat itself.
    """
    if law.decay > 0.0:
        return coefficient(law, speed if slips else 0.0, slips)
    return law.dynamic if slips else mu


class Bounds(NamedTuple):
    """The tangential forces that m points hold where closed: |f_t| <= mu f_n + min(c, s f_n)."""

    mu: Array
    """Coefficients of friction, (m,)."""
    cohesion: Array
    """c, (m,), N (per metre of thickness in 2-D), or impulses."""
    slope: float = np.inf
    """s, how cohesion grows with the force at first; infinite: all of it acts where f_n > 0."""

    @classmethod
    def uniform(cls, mu: float, m: int) -> Bounds:
        """One coefficient for m points, no cohesion."""
        return cls(np.full(m, mu), np.zeros(m))


@compiled
def is_frictionless(bounds: Bounds) -> bool:
    """Whether no point holds any tangential force."""
    return not (np.any(bounds.mu > 0.0) or np.any(bounds.cohesion > 0.0))


@compiled
def line(bounds: Bounds, i: int, normal: float) -> tuple[float, float]:
    """Slope and intercept of the bound of point i at a normal force > 0."""
    if bounds.slope * normal < bounds.cohesion[i]:
        return bounds.mu[i] + bounds.slope, 0.0
    return bounds.mu[i], bounds.cohesion[i]


@compiled
def radius(bounds: Bounds, i: int, normal: float) -> float:
    """The bound of |f_t| of point i, N; 0 where it is open."""
    if not normal > 0.0:
        return 0.0
    slope, intercept = line(bounds, i, normal)
    return slope * normal + intercept


@compiled
def at_bound(bounds: Bounds, i: int, normal: float, tangential: float) -> bool:
    """Whether closed point i holds all the friction that it can: |f_t| is at its bound."""
    return normal > 0.0 and tangential >= radius(bounds, i, normal) * (1.0 - BOUND_ROUND_OFF)


@compiled
def slips(distance: float, own: float, force: float) -> bool:
    """Whether a point at its bound slips; by its way (m), compliance (m/N) and force (N)."""
    return distance > SLIP_ROUND_OFF * own * force
