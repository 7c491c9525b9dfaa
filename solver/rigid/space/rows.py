"""History rows of rigid blocks in space, compiled."""

from __future__ import annotations

import math

import numpy as np

from solver.law.compiled import compiled
from solver.rigid.space.boxes import corner
from solver.rigid.space.contact import rotations
from solver.rigid.space.model import SpaceModel, SpaceState
from solver.rigid.space.rotation import rotation_vector, to_body, to_space
from solver.types import Array

# How many columns `solver.history.history` has: of the run, with all directions of the ground's
# acceleration; of a block in space; of a platform in one direction.
RUN, BLOCK, PLATFORM = 7, 20, 3


@compiled
def stored_energies(model: SpaceModel, state: SpaceState) -> Array:
    """Kinetic, gravity and spring energy, J."""
    found, last = np.zeros(3), len(model.mass) - 1
    for b in range(len(model.mass)):
        v, w, x = state.velocity[b], state.spin[b], state.place[b]
        found[0] += 0.5 * model.mass[b] * np.sum(v * v)
        found[0] += 0.5 * np.sum(model.inertia[b] * w * w)
        found[1] -= model.mass[b] * np.sum(model.gravity * x)
    found[2] = 0.5 * model.spring[0] * (state.place[last, 0] ** 2 + state.place[last, 1] ** 2)
    return found


@compiled
def _record_block(
    model: SpaceModel, state: SpaceState, frames: Array, block: int, seen: Array, row: Array
) -> None:
    """The columns of a block but for its forces; `seen`: its last angles, to go on from."""
    carrier, frame = model.lower[model.carried[block]], frames[block]
    lean = math.atan2(frame[0, 2], frame[2, 2])
    seen[0] = lean + 2 * math.pi * np.round((seen[0] - lean) / (2 * math.pi))
    seen[1:] = rotation_vector(state.quaternion[block], seen[1:])
    row[:4] = seen
    row[4:7] = to_space(frame, state.spin[block])
    row[7:9] = state.slip[block]
    shift = state.place[block] - state.place[carrier]
    for k in range(4):
        arm = to_space(frame, corner(model.half[block], k))
        row[9 + k] = to_body(frames[carrier], shift + arm)[2] - model.half[carrier, 2]
    row[14:17] = state.place[block]


@compiled
def _penetrations(model: SpaceModel, state: SpaceState, rows: Array) -> None:
    """The depth of the points that bear, as their forces and the added diagonal left it."""
    for b in range(len(rows)):
        depth = 0.0
        if model.lower[model.carried[b]] == len(rows):
            for k in range(4):
                depth = max(depth, -rows[b, 9 + k])
        rows[b, 13] = depth


@compiled
def record(
    model: SpaceModel, state: SpaceState, ground: Array, seen: Array, tally: Array, row: Array
) -> None:
    """Fill in a row from a state, but for the time, the step and the counts of iterations.

    Args:
        model: The bodies.
        state: The state.
        ground: Acceleration of the ground, m/s2.
        seen: (n, 4) the last angles, carried on.
        tally: (n + 1, 3) mean contact forces of the step, see `_watch`.
        row: The row; its error stands for the energy at the start until the first is taken off.
    """
    n, frames = len(seen), rotations(state.quaternion)
    row[3] = np.sum(state.memory.force[:, :, 0] > 0)
    row[4], row[5], row[6] = ground[0], ground[2], ground[1]  # horizontal, vertical, second
    rows = row[RUN : RUN + n * BLOCK].reshape((n, BLOCK))
    for b in range(n):
        _record_block(model, state, frames, b, seen[b], rows[b])
        rows[b, 17:20] = tally[b]
    _penetrations(model, state, rows)
    at = RUN + n * BLOCK
    if model.mass[n] > 0:
        for axis in range(2):
            pushed = state.inertia_force[axis] + tally[n, axis]
            pushed += model.mass[n] * (model.gravity[axis] - ground[axis])
            pushed -= model.spring[1] * state.velocity[n, axis]
            row[at], row[at + 1] = state.place[n, axis], state.velocity[n, axis]
            row[at + 2] = pushed / model.mass[n]
            at += PLATFORM
    energies = stored_energies(model, state)
    row[at : at + 5] = 0.0
    row[at], row[at + 2], row[at + 3] = energies[0], energies[1], energies[2]
    row[at + 5 : at + 10] = state.exchanged
    row[at + 10] = np.sum(energies)
    row[at + 11] = np.sum(energies) - state.exchanged[0] + np.sum(state.exchanged[1:])
