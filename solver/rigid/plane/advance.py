"""A full step of rigid blocks in the plane, in pieces where something happens in it. Compiled.

Where a corner that was clear of a face would touch it within a step, or a slip would end, the step
is cut there. Uncut steps are of first order at these events: the reaction of the old pivot is
missing for the part of the step before the impact, and friction does not turn round before the next
step. A step whose contact problem is not solved is halved.
"""

from __future__ import annotations

import math

import numpy as np

from solver.law.compiled import compiled
from solver.law.newton import OPEN
from solver.rigid.bracket import next_length
from solver.rigid.plane.contact import (
    TOUCHING,
    change,
    clear_points,
    distance,
    find_points,
    local_place,
    tangential_velocity,
)
from solver.rigid.plane.impulses import collide, hits
from solver.rigid.plane.model import (
    PlaneGround,
    PlaneMemory,
    PlaneModel,
    PlaneState,
    PlaneWork,
)
from solver.rigid.plane.step import finish_step, solve_step

#: Impacts closer to the ends of a step than this part of it are taken there; ends of slip are not.
SMALLEST_PIECE = 1e-3
#: Cuts of one step for each block. What lands later in it, as a block that comes to rest does, does
#: so within a piece: its impact is of first order then, and obeys the law of impact all the same.
CUTS = 5
#: Tries to find where to cut.
LOCATING = 30
#: Slip slower than this part of what gravity and ground give in a step may end anywhere in it.
SLIP_VELOCITY_TOLERANCE = 1e-3
#: A slip has ended when this part of its velocity at the start of the step is left.
STOP_TOLERANCE = 1e-6


@compiled
def smallest_gap(
    system: PlaneModel, state: PlaneState, work: PlaneWork, first: int, last: int
) -> float:
    """Smallest gap at the end of the solved step of the near points first to last - 1."""
    smallest, q = math.inf, state.q + work.increment
    for i in range(first, last):
        k = work.points[i]
        x, y = local_place(system, q, k)
        gap = distance(system, system.face_of[k], work.face[i], x, y)[0]
        smallest = min(smallest, gap)
    return smallest


@compiled
def end_of_slip(
    system: PlaneModel, state: PlaneState, work: PlaneWork, i: int, dt: float
) -> tuple[float, float]:
    """Tangential velocity of a near point at the start and the end of the solved step."""
    begin = tangential_velocity(system, state, work, i)
    return begin, 2.0 * change(system, work, 2 * i + 1, work.increment) / dt - begin


@compiled
def reverses(system: PlaneModel, state: PlaneState, work: PlaneWork, dt: float, pull: float) -> int:
    """The first closed point whose velocity along its face changes sign in the step, or -1."""
    for i in range(work.counts[0]):
        if work.state[i] != OPEN:
            begin, end = end_of_slip(system, state, work, i, dt)
            if begin * end < 0.0 and abs(begin) > SLIP_VELOCITY_TOLERANCE * dt * pull:
                return i
    return -1


@compiled
def inside(length: float, step: float) -> float:
    """The length if it lies well inside the step, else 0."""
    return length if SMALLEST_PIECE * step < length < (1 - SMALLEST_PIECE) * step else 0.0


@compiled
def locate_impact(
    system: PlaneModel,
    state: PlaneState,
    memory: PlaneMemory,
    work: PlaneWork,
    step: float,
    ground: PlaneGround,
) -> float:
    """Length of the step after which the first clear point touches; that step is then solved.

    The steps that are tried leave the clear points out. An impact near an end of the step is taken
    there, a hair late or early.

    Returns:
        The length, s; 0 where none was found inside the step.
    """
    near, touching = work.counts[0], clear_points(system, work)
    work.counts[0] = touching
    bracket, length = np.zeros(5), step
    bracket[1] = work.gap[touching:near].min()
    for k in range(LOCATING):
        if not solve_step(system, state, memory, work, length, ground):
            return 0.0
        gap = smallest_gap(system, state, work, touching, near)
        if abs(gap) <= 0.1 * TOUCHING * system.size:
            if inside(length, step) > 0.0:
                return length
            length = step if length > 0.5 * step else SMALLEST_PIECE * step
            return length if solve_step(system, state, memory, work, length, ground) else 0.0
        if k == 0 and gap > 0.0:
            return 0.0
        length = next_length(bracket, length, gap)
    return 0.0


@compiled
def locate_reversal(
    system: PlaneModel,
    state: PlaneState,
    memory: PlaneMemory,
    work: PlaneWork,
    step: float,
    ground: PlaneGround,
    point: int,
) -> float:
    """Length of the step at whose end near point `point` stops to slip; that step is then solved.

    Returns:
        The length, s; 0 where none was found inside the step.
    """
    begin, end = end_of_slip(system, state, work, point, step)
    bracket, length = np.zeros(5), step
    bracket[1] = abs(begin)
    for _ in range(LOCATING):
        way = end if begin > 0.0 else -end
        if abs(way) <= STOP_TOLERANCE * abs(begin):
            return inside(length, step)
        length = next_length(bracket, length, way)
        if length < SMALLEST_PIECE * step:
            return 0.0
        if not solve_step(system, state, memory, work, length, ground):
            return 0.0
        end = end_of_slip(system, state, work, point, length)[1]
    return 0.0


@compiled
def piece_of_step(
    system: PlaneModel,
    state: PlaneState,
    memory: PlaneMemory,
    work: PlaneWork,
    piece: float,
    ground: PlaneGround,
    locating: bool,
) -> tuple[float, bool]:
    """Solve a step, cut short at an impact or at the end of a slip.

    Returns:
        Its length, s; negative if it was not solved, 0 if the cut was not found. Whether it ends
        with an impact.
    """
    pull = abs(system.gravity[0]) + abs(system.gravity[1]) + (abs(ground.x) + abs(ground.y))
    pull += piece * (abs(ground.rise_x) + abs(ground.rise_y))
    find_points(system, state, memory, work, piece, pull)
    if not solve_step(system, state, memory, work, piece, ground):
        return -1.0, False
    if not locating:
        return piece, False
    if hits(system, work):
        length = locate_impact(system, state, memory, work, piece, ground)
        return length, length > 0.0
    point = reverses(system, state, work, piece, pull)
    if point >= 0:
        length = locate_reversal(system, state, memory, work, piece, ground, point)
        return length, False
    return piece, False


@compiled
def later(ground: PlaneGround, time: float) -> PlaneGround:
    """The acceleration of the ground from a later time on, s."""
    x, y = ground.x + time * ground.rise_x, ground.y + time * ground.rise_y
    return PlaneGround(x, y, ground.rise_x, ground.rise_y)


@compiled
def full_step(
    system: PlaneModel,
    state: PlaneState,
    memory: PlaneMemory,
    work: PlaneWork,
    dt: float,
    smallest: float,
    ground: PlaneGround,
) -> int:
    """One step of the run, in pieces where it has to be; number of rejected ones, -1 if it failed.

    After a failure the state is that of the last piece that succeeded.
    """
    work.impulse[:, :] = 0.0
    work.pushed[0] = 0.0
    done, piece, rejected, locating = 0.0, dt, 0, True
    cuts = CUTS * len(system.half)
    while done < dt * (1 - 1e-12):
        piece = min(piece, dt - done)
        begin, cutting = later(ground, done), locating and cuts > 0
        taken, lands = piece_of_step(system, state, memory, work, piece, begin, cutting)
        if taken < 0.0:
            rejected += 1
            piece *= 0.5
            if piece < smallest:
                return -1
        elif taken == 0.0:
            locating = False
        else:
            cuts, locating = cuts - 1, True
            finish_step(system, state, memory, work, taken, begin)
            if lands and np.any(system.restitution > 0.0):
                collide(system, state, memory, work)
            done += taken
            piece = dt - done
    return rejected
