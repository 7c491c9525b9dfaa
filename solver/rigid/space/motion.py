"""Linear parts of a step of rigid blocks in space, compiled: motion without contact, compliance.

Centres move by the generalized-alpha method with contact impulses outside the average, rotations by
the energy-momentum rule of `solver.rigid.space.rotation`.
"""

from __future__ import annotations

import numpy as np

from solver.law.compiled import compiled
from solver.rigid.space.model import SpaceContacts, SpaceModel, SpaceState
from solver.rigid.space.rotation import (
    advanced,
    end_factor,
    free_rule,
    free_tangent,
    inverse,
    product,
    rotation_of,
    to_body,
    to_space,
)
from solver.types import Array

REGULAR = 1e-8
"""Diagonal D added to W, relative to its own: four corners of a block are 12 rows on 6 unknowns.

It acts on the change of the forces since the last step, y = q + W f + D (f - f_n): forces that
balance each other within a body stay what they were, and what lasts is hardly softened."""


@compiled
def loads(model: SpaceModel, ground: Array) -> Array:
    """Forces m (g - a_g) on all bodies, (n + 1, 3); the platform moves along x and y alone."""
    force = np.empty((len(model.mass), 3))
    for b in range(len(force)):
        force[b] = model.mass[b] * (model.gravity - ground)
    force[-1, 2] = 0.0
    return force


@compiled
def free_motion(
    model: SpaceModel, state: SpaceState, dt: float, load: Array
) -> tuple[Array, Array]:
    """Increments of the centres without contact, and what a contact force moves them by, m/N.

    The load has the mean forces of the step, (n + 1, 3), N.
    """
    am, af, beta = model.scheme[0], model.scheme[1], model.scheme[2]
    moved, yields = np.zeros_like(load), np.zeros_like(load)
    for b in range(len(load)):
        if model.mass[b] == 0:
            continue
        if b < len(load) - 1:
            yields[b] = 0.5 * dt * dt / model.mass[b]
            moved[b] = dt * state.velocity[b] + yields[b] * load[b]
            continue
        inertial, weight = (1 - am) * model.mass[b] / (beta * dt * dt), (1 - am) / (2 * beta)
        stiffness = inertial + (1 - af) * model.spring[0] + weight * model.spring[1] / dt
        for k in range(2):
            force = weight * load[b, k] + inertial * dt * state.velocity[b, k]
            force += ((1 - am) * (0.5 / beta - 1) - am) * state.inertia_force[k]
            force -= model.spring[0] * state.place[b, k]
            moved[b, k] = force / stiffness
            yields[b, k] = weight / stiffness
    return moved, yields


@compiled
def free_turn(
    model: SpaceModel, state: SpaceState, frames: Array, turned: Array, dt: float
) -> tuple[Array, Array]:
    """One Newton step of the rotations without contact, and what a moment adds, rad/(N m).

    The rule is linear about the Cayley vectors `turned`, in space.
    """
    hat, yields = np.zeros_like(turned), np.zeros((len(turned), 3, 3))
    for b in range(len(turned) - 1):
        inertia, psi = model.inertia[b], to_body(frames[b], turned[b])
        tangent = inverse(free_tangent(inertia, psi))
        rule = free_rule(inertia, psi, state.spin[b], dt)
        hat[b] = to_space(frames[b], psi - to_space(tangent, rule))
        factor = product(product(tangent, end_factor(psi)), frames[b].T.copy())
        yields[b] = dt * dt * product(frames[b], factor)
    return hat, yields


@compiled
def mean_motion(
    state: SpaceState, frames: Array, moved: Array, turned: Array
) -> tuple[Array, Array]:
    """Mean rotations and places of all bodies in a step."""
    mean = frames.copy()
    for b in range(len(frames) - 1):
        mean[b] = 0.5 * (frames[b] + rotation_of(advanced(state.quaternion[b], turned[b])))
    return mean, state.place + 0.5 * moved


@compiled
def _add_block(W: Array, p: int, q: int, left: Array, right: Array) -> None:
    """Add left right^T to the (3, 3) block of W at row p, column q."""
    for i in range(3):
        for k in range(3):
            for c in range(6):
                W[p + i, q + k] += left[i, c] * right[k, c]


@compiled
def compliance(
    contacts: SpaceContacts, rows: tuple[Array, Array, Array], yields: Array, turning: Array
) -> Array:
    """W (3 m, 3 m): changes of gap and place at the points per force, without added diagonal.

    By rows of `rows_of`, increments of the centres per force, (n + 1, 3), m/N, and Cayley vectors
    per moment, (n + 1, 3, 3), rad/(N m).
    """
    m = len(contacts.body)
    whole, moved = np.empty((m, 2, 3, 6)), np.empty((m, 2, 3, 6))
    bodies = np.empty((m, 2), dtype=np.int64)
    for q in range(m):
        bodies[q, 0], bodies[q, 1] = contacts.body[q], contacts.base[q]
        for side in range(2):
            b, sign, turn = bodies[q, side], 1.0 - 2.0 * side, rows[1 + side][q]
            for k in range(3):
                whole[q, side, k, :3] = sign * rows[0][q, k]
                whole[q, side, k, 3:] = turn[k]
                moved[q, side, k, :3] = yields[b] * whole[q, side, k, :3]
                moved[q, side, k, 3:] = to_space(turning[b], turn[k])
    W = np.zeros((3 * m, 3 * m))
    for p in range(m):
        for q in range(m):
            for one in range(2):
                for other in range(2):
                    b = bodies[p, one]
                    if b != bodies[q, other] or yields[b, 0] == 0:
                        continue  # another body, or the ground
                    _add_block(W, 3 * p, 3 * q, whole[p, one], moved[q, other])
    return W


@compiled
def regularise(W: Array) -> Array:
    """Add a small diagonal to W; returns it, (m, 3)."""
    softness = np.empty((len(W) // 3, 3))
    for i in range(len(W)):
        softness[i // 3, i % 3] = REGULAR * W[i, i]
        W[i, i] += REGULAR * W[i, i]
    return softness


@compiled
def changes(
    contacts: SpaceContacts, rows: tuple[Array, Array, Array], moved: Array, turned: Array
) -> Array:
    """Changes of gap and place of the points, (m, 3)."""
    along, turn, back = rows
    change = np.empty((len(contacts.body), 3))
    for q in range(len(change)):
        i, j = contacts.body[q], contacts.base[q]
        change[q] = to_space(along[q], moved[i] - moved[j])
        change[q] += to_space(turn[q], turned[i]) + to_space(back[q], turned[j])
    return change


@compiled
def apply_forces(
    contacts: SpaceContacts, rows: tuple[Array, Array, Array], force: Array, bodies: int
) -> tuple[Array, Array, Array]:
    """The forces and moments of contact on all bodies, and the force on each point's body, N."""
    along, turn, back = rows
    total, moment = np.zeros((bodies, 3)), np.zeros((bodies, 3))
    pushed = np.empty((len(contacts.body), 3))
    for q in range(len(pushed)):
        i, j = contacts.body[q], contacts.base[q]
        pushed[q] = to_body(along[q], force[q])
        total[i] += pushed[q]
        total[j] -= pushed[q]
        moment[i] += to_body(turn[q], force[q])
        moment[j] += to_body(back[q], force[q])
    return total, moment, pushed
