"""History rows of rigid blocks in space, with the impulses and slips of steps. Compiled."""

from __future__ import annotations

import numpy as np

from solver.history.block_columns import SPACE as BLOCK
from solver.history.block_columns import (
    has_lost_carrier,
    lean_in_space,
    write_space_motion,
)
from solver.history.columns import RowLayout, positions
from solver.law.compiled import compiled
from solver.rigid.rows import write_energies
from solver.rigid.space.boxes import corner, points_between
from solver.rigid.space.contact import rotations, rows_of
from solver.rigid.space.model import SpaceContacts, SpaceModel, SpaceSolution, SpaceState
from solver.rigid.space.motion import mean_motion
from solver.rigid.space.rotation import cross, rotation_vector, to_body, to_space
from solver.types import Array

RUN, PLATFORM = positions("run", 3), positions("platform", 3)
FOUNDATION = positions("foundation", 3)
"""Places of the columns of the run, of the platform and of its base within their parts of a row."""


@compiled
def stored_energy(model: SpaceModel, state: SpaceState) -> tuple[float, float, float]:
    """Kinetic, gravity and spring energy, J."""
    kinetic, gravity, last = 0.0, 0.0, len(model.mass) - 1
    for b in range(len(model.mass)):
        v, w, x = state.velocity[b], state.spin[b], state.place[b]
        kinetic += 0.5 * model.mass[b] * np.sum(v * v)
        kinetic += 0.5 * np.sum(model.inertia[b] * w * w)
        gravity -= model.mass[b] * np.sum(model.gravity * x)
    spring = 0.5 * model.spring[0] * (state.place[last, 0] ** 2 + state.place[last, 1] ** 2)
    return kinetic, gravity, spring


@compiled
def still_carried(model: SpaceModel, state: SpaceState, frames: Array, block: int) -> int:
    """The body that carries a block now.

    It is the ground once it has lost its carrier (`has_lost_carrier`).
    """
    carrier = model.lower[model.carried[block]]
    height = to_body(frames[carrier], state.place[block] - state.place[carrier])[2]
    lost = has_lost_carrier(frames[carrier][2, 2], height, model.half[carrier, 2])
    return len(model.mass) - 1 if lost else carrier


@compiled
def _penetration(model: SpaceModel, state: SpaceState, frames: Array, block: int) -> float:
    """How deep a contact point is where a block is the upper one, m."""
    deepest = 0.0
    for pair in range(len(model.upper)):
        if model.upper[pair] != block:
            continue
        if model.lower[pair] == len(model.mass) - 1:
            for k in range(8):
                arm = to_space(frames[block], corner(model.half[block], k))
                deepest = max(deepest, -(state.place[block, 2] + arm[2]))
        else:
            found = points_between(model, state, frames, pair, 0.0)[3]
            deepest = max(deepest, -np.min(found[:, 0]))
    return deepest


@compiled
def _record_block(
    model: SpaceModel, state: SpaceState, frames: Array, block: int, seen: Array, row: Array
) -> None:
    """The columns of a block but for its forces; `seen`: its last angles, to go on from."""
    carrier, frame = still_carried(model, state, frames, block), frames[block]
    seen[0] = lean_in_space(frame, seen[0])
    seen[1:] = rotation_vector(state.quaternion[block], seen[1:])
    write_space_motion(row, seen, to_space(frame, state.spin[block]), state.place[block])
    row[BLOCK.slip_m], row[BLOCK.slip_second_m] = state.slip[block, 0], state.slip[block, 1]
    shift, gap = state.place[block] - state.place[carrier], np.empty(4)
    for k in range(4):
        arm = to_space(frame, corner(model.half[block], k))
        gap[k] = to_body(frames[carrier], shift + arm)[2] - model.half[carrier, 2]
    row[BLOCK.gap_1_m], row[BLOCK.gap_2_m] = gap[0], gap[1]
    row[BLOCK.gap_3_m], row[BLOCK.gap_4_m] = gap[2], gap[3]
    row[BLOCK.penetration_m] = _penetration(model, state, frames, block)


@compiled
def _record_platform(
    state: SpaceState, acceleration: Array, shear: Array, layout: RowLayout, whole: Array
) -> None:
    """The columns of the platform and of its base in a whole row.

    By its acceleration, m/s2, (3,), and its force on the ground, N, (3,), both means of the step.
    """
    row, base = whole[layout.platform :], whole[layout.foundation :]
    base[FOUNDATION.base_shear_N], base[FOUNDATION.base_shear_second_N] = shear[0], shear[1]
    drift, velocity = state.place[-1], state.velocity[-1]
    row[PLATFORM.drift_m], row[PLATFORM.drift_second_m] = drift[0], drift[1]
    row[PLATFORM.velocity_m_s], row[PLATFORM.velocity_second_m_s] = velocity[0], velocity[1]
    row[PLATFORM.acceleration_m_s2] = acceleration[0]
    row[PLATFORM.acceleration_second_m_s2] = acceleration[1]


@compiled
def record(
    model: SpaceModel,
    state: SpaceState,
    ground: Array,
    seen: Array,
    tally: Array,
    acceleration: Array,
    layout: RowLayout,
    row: Array,
) -> None:
    """Fill in a row from a state, but for the time, the step and the counts of iterations.

    `seen` has the last angles, (n, 4), carried on, `tally` the mean contact forces of the step and
    that on the ground (see `accumulate_output`); the acceleration is the platform's, the mean of
    the step, m/s2. The row's error stands for the energy at the start until the first is taken off.
    """
    n, frames = len(seen), rotations(state.quaternion)
    row[RUN.contact_points_closed] = np.sum(state.memory.force[:, :, 0] > 0)
    row[RUN.base_acceleration_m_s2] = ground[0]
    row[RUN.base_second_acceleration_m_s2] = ground[1]
    row[RUN.base_vertical_acceleration_m_s2] = ground[2]
    for b in range(n):
        own = row[layout.block + layout.stride * b :]
        _record_block(model, state, frames, b, seen[b], own)
        own[BLOCK.normal_force_N], own[BLOCK.friction_force_N] = tally[b, 0], tally[b, 1]
        own[BLOCK.friction_force_second_N] = tally[b, 2]
    if model.mass[n] > 0:
        _record_platform(state, acceleration, tally[n], layout, row)
    write_energies(stored_energy(model, state), state.exchanged, row[layout.energy :])


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
def accumulate_output(model: SpaceModel, state: SpaceState, s: SpaceSolution, tally: Array) -> None:
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
