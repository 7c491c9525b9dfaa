"""What steps of rigid blocks in space do that a history shows: impulses and slip; compiled."""

from __future__ import annotations

import numpy as np

from solver.law.compiled import compiled
from solver.rigid.space.boxes import corner
from solver.rigid.space.contact import rotations, rows_of
from solver.rigid.space.model import SpaceContacts, SpaceModel, SpaceSolution, SpaceState
from solver.rigid.space.motion import mean_motion
from solver.rigid.space.rotation import cross, to_body, to_space
from solver.rigid.space.rows import still_carried
from solver.types import Array


@compiled
def _lowest_corner_moves(
    model: SpaceModel, s: SpaceSolution, mean: Array, shift: Array, u: int
) -> Array:
    """How the lowest bottom corner of a block moves in a step, as seen from what carries it."""
    c = model.lower[model.carried[u]]
    lowest, arm = np.inf, shift[u]
    for k in range(4):
        r = to_space(mean[u], corner(model.half[u], k))
        height = to_body(mean[c], r)[2]
        if height < lowest:
            lowest, arm = height, r
    moved = s.moved[u] - s.moved[c] + cross(s.turned[u], arm)
    return to_body(mean[c], moved - cross(s.turned[c], shift[u] - shift[c] + arm))


@compiled
def count_impulses(
    model: SpaceModel,
    state: SpaceState,
    mean: Array,
    contacts: SpaceContacts,
    impulse: Array,
    tally: Array,
) -> None:
    """Add the impulses of the points on their bodies, (m, 3) in space, N s, to the tally."""
    frames = rotations(state.quaternion)
    for q in range(len(impulse)):
        u = model.upper[contacts.pair[q]]
        sign = 1.0 if contacts.body[q] == u else -1.0
        presses = still_carried(model, state, frames, u)
        push = to_body(mean[presses], sign * impulse[q])
        tally[u, 0] += push[2]  # normal first
        tally[u, 1] += push[0]
        tally[u, 2] += push[1]


@compiled
def watch(model: SpaceModel, state: SpaceState, s: SpaceSolution, tally: Array) -> None:
    """Before a step is taken: add its impulses on the blocks, and how they slip on their carriers.

    The state is still that at its start. `tally` has impulses, normal and tangential to what still
    carries the block, N s, (n + 1, 3); the last row is that of the ground, which `take` fills.
    """
    n, frames = len(state.slip), rotations(state.quaternion)
    mean, shift = mean_motion(state, frames, s.moved, s.turned)
    along, _, _ = rows_of(s.contacts, mean, shift)
    slid, count = np.zeros((n, 3)), np.zeros(n)
    count_impulses(model, state, mean, s.contacts, s.dt * s.pushed, tally)
    for q in range(len(s.mu)):
        u = model.upper[s.contacts.pair[q]]
        carrier = model.lower[model.carried[u]]
        sign = 1.0 if s.contacts.body[q] == u else -1.0
        if s.contacts.pair[q] == model.carried[u] and s.force[q, 0] > 0:
            slid[u] += sign * to_body(mean[carrier], to_body(along[q], s.change[q]))
            count[u] += 1
    for u in range(n):
        if count[u] == 0:
            slid[u] = _lowest_corner_moves(model, s, mean, shift, u)
        state.slip[u] += slid[u, :2] / max(count[u], 1.0)
