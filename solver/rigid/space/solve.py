"""The equations of one step of rigid blocks in space, compiled.

An iteration takes the rows of the contact points, which depend on how far the bodies turn, from the
last one; increments and contact forces are then those of a linear problem with discs of friction.
It ends when the increments repeat themselves to round-off; the error falls by about the angle of a
step each time.
"""

from __future__ import annotations

import numpy as np

from solver.law.compiled import compiled
from solver.law.friction import ITERATIONS, SHARES, Bounds
from solver.law.local_problem import solve as solve_local
from solver.rigid.space.contact import chosen, contacts_of, halfway, rotations, rows_of
from solver.rigid.space.friction import follow_law, friction_at_start, recalled, sliding_of, touched
from solver.rigid.space.model import SpaceContacts, SpaceModel, SpaceSolution, SpaceState
from solver.rigid.space.motion import (
    act,
    changes,
    compliance,
    free_motion,
    free_turn,
    loads,
    mean_motion,
    regularise,
)
from solver.rigid.space.rotation import to_space
from solver.types import Array, Indices

EVENING = 0.9
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
    total, moment, _ = act(contacts, rows, force, len(free))
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
    model: SpaceModel, state: SpaceState, frames: Array, dt: float, ground: Array, shut: bool
) -> SpaceContacts:
    """The points that may touch; not `shut`: that may bear on."""
    points = contacts_of(model, state, frames, dt, ground)
    return points if shut else chosen(points, touched(state, points))


@compiled
def _error(size: float, moved: Array, turned: Array, whole: Array) -> float:
    """What is left of the increments, m, after one that changed them by `moved` and `turned`.

    What the rows of the next iteration change is smaller by the angle of the step, `whole`.
    """
    step = max(np.max(np.abs(moved)), size * np.max(np.abs(turned)))
    return step * min(1.0, 10 * (np.max(np.abs(whole)) + step / size))


@compiled
def solve(
    model: SpaceModel, state: SpaceState, dt: float, before: Array, after: Array, shut: bool
) -> SpaceSolution:
    """A step of length `dt` from a state, which stays as it is but for the counts `settled`.

    `before` and `after` are accelerations of the ground at both its ends, m/s2. Not `shut`: points
    that were open take no part, whatever happens to them.
    """
    frames, size = rotations(state.quaternion), np.max(model.half)
    points = _points(model, state, frames, dt, after, shut)
    load = loads(model, 0.5 * (before + after))
    free, yields = free_motion(model, state, dt, load)
    force = recalled(state, points)
    mu, cohesion = friction_at_start(model, state, frames, points)
    held = force * np.array([EVENING, 1.0, 1.0])
    moved, turned = _guess(model, state, frames, points, (free, yields, force), dt)
    rounds = 0
    while True:
        hat, turning = free_turn(model, state, frames, turned, dt)
        mean, shift = mean_motion(state, frames, moved, turned)
        rows = rows_of(halfway(points, state, frames, mean, shift), mean, shift)
        still, soft, law = (free, hat), (yields, turning), (mu, cohesion)
        even = ROUND_OFF * size if rounds == 0 else np.inf
        found, softness = _linear(points, rows, still, soft, law, held, force, state.settled, even)
        total, moment, pushed = act(points, rows, force, len(free))
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
