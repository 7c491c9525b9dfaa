"""Contact at velocity level, after each step (the paper's section 3.4).

A contact that stays closed has u_{n+1} = u_n there, so that the velocity update of the time
stepping turns its velocity round every step. The impulses dt f of the closed points are therefore
corrected such that

    0 <= P_n  complementary to  v_n >= 0,   |P_t| <= dt c + mu P_n, v_t = 0 inside the bound,
    P = dt f + q,

with v <- v + M^-1 G^T q. Points that slipped in the step keep the direction of their friction,
against the slip of the step, and stay at their bound, which follows P_n: the velocity at the end of
the step is ahead of its slip by half a step. All others obey the law.

Where a rigid body lands in the step, the slip of the step is that of the flight before, or that of
the old pivot; an impulse is now to stop the body, whatever the length of the step, and its friction
has to oppose the slip that it leaves. There all points obey the law.

The correction may return energy only as far as friction took it in this step. Where it would return
more, points that slip keep their friction, then all do, and else the velocities stay as they are.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from solver.law.compiled import compiled
from solver.law.friction import Bounds, at_bound
from solver.law.local_problem import LocalProblem, solve
from solver.law.many_points import MANY_ROWS
from solver.law.newton import product
from solver.types import Array, Indices

#: Relative diagonal added to W: closed points may outnumber the unknowns, W is singular then.
REGULAR = 1e-8
#: Gains of kinetic energy below this part of the power of the impulses are round-off.
ENERGY_ROUND_OFF = 1e-14


class ImpulseCorrection(NamedTuple):
    """Change of the impulses and the energy that it takes (per metre of thickness in 2-D)."""

    found: bool
    """True if there is one."""
    q: Array
    """Impulses of the closed points in their frames, (d m,) or (m, d), N s."""
    contact: float
    """Energy taken in the normal directions, J."""
    friction: float
    """Energy taken in the tangential directions, J."""


@compiled
def _tangential(d: int, impulse: Array, i: int) -> float:
    """Size of the tangential impulse of point i, N s."""
    size = 0.0
    for k in range(d * i + 1, d * i + d):
        size = math.hypot(size, impulse[k])
    return size


@compiled
def friction_share(tangential: float, lost: float, taken: float) -> float:
    """Friction's share of the kinetic energy that a correction takes, J.

    The tangential impulses took `tangential`, all of them `lost`, and friction had `taken` in the
    step before. Normal and tangential impulses of a body act on each other: the work in one
    direction may be negative, though their sum is a loss. Friction returns no more than it took
    before: what the tangential impulses give back beyond that, the normal ones took, and it is
    contact's.
    """
    return min(max(tangential, -taken), max(lost, -taken))


class Fallback(NamedTuple):
    """One of the problems that are tried for the impulses, one after another."""

    W: Array
    """Mobility with the friction that follows the normal impulses, (d m, d m), 1/kg."""
    free: Array
    """Velocities without impulses but those given, (d m,), m/s."""
    bounds: Bounds
    """Bounds of the impulses; without friction where that is no unknown."""
    given: Array
    """Impulses that act in any case, (d m,), N s."""
    ratio: Array
    """Tangential impulse for each unit of the normal one, besides, (d m,)."""
    start: Array
    """Guess of the impulses that are unknown, (d m,), N s."""


@compiled
def fallback_problem(
    d: int, number: int, W: Array, free: Array, impulse: Array, bounds: Bounds
) -> Fallback:
    """The problem of a number.

    In 0 all points obey the law; in 1, points that slipped stay at their bound; in 2 they keep
    their friction; in 3 all points do.

    Args:
        d: Rows of a point.
        number: 0 to 3.
        W: Of the points, (d m, d m), 1/kg.
        free: Velocities without impulses, (d m,), m/s.
        impulse: dt f of the step, (d m,), N s.
        bounds: Of the impulses.
    """
    mobility, velocity, start = W.copy(), free.copy(), impulse.copy()
    given, ratio = np.zeros_like(impulse), np.zeros_like(impulse)
    mu, cohesion = bounds.mu.copy(), bounds.cohesion.copy()
    for i in range(len(mu)):
        n, size = d * i, _tangential(d, impulse, i)
        if number == 0 or (number < 3 and not at_bound(bounds, i, impulse[n], size)):
            continue
        mu[i] = cohesion[i] = 0.0
        for k in range(n + 1, n + d):
            given[k], start[k] = impulse[k], 0.0
            if number == 1 and size > 0.0:
                given[k] *= bounds.cohesion[i] / size
                ratio[k] = bounds.mu[i] / size * impulse[k]
            for row in range(len(W)):
                mobility[row, n] += W[row, k] * ratio[k]
                velocity[row] += W[row, k] * given[k]
    left = Bounds(mu, cohesion, bounds.slope)
    return Fallback(mobility, velocity, left, given, ratio, start)


@compiled
def add_known_impulses(d: int, problem: Fallback, total: Array) -> None:
    """Add to the impulses of a solution what is given, and friction that follows normal ones."""
    for n in range(0, len(total), d):
        for k in range(n + 1, n + d):
            total[k] += problem.given[k] + problem.ratio[k] * total[n]


@compiled
def check_dissipation(
    d: int, W: Array, velocity: Array, impulse: Array, total: Array, taken: float
) -> ImpulseCorrection:
    """The correction by which impulses become others; not found where it returns too much energy.

    Arguments as those of `correct_impulses`; `total` are the other impulses, (d m,), N s.
    """
    q, normal, lost, power = total - impulse, 0.0, 0.0, 0.0
    gained = product(W, q)
    for k in range(len(q)):
        work = q[k] * (velocity[k] + 0.5 * gained[k])
        lost -= work
        normal -= 0.0 if k % d else work
        power += impulse[k] * velocity[k]
    if lost + taken < -ENERGY_ROUND_OFF * abs(power):
        return ImpulseCorrection(False, np.zeros_like(impulse), 0.0, 0.0)
    friction = friction_share(lost - normal, lost, taken)
    return ImpulseCorrection(True, q, lost - friction, friction)


@compiled
def regularised(W: Array) -> Array:
    """W with a diagonal that makes impulses unique."""
    regular = W.copy()
    for k in range(len(W)):
        regular[k, k] *= 1.0 + REGULAR
    return regular


@compiled
def correct_impulses(
    d: int,
    W: Array,
    velocity: Array,
    impulse: Array,
    bounds: Bounds,
    taken: float,
    counts: Indices,
    lands: bool = False,
) -> ImpulseCorrection:
    """Correct the impulses of closed points.

    Args:
        d: Rows of a point.
        W: G M^-1 G^T of the closed points, (d m, d m), 1/kg.
        velocity: Of the points after the step, (d m,), m/s.
        impulse: dt f of the step, (d m,), N s.
        bounds: Of the impulses: mu and dt c.
        taken: Energy that friction took in the step, J.
        counts: Of outcomes of local problems.
        lands: True if a rigid body landed in the step.
    """
    regular, taken = regularised(W), max(taken, 0.0)
    free, states = velocity - product(regular, impulse), np.empty(len(bounds.mu), np.int64)
    for number in range(0 if lands else 1, 4):
        problem = fallback_problem(d, number, regular, free, impulse, bounds)
        total = problem.start
        if solve(d, problem.W, problem.free, problem.bounds, total, states, counts):
            add_known_impulses(d, problem, total)
            found = check_dissipation(d, W, velocity, impulse, total, taken)
            if found.found:
                return found
    counts[-1] += 1
    return ImpulseCorrection(False, np.zeros_like(impulse), 0.0, 0.0)


@compiled
def slip_reversal(force: Array, velocity: Array) -> float:
    """Speed at which points slip back at the end of a step, m/s, a mean over their friction.

    Friction opposes the slip of the step as a whole. Where the slip turned round within the step,
    friction drives what it should by now oppose. 0 where it does not.

    Args:
        force: Of closed points, normal and tangential, (m, d), N.
        velocity: Their velocities at the end of the step, (m, d), m/s.
    """
    power = friction = 0.0
    for p in range(len(force)):
        square = 0.0
        for j in range(1, force.shape[1]):
            power += force[p, j] * velocity[p, j]
            square += force[p, j] ** 2
        friction += math.sqrt(square)
    return power / friction if power > 0.0 else 0.0


def correct_many(
    local: LocalProblem,
    d: int,
    W: Array,
    velocity: Array,
    impulse: Array,
    bounds: Bounds,
    taken: float,
    points: Indices | None,
    lands: bool,
) -> ImpulseCorrection:
    """As `correct_impulses`, for many points of some numbers; `local` counts the outcomes."""
    regular, taken = regularised(W), max(taken, 0.0)
    free = velocity - regular @ impulse
    for number in range(0 if lands else 1, 4):
        problem, total = fallback_problem(d, number, regular, free, impulse, bounds), impulse - 0.0
        shape = len(total) // d, d
        unknown = problem.W.reshape(shape * 2), problem.free.reshape(shape), problem.bounds
        if local.impulses(*unknown, total.reshape(shape), points):
            add_known_impulses(d, problem, total)
            found = check_dissipation(d, W, velocity, impulse, total, taken)
            if found.found:
                return found
    local.counts[-1] += 1
    return ImpulseCorrection(False, np.zeros_like(impulse), 0.0, 0.0)


def impulse_correction(
    local: LocalProblem,
    velocity: Array,
    W: Array,
    impulse: Array,
    bounds: Bounds,
    taken: float,
    points: Indices | None = None,
    lands: bool = False,
) -> ImpulseCorrection | None:
    """The correction after a step, or None where no point is closed or none was found.

    As `correct_impulses` with arrays (m, d) and W (m, d, m, d); `local` counts the
    outcomes. Many points are known again by their numbers, (m,).
    """
    m, d = impulse.shape
    if not m:
        return None
    flat = W.reshape(d * m, d * m), velocity.ravel(), impulse.ravel()
    if impulse.size > MANY_ROWS:
        found, q, contact, friction = correct_many(local, d, *flat, bounds, taken, points, lands)
    else:
        found, q, contact, friction = correct_impulses(d, *flat, bounds, taken, local.counts, lands)
    return ImpulseCorrection(found, q.reshape(m, d), contact, friction) if found else None
