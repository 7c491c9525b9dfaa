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


class FrictionLaws(NamedTuple):
    """Friction of several surfaces, one entry each; the fields are those of the scene's table."""

    static: Array
    """Coefficient at rest, mu_s."""
    dynamic: Array
    """Coefficient of fast sliding, mu_d."""
    decay: Array
    """DC, s/m; 0: the coefficient jumps when a point slips."""
    cohesion: Array
    """c, Pa: what a closed point holds without pressure."""
    cohesion_lost: Mask
    """True for a law by which a point that has broken loose has no cohesion any more."""

    @classmethod
    def of(cls, laws: Sequence[FrictionSpec]) -> FrictionLaws:
        """Laws one after another."""
        return cls(*(np.array([getattr(law, name) for law in laws]) for name in cls._fields))


@compiled
def coefficient(laws: FrictionLaws, k: int, speed: float, slipped: bool) -> float:
    """The coefficient mu of surface k at a speed (m/s), or where DC = 0 by whether it slipped."""
    static, dynamic = laws.static[k], laws.dynamic[k]
    if laws.decay[k] > 0.0:
        return float(dynamic + (static - dynamic) * math.exp(-laws.decay[k] * speed))
    return float(dynamic if slipped else static)


@compiled
def held(laws: FrictionLaws, k: int, past: Array) -> tuple[float, float]:
    """Coefficient and cohesion (Pa) of a point of surface k when a step begins, by its past."""
    lost = laws.cohesion_lost[k] and past[BROKEN] > 0.0
    mu = coefficient(laws, k, past[RATE], past[SLIPPED] > 0.0)
    return mu, 0.0 if lost else float(laws.cohesion[k])


@compiled
def followed(
    laws: FrictionLaws, k: int, past: Array, mu: float, speed: float, slips: bool
) -> tuple[float, bool]:
    """Coefficient of a point by the motion that `mu` led to; whether it keeps its cohesion.

    Friction of points is brought up to the motion by this function. `past` is what
    the point remembers; the speed, m/s, is its slip in this step over the step's length, 0 where it
    sticks; `slips`: it has broken loose in this step. With DC = 0 the coefficient only falls, from
    mu_s to mu_d: no choice between the two can then repeat itself.
    """
    lost = laws.cohesion_lost[k] and (slips or past[BROKEN] > 0.0)
    if laws.decay[k] > 0.0:
        return coefficient(laws, k, speed, slips), not lost
    return float(laws.dynamic[k]) if slips else mu, not lost


@compiled
def eased(laws: FrictionLaws, k: int, before: float, mu: float, share: float) -> float:
    """A share of the way from one coefficient to the next, of surface k, where it decays."""
    return before + share * (mu - before) if share < 1.0 and laws.decay[k] > 0.0 else mu


@compiled
def remember(laws: FrictionLaws, k: int, past: Array, speed: float, slips: bool, dt: float) -> None:
    """Write what a closed point of surface k remembers of a step into its past.

    Speed (m/s) and slip are those of the whole step; dt (s) is infinite in equilibrium. Laws, k and
    dt are there for laws whose memory evolves in time.
    """
    past[RATE] = speed if slips else 0.0
    past[SLIPPED] = 1.0 if slips else 0.0
    if slips:
        past[BROKEN] = 1.0


@compiled
def remember_open(laws: FrictionLaws, k: int, past: Array, dt: float) -> None:
    """Note that a point that is open, or with dt = 0 comes to touch elsewhere, has not slipped."""
    past[RATE] = past[SLIPPED] = 0.0


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
    """True if no point holds any tangential force."""
    for i in range(len(bounds.mu)):
        if bounds.mu[i] > 0.0 or bounds.cohesion[i] > 0.0:
            return False
    return True


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
    """True if closed point i holds all the friction that it can: |f_t| is at its bound."""
    return normal > 0.0 and tangential >= radius(bounds, i, normal) * (1.0 - BOUND_ROUND_OFF)


@compiled
def slips(distance: float, own: float, force: float) -> bool:
    """True if a point at its bound slips; by its way (m), compliance (m/N) and force (N)."""
    return distance > SLIP_ROUND_OFF * own * force


@compiled
def points_at_bound(force: Array, bounds: Bounds) -> Mask:
    """The closed points whose friction is at its bound, of point forces (m, d), N."""
    found = np.zeros(len(force), np.bool_)
    for i in range(len(force)):
        found[i] = at_bound(bounds, i, force[i, 0], math.sqrt(np.sum(force[i, 1:] ** 2)))
    return found


@compiled
def points_that_slip(force: Array, way: Array, own: Array, bounds: Bounds) -> Mask:
    """The points that slip in a step: at the bound, and moved by more than round-off.

    By their forces, (m, d), N, how far each moved along its carrier from where it stuck, (m,), m,
    and their own compliances, (m,), m/N; cohesion counts as far as the force has built it up.
    """
    found = points_at_bound(force, Bounds(bounds.mu, bounds.cohesion, TOUCHING_SLOPE))
    for i in range(len(force)):
        found[i] = found[i] and slips(way[i], own[i], np.max(np.abs(force[i])))
    return found


@compiled
def bounds_by_past(laws: FrictionLaws, past: Array, area: Array) -> Bounds:
    """Bounds of m points of one surface, by their pasts (m, PAST) and their areas (m,), m2."""
    mu, cohesion = np.empty(len(area)), np.empty(len(area))
    for i in range(len(area)):
        mu[i], held_shear = held(laws, 0, past[i])
        cohesion[i] = held_shear * area[i]
    return Bounds(mu, cohesion, np.inf)


@compiled
def bounds_followed(
    laws: FrictionLaws, past: Array, area: Array, mu: Array, speed: Array, slips: Mask
) -> Bounds:
    """Bounds of m points within a step, of coefficients so far, speeds and slips as in `followed`.

    By their pasts and areas, as in `bounds_by_past`.
    """
    new, cohesion = np.empty(len(area)), np.empty(len(area))
    for i in range(len(area)):
        new[i], coheres = followed(laws, 0, past[i], mu[i], speed[i], slips[i])
        cohesion[i] = laws.cohesion[0] * area[i] if coheres else 0.0
    return Bounds(new, cohesion, np.inf)


@compiled
def pasts_after(
    laws: FrictionLaws, past: Array, closed: Mask, slipped: Mask, speed: Array, dt: float
) -> Array:
    """Pasts of m points of one surface after a step, (m, PAST); `past` stays as it is."""
    after = past.copy()
    for i in range(len(after)):
        if closed[i]:
            remember(laws, 0, after[i], speed[i], slipped[i], dt)
        else:
            remember_open(laws, 0, after[i], dt)
    return after
