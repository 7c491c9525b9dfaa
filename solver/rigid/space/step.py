"""Taking a step of rigid blocks in space: state, stick memory, energy ledger; compiled."""

from __future__ import annotations

import math

import numpy as np

from solver.law.compiled import compiled
from solver.law.friction import remember, remember_open
from solver.rigid.space.contact import rotations
from solver.rigid.space.friction import at_limit, past_of
from solver.rigid.space.model import AWAY, SpaceModel, SpaceSolution, SpaceState
from solver.rigid.space.rotation import advanced, to_body
from solver.types import Array


@compiled
def _take_centres(
    model: SpaceModel,
    state: SpaceState,
    s: SpaceSolution,
    before: Array,
    after: Array,
    pushed: Array,
) -> None:
    """Centres, velocities and inertia forces; work of the ground, damping, loss of the average.

    To `pushed`, (3,), comes the impulse of the platform on the ground, N s: the mean force of its
    springs is that which the velocity of a step knows, -(2 beta p_{n+1} + (1 - 2 beta) p_n).
    """
    am, af, dt, later = model.scheme[0], model.scheme[1], s.dt, 2 * model.scheme[2]
    last = len(model.mass) - 1
    for k in range(2):
        du, p = s.moved[last, k], state.inertia_force[k]
        spring = model.spring[0] * (state.place[last, k] + (1 - af) * du)
        following = -(spring + am * p) / (1 - am)
        state.exchanged[2] += model.spring[1] * du * du / dt
        state.exchanged[4] += (0.5 - af) * du * (following - p + model.spring[0] * du)
        state.inertia_force[k] = following
        pushed[k] += model.spring[1] * du - dt * (later * following + (1 - later) * p)
    for b in range(last + 1):
        for k in range(3):
            du = s.moved[b, k]
            state.exchanged[0] -= model.mass[b] * du * 0.5 * (before[k] + after[k])
            state.place[b, k] += du
            state.velocity[b, k] = 2 * du / dt - state.velocity[b, k]


@compiled
def _remember(model: SpaceModel, state: SpaceState, s: SpaceSolution) -> None:
    """Memory of all points, and what contact and friction took.

    Friction takes the work on the slip y_t of the law, to which f_t is opposite: never less than 0.
    """
    memory = state.memory
    for q in range(len(s.mu)):
        memory.past[s.contacts.pair[q], s.contacts.slot[q]] = past_of(model, state, s.contacts, q)
    memory.force[:], memory.face[:], memory.rest[:] = 0.0, AWAY, 0.0
    limit = at_limit(s.force, s.mu, s.cohesion)
    for q in range(len(s.mu)):
        k, slot = s.contacts.pair[q], s.contacts.slot[q]
        force, change = s.force[q], s.change[q]
        memory.force[k, slot], memory.face[k, slot] = force, s.contacts.face[q]
        memory.rest[k, slot] = s.contacts.rest[q]
        slip = np.zeros(2)
        if limit[q]:
            slip = change[1:] + s.yielded[q, 1:]
        if force[0] > 0:
            speed = math.hypot(slip[0], slip[1]) / s.dt
            remember(model.law, k, memory.past[k, slot], speed, s.sliding[q], s.dt)
        rubbed = -(force[1] * slip[0] + force[2] * slip[1])
        work = force[0] * change[0] + force[1] * change[1] + force[2] * change[2]
        state.exchanged[1] += rubbed
        state.exchanged[3] -= work + rubbed
    for k in range(memory.past.shape[0]):
        for slot in range(memory.past.shape[1]):
            if not memory.force[k, slot, 0] > 0:
                remember_open(model.law, k, memory.past[k, slot], s.dt)


@compiled
def take(
    model: SpaceModel,
    state: SpaceState,
    s: SpaceSolution,
    before: Array,
    after: Array,
    pushed: Array,
) -> None:
    """Go to the end of a step, `state` being changed in place; velocities are corrected after.

    The impulse of the platform on the ground, N s, is added to `pushed`, (3,).
    """
    frames = rotations(state.quaternion)
    for b in range(len(frames) - 1):
        psi = to_body(frames[b], s.turned[b])
        state.spin[b] = 2 * psi / s.dt - state.spin[b]
        state.quaternion[b] = advanced(state.quaternion[b], s.turned[b])
    _remember(model, state, s)
    _take_centres(model, state, s, before, after, pushed)
