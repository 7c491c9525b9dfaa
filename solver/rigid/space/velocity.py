"""Contact of rigid blocks in space at velocity level, after each step, compiled."""

from __future__ import annotations

import numpy as np

from solver.law.compiled import compiled
from solver.law.space_friction import UNSETTLED, settle
from solver.rigid.loss import shares_of_loss
from solver.rigid.space.contact import chosen, moved_on, rotations, rows_of
from solver.rigid.space.friction import slips
from solver.rigid.space.model import SpaceModel, SpaceSolution, SpaceState
from solver.rigid.space.motion import act, changes, compliance, regularise
from solver.rigid.space.rotation import product, to_body, to_space
from solver.types import Array


@compiled
def _spins(state: SpaceState, frames: Array) -> Array:
    """Angular velocities of all bodies in space, rad/s."""
    spin = np.zeros_like(state.spin)
    for b in range(len(frames) - 1):
        spin[b] = to_space(frames[b], state.spin[b])
    return spin


@compiled
def _mobility(model: SpaceModel, frames: Array) -> tuple[Array, Array]:
    """Velocities per impulse: of centres (n + 1, 3) and of rotations (n + 1, 3, 3)."""
    n = len(frames)
    yields, turning = np.zeros((n, 3)), np.zeros((n, 3, 3))
    for b in range(n):
        if model.mass[b] > 0:
            yields[b, : 3 if b < n - 1 else 2] = 1 / model.mass[b]
        if b < n - 1:
            turning[b] = product(frames[b] / model.inertia[b], frames[b].T.copy())
    return yields, turning


@compiled
def _total_impulse(
    W: Array, velocity: Array, impulse: Array, held: Array, mu: Array, cohesion: Array
) -> tuple[int, Array]:
    """What settled them, and impulses (3 m,) that make the velocities right.

    Points that are `held` keep their tangential part.
    """
    W, free = W.copy(), velocity - W @ impulse
    for i in range(len(mu)):
        if held[i] == 0:
            continue
        for k in (3 * i + 1, 3 * i + 2):
            own = W[k, k]
            free += W[:, k] * impulse[k]
            W[k, :], W[:, k] = 0.0, 0.0
            W[k, k] = own
    free -= regularise(W).reshape(len(free)) * impulse
    for i in range(len(mu)):
        if held[i] == 1:
            free[3 * i + 1 : 3 * i + 3] = 0.0
    total = impulse.copy()
    for i in range(len(mu)):
        if held[i] == 1:
            total[3 * i + 1 : 3 * i + 3] = 0.0
    method = settle(W, free, total, mu, cohesion.copy())
    for i in range(len(mu)):
        if held[i] == 1:
            total[3 * i + 1 : 3 * i + 3] = impulse[3 * i + 1 : 3 * i + 3]
    return method, total


@compiled
def correct_velocity(model: SpaceModel, state: SpaceState, s: SpaceSolution) -> None:
    """Contact at velocity level: closed points neither approach nor, inside the cone, slip.

    A correction that would add energy is tried again with its normal part alone, or left out.
    """
    shut = chosen(s.contacts, s.force[:, 0].copy())
    m = len(shut.body)
    if m == 0:
        return
    kept = np.flatnonzero(s.force[:, 0] > 0)
    frames = rotations(state.quaternion)
    shut = moved_on(shut, frames, state.place, 1.0)
    rows = rows_of(shut, frames, state.place)
    yields, turning = _mobility(model, frames)
    W = compliance(shut, rows, yields, turning)
    velocity = changes(shut, rows, state.velocity, _spins(state, frames)).reshape(3 * m)
    impulse, mu = (s.dt * s.force[kept]).reshape(3 * m), s.mu[kept]
    cohesion = s.dt * s.cohesion[kept]
    held = np.ones(m)
    for i in range(m):
        held[i] = 1.0 if slips(s.force[kept[i]], mu[i], s.cohesion[kept[i]]) else 0.0
    for _ in range(2):
        method, total = _total_impulse(W, velocity, impulse, held, mu, cohesion)
        added = total - impulse
        work = added * (velocity + 0.5 * (W @ added))
        normal = -np.sum(work[0::3])
        tangential = -np.sum(work) - normal
        if method != UNSETTLED and normal + tangential >= 0:
            state.settled[method] += 1
            contact, friction = shares_of_loss(normal, tangential)
            state.exchanged[3] += contact
            state.exchanged[1] += friction
            force, moment, _ = act(shut, rows, added.reshape((m, 3)), len(frames))
            state.velocity[:, :] += yields * force
            for b in range(len(frames) - 1):
                state.spin[b] += to_body(frames[b], moment[b]) / model.inertia[b]
            return
        held[:] = 1.0
