"""One step of rigid blocks in space: its equations, then state, memory and ledger. Compiled.

An iteration takes the rows of the contact points, which depend on how far the bodies turn, from the
last one; increments and contact forces are then those of a linear problem with discs of friction.
It ends when the increments repeat themselves to round-off; the error falls by about the angle of a
step each time.
"""

from __future__ import annotations

import math

import numpy as np

from solver.law.compiled import compiled
from solver.law.friction import ITERATIONS, SHARES, Bounds, remember, remember_open
from solver.law.local_problem import solve as solve_local
from solver.rigid.space.contact import chosen, contacts_of, halfway, rotations, rows_of
from solver.rigid.space.friction import (
    at_limit,
    follow_law,
    friction_at_start,
    past_of,
    recalled,
    sliding_of,
    touched,
)
from solver.rigid.space.model import AWAY, SpaceContacts, SpaceModel, SpaceSolution, SpaceState
from solver.rigid.space.motion import (
    apply_forces,
    changes,
    compliance,
    free_motion,
    free_turn,
    loads,
    mean_motion,
    regularise,
)
from solver.rigid.space.rotation import advanced, to_body, to_space
from solver.types import Array, Indices

FORCE_SMOOTHING = 0.9
"""Normal forces of which no motion tells (four corners carry a block) become even step by step: if
they were not, a block that slides straight on would begin to turn."""

ROUND_OFF = 1e-15
"""Round-off of increments, relative to the largest half length."""


@compiled
def _turned(hat: Array, turning: Array, moment: Array) -> Array:
    """Cayley vectors with the moments of contact."""
    turned = hat.copy()
    for b in range(len(hat) - 1):
        turned[b] += to_space(turning[b], moment[b])
    return turned


@compiled
def _guess(
    model: SpaceModel,
    state: SpaceState,
    frames: Array,
    contacts: SpaceContacts,
    centres: tuple[Array, Array, Array],
    dt: float,
) -> tuple[Array, Array]:
    """Increments with the contact forces of the last step: a block that rests or slides is done."""
    free, yields, force = centres
    still = np.zeros_like(free)
    for b in range(len(free) - 1):
        still[b] = dt * to_space(frames[b], state.spin[b])
    hat, turning = free_turn(model, state, frames, still, dt)
    rows = rows_of(contacts, frames, state.place + 0.5 * free)
    total, moment, _ = apply_forces(contacts, rows, force, len(free))
    return free + yields * total, _turned(hat, turning, moment)


@compiled
def _linear(
    contacts: SpaceContacts,
    rows: tuple[Array, Array, Array],
    free: tuple[Array, Array],
    yields: tuple[Array, Array],
    law: tuple[Array, Array],
    held: Array,
    force: Array,
    counts: Indices,
    even: float,
) -> tuple[bool, Array]:
    """Contact forces with given rows; returns whether they were found, and D.

    Args:
        contacts: m points.
        rows: Of `rows_of`.
        free: Increments of centres and rotations without contact.
        yields: What forces and moments add to them.
        law: Coefficients of friction, cohesive forces.
        held: (m, 3) forces that the added diagonal D holds on to, N; they become those found first
            where these yield by more than `even`.
        force: (m, 3) guess and answer, N.
        counts: Of outcomes of local problems.
        even: Sum of what the points may give way by D, m.
    """
    W = compliance(contacts, rows, yields[0], yields[1])
    softness = regularise(W)
    q = changes(contacts, rows, free[0], free[1])
    q[:, 0] += contacts.gap
    flat, bounds = force.reshape(force.size), Bounds(law[0], law[1], np.inf)
    states = np.empty(len(q), np.int64)
    found = solve_local(3, W, (q - softness * held).reshape(q.size), bounds, flat, states, counts)
    if found and np.sum(softness * np.abs(force - held)) > even:
        held[:] = force
        shifted = (q - softness * held).reshape(q.size)
        found = solve_local(3, W, shifted, bounds, flat, states, counts)
    return found, softness


@compiled
def _points(
    model: SpaceModel, state: SpaceState, frames: Array, dt: float, ground: Array, include_new: bool
) -> SpaceContacts:
    """The points that may touch; not `include_new`: that may bear on."""
    points = contacts_of(model, state, frames, dt, ground)
    return points if include_new else chosen(points, touched(state, points))


@compiled
def _error(size: float, moved: Array, turned: Array, whole: Array) -> float:
    """What is left of the increments, m, after one that changed them by `moved` and `turned`.

    What the rows of the next iteration change is smaller by the angle of the step, `whole`.
    """
    step = max(np.max(np.abs(moved)), size * np.max(np.abs(turned)))
    return step * min(1.0, 10 * (np.max(np.abs(whole)) + step / size))


@compiled
def solve(
    model: SpaceModel, state: SpaceState, dt: float, before: Array, after: Array, include_new: bool
) -> SpaceSolution:
    """A step of length `dt` from a state, which stays as it is but for the counts `settled`.

    `before` and `after` are accelerations of the ground at both its ends, m/s2. Not `include_new`:
    points that were open take no part, whatever happens to them.
    """
    frames, size = rotations(state.quaternion), np.max(model.half)
    points = _points(model, state, frames, dt, after, include_new)
    load = loads(model, 0.5 * (before + after))
    free, yields = free_motion(model, state, dt, load)
    force = recalled(state, points)
    mu, cohesion = friction_at_start(model, state, frames, points)
    held = force * np.array([FORCE_SMOOTHING, 1.0, 1.0])
    moved, turned = _guess(model, state, frames, points, (free, yields, force), dt)
    rounds = 0
    while True:
        hat, turning = free_turn(model, state, frames, turned, dt)
        mean, shift = mean_motion(state, frames, moved, turned)
        rows = rows_of(halfway(points, state, frames, mean, shift), mean, shift)
        still, soft, law = (free, hat), (yields, turning), (mu, cohesion)
        even = ROUND_OFF * size if rounds == 0 else np.inf
        found, softness = _linear(points, rows, still, soft, law, held, force, state.settled, even)
        total, moment, pushed = apply_forces(points, rows, force, len(free))
        last, moved = moved, free + yields * total
        previous, turned = turned, _turned(hat, turning, moment)
        change, yielded = changes(points, rows, moved, turned), softness * (force - held)
        slip = change[:, 1:] + yielded[:, 1:]
        slid = sliding_of(force, slip, softness, mu, cohesion)
        share = SHARES[rounds // ITERATIONS]
        again = follow_law(model, state, points, slid, slip, dt, law, share)
        rounds += 1
        left = _error(size, moved - last, turned - previous, turned)
        done = bool(found and not again and left <= ROUND_OFF * size)
        if done or not found or rounds == ITERATIONS * len(SHARES):
            break
    return SpaceSolution(
        done, dt, points, rounds, moved, turned, force, change, pushed, mu, cohesion, yielded, slid
    )


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
