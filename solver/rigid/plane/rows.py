"""Steps of rigid blocks in the plane, and the rows of the history that they leave. Compiled."""

from __future__ import annotations

import math

from solver.history.block_columns import PLANE as BLOCK
from solver.history.block_columns import has_lost_carrier, write_plane_motion
from solver.history.columns import RowLayout, positions
from solver.law.compiled import compiled
from solver.rigid.plane.advance import full_step
from solver.rigid.plane.contact import TOP, distance, local_place, nearest_face
from solver.rigid.plane.model import (
    PlaneGround,
    PlaneMemory,
    PlaneModel,
    PlaneState,
    PlaneWork,
)
from solver.rigid.rows import write_energies
from solver.types import Array

RUN, PLATFORM = positions("run", 2), positions("platform", 2)
FOUNDATION = positions("foundation", 2)
"""Places of the columns of the run, of the platform and of its base within their parts of a row."""


@compiled
def stored_energy(system: PlaneModel, state: PlaneState) -> tuple[float, float, float]:
    """Kinetic, gravity and spring energy, J."""
    kinetic = gravity = spring = 0.0
    for k in range(len(state.q)):
        kinetic += 0.5 * system.mass[k] * state.v[k] * state.v[k]
        gravity -= system.gravity[0] * system.mass_x[k] * state.q[k]
        gravity -= system.gravity[1] * system.mass_y[k] * state.q[k]
    if len(state.q) % 3:
        spring = 0.5 * system.spring[0] * state.q[-1] * state.q[-1]
    return kinetic, gravity, spring


@compiled
def still_carried(system: PlaneModel, q: Array, b: int) -> int:
    """What carries block b now: the floor once it has lost its carrier (`has_lost_carrier`)."""
    c = system.carrier[b]
    if c < 0:
        return c
    x, y = q[3 * b] - q[3 * c], q[3 * b + 1] - q[3 * c + 1]
    above = math.sin(q[3 * c + 2]) * x + math.cos(q[3 * c + 2]) * y
    lost = has_lost_carrier(math.cos(q[3 * c + 2]), above, system.half[c, 1])
    return -1 if lost else c


@compiled
def height_over(system: PlaneModel, q: Array, b: int, corner: int, carrier: int) -> float:
    """Gap of a corner of block b over the plane of the carrier's top, or of the floor, m."""
    k = 4 * b + corner
    if carrier >= 0 or system.carrier[b] < 0:
        return distance(system, carrier, TOP, *local_place(system, q, k))[0]
    angle = q[3 * b + 2]
    return (
        q[3 * b + 1]
        - math.sin(angle) * system.corner[k, 0]
        + math.cos(angle) * (system.corner[k, 1])
    )


@compiled
def penetration(system: PlaneModel, q: Array, b: int) -> float:
    """How deep a corner is in a face where block b is the upper one, m."""
    deepest = 0.0
    for k in range(len(system.corner_of)):
        if system.upper[k] == b:
            x, y = local_place(system, q, k)
            face = nearest_face(system, system.face_of[k], x, y)
            gap, beyond = distance(system, system.face_of[k], face, x, y)
            if beyond < 0.0:
                deepest = max(deepest, -gap)
    return deepest


@compiled
def write_block(
    system: PlaneModel, state: PlaneState, work: PlaneWork, b: int, dt: float, row: Array
) -> None:
    """The columns of a block; forces are the means of the step, in the frame of what carries it."""
    q, carrier, k = state.q, still_carried(system, state.q, b), 3 * b
    write_plane_motion(row, q[k + 2], state.v[k + 2], q[k : k + 2])
    row[BLOCK.slip_m] = state.slip[b]
    row[BLOCK.gap_left_m] = height_over(system, q, b, 0, carrier)
    row[BLOCK.gap_right_m] = height_over(system, q, b, 1, carrier)
    row[BLOCK.penetration_m] = penetration(system, q, b)
    angle = q[3 * carrier + 2] if carrier >= 0 else 0.0
    cosine, sine = math.cos(angle), math.sin(angle)
    x, y = work.impulse[b, 0] / dt, work.impulse[b, 1] / dt
    row[BLOCK.normal_force_N] = sine * x + cosine * y
    row[BLOCK.friction_force_N] = cosine * x - sine * y


@compiled
def write_row(
    system: PlaneModel,
    state: PlaneState,
    work: PlaneWork,
    dt: float,
    acceleration: float,
    layout: RowLayout,
    row: Array,
) -> None:
    """The columns of the blocks, of the platform, of the energies and of the platform's base."""
    for b in range(len(system.half)):
        write_block(system, state, work, b, dt, row[layout.block + layout.stride * b :])
    if len(state.q) % 3:
        moving = row[layout.platform :]
        moving[PLATFORM.drift_m], moving[PLATFORM.velocity_m_s] = state.q[-1], state.v[-1]
        moving[PLATFORM.acceleration_m_s2] = acceleration
        row[layout.foundation + FOUNDATION.base_shear_N] = work.pushed[0] / dt
    write_energies(stored_energy(system, state), state.exchanged, row[layout.energy :])


@compiled
def ground_of(ground: Array, shift: Array, i: int, dt: float) -> PlaneGround:
    """How the ground moves in step i, by its accelerations at the ends of all steps."""
    x, y = ground[i, 0] + shift[i, 0], ground[i, 1] + shift[i, 1]
    rise_x = (ground[i + 1, 0] + shift[i, 0] - x) * (1.0 / dt)
    return PlaneGround(x, y, rise_x, (ground[i + 1, 1] + shift[i, 1] - y) * (1.0 / dt))


@compiled
def advance(
    system: PlaneModel,
    state: PlaneState,
    memory: PlaneMemory,
    work: PlaneWork,
    dt: float,
    smallest: float,
    ground: Array,
    shift: Array,
    layout: RowLayout,
    rows: Array,
) -> tuple[int, int]:
    """Take one step for each row; times and the total at the start are left to the caller.

    State, memory, work and rows are changed in place; no step is halved below the smallest, s. The
    ground's accelerations are those at the ends of the steps, (rows + 1, 2); the shift is what
    their mean over each step has beyond that of its ends, (rows, 2), m/s2.

    Returns:
        Number of steps that succeeded (all, or up to the one that failed) and of rejected ones.
    """
    rejected = 0
    for i in range(len(rows)):
        iterations, speed = work.counts[1], state.v[-1]
        moving = ground_of(ground, shift, i, dt)
        outcome = full_step(system, state, memory, work, dt, smallest, moving)
        if outcome < 0:
            return i, rejected
        rejected += outcome
        row = rows[i]
        row[RUN.step_s], row[RUN.newton_iterations] = dt, work.counts[1] - iterations
        row[RUN.contact_points_closed] = memory.closed.sum()
        row[RUN.base_acceleration_m_s2] = ground[i + 1, 0]
        row[RUN.base_vertical_acceleration_m_s2] = ground[i + 1, 1]
        gained = (state.v[-1] - speed) / dt
        write_row(system, state, work, dt, gained, layout, row)
    return len(rows), rejected
