"""Contact of rigid blocks in space at velocity level, after each step, compiled."""

from __future__ import annotations

import numpy as np

from solver.law.compiled import compiled
from solver.law.friction import Bounds
from solver.law.velocity import correct_impulses
from solver.rigid.space.contact import HAIR, chosen, moved_on, rotations, rows_of
from solver.rigid.space.model import SpaceModel, SpaceSolution, SpaceState
from solver.rigid.space.motion import act, changes, compliance
from solver.rigid.space.rotation import product, to_body, to_space
from solver.rigid.space.watch import count_impulses
from solver.types import Array


@compiled
def spins(state: SpaceState, frames: Array) -> Array:
    """Angular velocities of all bodies in space, rad/s."""
    spin = np.zeros_like(state.spin)
    for b in range(len(frames) - 1):
        spin[b] = to_space(frames[b], state.spin[b])
    return spin


@compiled
def mobility(model: SpaceModel, frames: Array) -> tuple[Array, Array]:
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
def push(
    model: SpaceModel, state: SpaceState, frames: Array, impulses: tuple[Array, Array, Array]
) -> None:
    """Change the velocities by impulses and their moments on all bodies, as of `act`."""
    yields, _ = mobility(model, frames)
    state.velocity[:, :] += yields * impulses[0]
    for b in range(len(frames) - 1):
        state.spin[b] += to_body(frames[b], impulses[1][b]) / model.inertia[b]


@compiled
def correct_velocity(
    model: SpaceModel, state: SpaceState, s: SpaceSolution, taken: float, tally: Array
) -> None:
    """Contact at velocity level: closed points neither approach nor, inside the cone, slip.

    Friction took `taken` (J) in the step `s`. The impulses are added to those of the step, N s.
    """
    shut = chosen(s.contacts, s.force[:, 0].copy())
    m = len(shut.body)
    if m == 0:
        return
    kept = np.flatnonzero(s.force[:, 0] > 0)
    frames = rotations(state.quaternion)
    shut = moved_on(shut, frames, state.place, 1.0)
    rows = rows_of(shut, frames, state.place)
    yields, turning = mobility(model, frames)
    W = compliance(shut, rows, yields, turning)
    velocity = changes(shut, rows, state.velocity, spins(state, frames)).reshape(3 * m)
    impulse, bounds = s.dt * s.force[kept], Bounds(s.mu[kept], s.dt * s.cohesion[kept], np.inf)
    flat, lands = impulse.reshape(3 * m), bool(np.any(shut.gap > HAIR * np.max(model.half)))
    found = correct_impulses(3, W, velocity, flat, bounds, taken, state.settled, lands)
    if found.found:
        state.exchanged[3] += found.contact
        state.exchanged[1] += found.friction
        impulses = act(shut, rows, found.q.reshape((m, 3)), len(frames))
        count_impulses(model, state, frames, shut, impulses[2], tally)
        push(model, state, frames, impulses)
