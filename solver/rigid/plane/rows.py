"""Steps of rigid blocks in the plane, and the rows of the history that they leave. Compiled."""

from __future__ import annotations

import math

from solver.law.compiled import borrowed, compiled
from solver.rigid.plane.advance import full_step
from solver.rigid.plane.contact import TOP, distance, local_place, nearest_face
from solver.rigid.plane.model import PlaneMemory, PlaneModel, PlaneState, PlaneWork
from solver.types import Array

#: Columns of the run with that of the vertical ground motion, of a block, a platform, the energies.
RUN, BLOCK, PLATFORM, ENERGY = 6, 10, 3, 12


@compiled
def stored_energy(system: PlaneModel, state: PlaneState) -> tuple[float, float, float]:
    """Kinetic, gravity and spring energy, J."""
    kinetic = float(0.5 * ((system.mass * state.v) @ state.v))
    gravity = -system.gravity[0] * (system.mass_x @ state.q)
    gravity -= system.gravity[1] * (system.mass_y @ state.q)
    spring = 0.0
    if len(state.q) % 3:
        spring = 0.5 * system.spring[0] * state.q[-1] * state.q[-1]
    return kinetic, gravity, spring


@compiled
def still_carried(system: PlaneModel, q: Array, b: int) -> int:
    """What carries block b now: the floor once its centre is below the top of its carrier."""
    c = system.carrier[b]
    if c < 0:
        return c
    x, y = q[3 * b] - q[3 * c], q[3 * b + 1] - q[3 * c + 1]
    above = math.sin(q[3 * c + 2]) * x + math.cos(q[3 * c + 2]) * y
    return c if above > system.half[c, 1] else -1


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
    q, carrier = state.q, still_carried(system, state.q, b)
    row[0], row[1], row[2] = q[3 * b + 2], state.v[3 * b + 2], state.slip[b]
    row[3] = height_over(system, q, b, 0, carrier)
    row[4] = height_over(system, q, b, 1, carrier)
    row[5] = penetration(system, q, b)
    row[6], row[7] = q[3 * b], q[3 * b + 1]
    angle = q[3 * carrier + 2] if carrier >= 0 else 0.0
    cosine, sine = math.cos(angle), math.sin(angle)
    x, y = work.impulse[b, 0] / dt, work.impulse[b, 1] / dt
    row[8], row[9] = sine * x + cosine * y, cosine * x - sine * y


@compiled
def write_energies(system: PlaneModel, state: PlaneState, start: float, row: Array) -> None:
    """The columns of the energies; `start`: total energy at the start of the run, J."""
    kinetic, gravity, spring = stored_energy(system, state)
    total = kinetic + gravity + spring
    row[0], row[1], row[2], row[3], row[4] = kinetic, 0.0, gravity, spring, 0.0
    row[5:10] = state.exchanged
    row[10] = total
    row[11] = total - start - state.exchanged[0] + state.exchanged[1:].sum()


@compiled
def write_row(
    system: PlaneModel,
    state: PlaneState,
    work: PlaneWork,
    dt: float,
    acceleration: float,
    start: float,
    row: Array,
) -> None:
    """What follows the columns of the run."""
    blocks = len(system.half)
    for b in range(blocks):
        write_block(system, state, work, b, dt, row[RUN + BLOCK * b :])
    place = RUN + BLOCK * blocks
    if len(state.q) % 3:
        row[place], row[place + 1], row[place + 2] = state.q[-1], state.v[-1], acceleration
        place += PLATFORM
    write_energies(system, state, start, row[place:])


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
    start: float,
    rows: Array,
) -> tuple[int, int]:
    """Take one step for each row; times are left to the caller.

    Args:
        system: The system.
        state: Changed in place.
        memory: Changed in place.
        work: Room.
        dt: Step, s.
        smallest: No step is halved below this, s.
        ground: Acceleration of the ground at the ends of the steps, m/s2, (rows + 1, 2).
        shift: What its mean over each step has beyond that of its ends, m/s2, (rows, 2).
        start: Total energy at the start of the run, J.
        rows: Written, in the order of `solver.history.history.columns`.

    Returns:
        Number of steps that succeeded (all, or up to the one that failed) and of rejected ones.
    """
    system, state, memory, work = (
        borrowed(system),
        borrowed(state),
        borrowed(memory),
        borrowed(work),
    )
    rejected = 0
    for i in range(len(rows)):
        iterations, speed = work.counts[1], state.v[-1]
        begin, end = ground[i] + shift[i], ground[i + 1] + shift[i]
        outcome = full_step(system, state, memory, work, dt, smallest, begin, end)
        if outcome < 0:
            return i, rejected
        rejected += outcome
        row = rows[i]
        row[1], row[2] = dt, work.counts[1] - iterations
        row[3], row[4], row[5] = memory.closed.sum(), ground[i + 1, 0], ground[i + 1, 1]
        write_row(system, state, work, dt, (state.v[-1] - speed) / dt, start, row)
    return len(rows), rejected
