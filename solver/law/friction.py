"""Friction: the bounds that Coulomb's law with cohesion sets to the forces of points.

The law itself is that of `solver/kernels/friction.hpp`, for the points of an interface as arrays
that of `point_friction.hpp` there.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from solver.kernels import meshed
from solver.types import Array, Indices, Mask

if TYPE_CHECKING:
    from solver.scene import FrictionSpec

#: Slope s of cohesion over the normal force where all of it at once has no solution: it is then
#: built up over the first 1e-4 of the pressure.
TOUCHING_SLOPE = 1e4

RATE, SLIPPED, BROKEN = 0, 1, 2
"""Entries of the past of a point, in this order: its slip rate in the last step (m/s; 0
where it stuck), whether it slipped then, and whether it ever broke loose (0 or 1)."""

PAST = 3
"""Number of these entries. The engines carry them along; their meaning stays in this file."""


def new_pasts(*shape: int) -> Array:
    """Pasts of points that have touched nothing yet, (*shape, PAST)."""
    return np.zeros((*shape, PAST))


def slipped_before(pasts: Array) -> Mask:
    """The points that slipped in the last step, (m,), by their pasts (m, PAST)."""
    return np.asarray(pasts[:, SLIPPED] > 0.0)


class FrictionLaw(NamedTuple):
    """Friction of the points of an interface; the fields are those of the scene's table."""

    static: float
    """Coefficient at rest, mu_s."""
    dynamic: float
    """Coefficient of fast sliding, mu_d."""
    decay: float
    """DC, s/m; 0: the coefficient jumps when a point slips."""
    cohesion: float
    """c, Pa: what a closed point holds without pressure."""
    cohesion_lost: bool
    """True for a law by which a point that has broken loose has no cohesion any more."""

    @classmethod
    def of(cls, law: FrictionSpec) -> FrictionLaw:
        """The friction of a scene's table."""
        return cls(*(getattr(law, name) for name in cls._fields))

    def bounds_by_past(self, past: Array, area: Array) -> Bounds:
        """Bounds of m points when a step begins, by their pasts (m, PAST) and areas (m,), m2."""
        bounds = Bounds(np.empty(len(area)), np.empty(len(area)))
        meshed.bounds_by_past(*self, past, area, bounds.mu, bounds.cohesion)
        return bounds

    def bounds_followed(
        self, past: Array, area: Array, mu: Array, speed: Array, slips: Mask
    ) -> Bounds:
        """Bounds of m points within a step, by the motion that coefficients `mu` led to.

        Friction of points is brought up to the motion by this function. The speed, (m,), m/s, is
        the slip of a point in this step over the step's length, 0 where it sticks; `slips`, (m,):
        it has broken loose in this step. Pasts and areas are as in `bounds_by_past`. With DC = 0 a
        coefficient only falls, from mu_s to mu_d: no choice between the two can then repeat itself.
        """
        bounds = Bounds(np.empty(len(area)), np.empty(len(area)))
        meshed.bounds_followed(*self, past, area, mu, speed, slips, bounds.mu, bounds.cohesion)
        return bounds


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
        return cls(np.full(m, mu, dtype=np.float64), np.zeros(m))

    def of(self, chosen: slice | Indices) -> Bounds:
        """The bounds of some of the points."""
        return Bounds(self.mu[chosen], self.cohesion[chosen], self.slope)


def slipping_points(force: Array, slip: Array, own: Array, bounds: Bounds) -> Mask:
    """The points that slip in a step: at their bound, and moved by more than round-off.

    Points of a rigid body share friction between them in many ways: one that is at its bound while
    others hold the body moves no farther than round-off, and has not broken loose.

    Args:
        force: Point forces, (m, d), N.
        slip: How far the points moved along their carriers, (m, d-1), m.
        own: What the force at a point moves it by, (m,), m/N.
        bounds: Of the m points.
    """
    found = np.empty(len(force), np.bool_)
    meshed.slipping_points(force, slip, own, bounds.mu, bounds.cohesion, found)
    return found
