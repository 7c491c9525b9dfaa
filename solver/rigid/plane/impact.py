"""Impacts of rigid blocks in the plane that have a restitution, at an instant. Compiled.

Where a corner lands, the velocities v_n of the corners along the normals of their faces obey a law
with the impulses P and, in each pair of corners on which a block stands, the rebound of the other:

    0 <= P_n  complementary to  v_n+ - r >= 0,      r = e [-v_n-]_+ of the other corner of the pair.

A block that stands on one corner and lands on the other leaves the first one with e times the speed
of the landing: omega+ = e omega- about the new corner, as in Housner's equation. Where both land at
once, both rebound with e times their speed, as in Newton's law. A corner that lands alone, its
partner in the air, lands without rebound. (A matrix of restitution with e off the diagonal: see
Glocker, An introduction to impacts, 2006.)

Below Housner's e, less than what friction and pressure leave, the old corner has to be held back:
there alone an impulse may pull.
"""

from __future__ import annotations

import math

import numpy as np

from solver.law.compiled import compiled
from solver.law.friction import Bounds
from solver.law.local_problem import solve
from solver.law.velocity import ENERGY_ROUND_OFF, REGULAR, friction_share
from solver.rigid.plane.contact import clear_points, find_points, write_rows
from solver.rigid.plane.friction import begin_friction
from solver.rigid.plane.model import PlaneMemory, PlaneModel, PlaneState, PlaneWork
from solver.rigid.plane.velocity import add_impulses
from solver.types import Array, Indices, Mask

#: Rounds in which the diagonal that makes W definite acts on what the last one changed only.
ROUNDS = 3
#: A corner that moves by less than this part of the speed of the landing is a pivot.
PIVOT = 1e-6
#: Tries to find an impulse, ten times as large each, that pulling impulses stay below.
TRIES = 8


@compiled
def collide(system: PlaneModel, state: PlaneState, memory: PlaneMemory, work: PlaneWork) -> None:
    """Give the velocities a jump where corners that touch approach their faces, and book it."""
    find_points(system, state, memory, work, 0.0, 0.0)
    count = clear_points(system, work)
    work.counts[0] = count
    begin_friction(system, state, memory, work)
    work.increment[:] = 0.0
    write_rows(system, state.q, work.increment, work)
    rows = work.rows[: 2 * count]
    velocity = rows @ state.v
    rebound, pivots = rebounds(system, work, velocity)
    if not np.any(rebound > 0.0):
        return
    W = (rows * system.flexibility) @ rows.T
    impulse = impulses(W, velocity, rebound, pivots, work)
    spent = impulse * (velocity + 0.5 * (W @ impulse))
    lost, tangential = -np.sum(spent), -np.sum(spent[1::2])
    friction = friction_share(tangential, lost, 0.0)
    state.v[:] += (impulse @ rows) * system.flexibility
    state.exchanged[1] += friction
    state.exchanged[3] += lost - friction
    add_impulses(system, work, impulse)


@compiled
def rebounds(system: PlaneModel, work: PlaneWork, velocity: Array) -> tuple[Array, Mask]:
    """Rebound of each touching point, m/s, and whether it is the pivot of a block that lands.

    `work` has the touching points and their rows at rest, `velocity` those before the impact, flat,
    m/s.
    """
    count = work.counts[0]
    rebound, pivots = np.zeros(count), np.zeros(count, dtype=np.bool_)
    for i in range(count):
        j = partner(system, work, i)
        if j >= 0 and velocity[2 * j] < 0.0:
            rebound[i] = -system.restitution[system.upper[work.points[i]]] * velocity[2 * j]
            pivots[i] = abs(velocity[2 * i]) < PIVOT * abs(velocity[2 * j])
    return rebound, pivots


@compiled
def partner(system: PlaneModel, work: PlaneWork, i: int) -> int:
    """The touching point of the same two bodies that is farthest along their face; -1: none."""
    k, found, farthest = work.points[i], -1, 0.0
    upper = system.upper[k]
    other = system.corner_of[k] + system.face_of[k] - upper
    for j in range(work.counts[0]):
        m = work.points[j]
        if system.upper[m] != upper:
            continue
        if system.corner_of[m] + system.face_of[m] - upper != other:
            continue
        # The arms of the normals about the centre of the upper block.
        apart = abs(work.rows[2 * i, 3 * upper + 2] - work.rows[2 * j, 3 * upper + 2])
        if apart > farthest:
            found, farthest = j, apart
    return found


@compiled
def impulses(W: Array, velocity: Array, rebound: Array, pivots: Mask, work: PlaneWork) -> Array:
    """Impulses of the touching points, flat, N s; those of no rebound where none were found."""
    count, none = len(rebound), np.zeros(len(rebound))
    mu = work.friction[:count].copy()
    plastic, solved = settle(W, velocity, none, mu, none, work.counts[2:])
    if not solved:
        return np.zeros(2 * count)
    found, solved = settle(W, velocity, rebound, mu, none, work.counts[2:])
    if not solved:
        return plastic
    after, pull = velocity + W @ found, none.copy()
    for i in range(count):
        if pivots[i] and after[2 * i] > rebound[i] * (1.0 + PIVOT):
            pull[i], mu[i] = np.sum(plastic[::2]), 0.0
    for _ in range(TRIES):
        if not np.any(pull > 0.0):
            break
        held, solved = settle(W, velocity, rebound, mu, pull, work.counts[2:])
        if solved and np.all((pull == 0.0) | (held[::2] > -0.5 * pull)):
            found = held
            break
        pull *= 10.0
    return without_gain(W, velocity, plastic, found)


@compiled
def settle(
    W: Array, velocity: Array, rebound: Array, mu: Array, pull: Array, counts: Indices
) -> tuple[Array, bool]:
    """Solve the law of impact; `pull`: by how much impulses may fall below 0, N s."""
    count = len(rebound)
    diagonal, regular = np.zeros(2 * count), W.copy()
    shift, total = np.zeros(2 * count), np.zeros(2 * count)
    for k in range(2 * count):
        diagonal[k] = REGULAR * W[k, k]
        regular[k, k] += diagonal[k]
    shift[::2] = pull
    aim = velocity - W @ shift
    aim[::2] -= rebound
    states, bounds = np.empty(count, np.int64), Bounds(mu, np.zeros(count), np.inf)
    for _ in range(ROUNDS):
        free = aim - diagonal * total
        if not solve(2, regular, free, bounds, total, states, counts):
            return total, False
    return total - shift, True


@compiled
def without_gain(W: Array, velocity: Array, plastic: Array, found: Array) -> Array:
    """The impulses, on the way from those without rebound as far as no energy is gained.

    Newton's law of impact and friction together may give more than there was. What is lost on the
    way is a parabola that begins with what the plastic impact loses.
    """
    way = found - plastic
    lost = -np.sum(plastic * (velocity + 0.5 * (W @ plastic)))
    slope = -np.sum(way * (velocity + W @ plastic))
    curve = 0.5 * np.sum(way * (W @ way))
    if lost + slope - curve >= -ENERGY_ROUND_OFF * np.sum(np.abs(found * velocity)):
        return found
    part = (slope + math.sqrt(slope * slope + 4.0 * curve * max(lost, 0.0))) / (2.0 * curve)
    return plastic + min(max(part, 0.0), 1.0) * way
