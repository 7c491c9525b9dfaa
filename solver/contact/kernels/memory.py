"""Memory of points after a step, and the energy stored and lost in their interface; compiled."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from solver.law.compiled import compiled
from solver.law.friction import SLIPPED, Bounds, FrictionLaws, pasts_after, points_that_slip
from solver.types import Array


@compiled
def after_step(
    friction_laws: tuple[Any, ...],
    force: Array,
    y: Array,
    old_force: Array,
    old_y: Array,
    old_anchor: Array,
    old_past: Array,
    softness: Array,
    mu: Array,
    cohesion: Array,
    step: float,
    anchor: Array,
    past: Array,
) -> tuple[float, float]:
    """Fill in anchors and pasts after a step; returns what friction and contact took, J.

    Friction is minus the work of the tangential forces on the anchors. Contact takes the work of
    the forces against y that is neither stored in their softness nor lost in friction.

    Args:
        friction_laws: The fields of the `FrictionLaws` of the interface, its only ones.
        force: Point forces at t_{n+1}, (points, d), N.
        y: Augmented positions at t_{n+1}, (points, d), m.
        old_force: The same at t_n, in the frame of the step.
        old_y: Likewise.
        old_anchor: Stick memory at t_n, (points, d-1), m.
        old_past: What points remembered of their friction, (points, PAST).
        softness: 1/(gamma_h w), (points,), m/N.
        mu: Coefficients of friction in this step, (points,).
        cohesion: What points hold besides, (points,), N.
        step: Its length, s; infinite in equilibrium.
        anchor: Stick memory at t_{n+1}, filled in.
        past: What points remember of their friction afterwards, likewise.
    """
    laws, bounds = FrictionLaws(*friction_laws), Bounds(mu, cohesion, np.inf)
    (m, d), friction, contact = force.shape, 0.0, 0.0
    closed, distance = force[:, 0] > 0.0, np.zeros(len(force))
    for p in range(m):
        for k in range(d):
            grown, both = force[p, k] - old_force[p, k], force[p, k] + old_force[p, k]
            contact -= force[p, k] * (y[p, k] - old_y[p, k]) + 0.5 * softness[p] * grown * both
        for k in range(1, d):
            anchor[p, k - 1] = y[p, k] + (softness[p] * force[p, k] if closed[p] else 0.0)
            slip = anchor[p, k - 1] - old_anchor[p, k - 1]
            friction -= force[p, k] * slip
            distance[p] += slip**2
        distance[p] = math.sqrt(distance[p])
    slipped = points_that_slip(force, distance, softness, bounds)
    past[:] = pasts_after(laws, old_past, closed, slipped, np.divide(distance, step), step)
    return friction, contact - friction


@compiled
def stored_energy(
    force: Array, traction: Array, softness: Array, weight: Array, inverse_gamma: Array, theta: int
) -> float:
    """Energy of an interface whose points have tractions, sum of (f^2/w - theta w T^2)/(2 gamma_h).

    Args:
        force: Point forces, (points, d), N.
        traction: T, (points, d), Pa.
        softness: 1/(gamma_h w), (points,), m/N.
        weight: w, (points,), m or m2.
        inverse_gamma: 1/gamma_h, (points,), m/Pa.
        theta: Variant of Nitsche's method.
    """
    energy = 0.0
    for p in range(len(force)):
        for k in range(force.shape[1]):
            energy += 0.5 * softness[p] * force[p, k] ** 2
            energy -= 0.5 * theta * weight[p] * inverse_gamma[p] * traction[p, k] ** 2
    return energy


@compiled
def squared_change(weight: Array, old: Array, new: Array) -> float:
    """Weighted sum of the squared changes of vectors (points, d)."""
    total = 0.0
    for p in range(len(old)):
        for k in range(old.shape[1]):
            total += weight[p] * (new[p, k] - old[p, k]) ** 2
    return total


@compiled
def _all_slip(force: Array, past: Array) -> bool:
    """True if all closed points slip."""
    for p in range(len(force)):
        if force[p, 0] > 0.0 and not past[p, SLIPPED] > 0.0:
            return False
    return True


@compiled
def changed_forces(
    before: Array, after: Array, past_before: Array, past_after: Array, rigid: bool
) -> tuple[float, float]:
    """Forces of the points that opened, closed, stuck, slipped or turned round, and of all, N.

    Of each point it is the larger one of both ends of a step.

    Args:
        before: Point forces at its start, (points, d), N.
        after: At its end.
        past_before: What points remembered of their friction at its start, (points, PAST).
        past_after: At its end.
        rigid: True if neither body is meshed. Which of their points slip is then chance, unless all
            of them do.
    """
    shaken, carried = 0.0, 0.0
    together = (
        not rigid or _all_slip(before, past_before),
        not rigid or _all_slip(after, past_after),
    )
    for p in range(len(before)):
        slipped = together[0] and past_before[p, SLIPPED] > 0.0
        slips = together[1] and past_after[p, SLIPPED] > 0.0
        if rigid:
            slipped, slips = slipped and before[p, 0] > 0.0, slips and after[p, 0] > 0.0
        old = new = turned = 0.0
        for k in range(before.shape[1]):
            old, new = math.hypot(old, before[p, k]), math.hypot(new, after[p, k])
            turned += before[p, k] * after[p, k] if k > 0 else 0.0
        changed = (before[p, 0] > 0.0) != (after[p, 0] > 0.0)
        changed = changed or slipped != slips
        changed = changed or (slipped and turned < 0.0)
        carried += max(old, new)
        shaken += max(old, new) if changed else 0.0
    return shaken, carried
