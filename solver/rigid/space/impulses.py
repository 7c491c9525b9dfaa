"""Jumps of the velocities of rigid blocks in space: after a step, and at an impact. Compiled.

`solver.law.velocity` has the first law, `solver.law.impact` the second, for blocks that have a
restitution. A step in which points land is cut at the instant when the first of them touches.
"""

from __future__ import annotations

import numpy as np

from solver.law.compiled import compiled
from solver.law.friction import Bounds, remember_open
from solver.law.impact import impact, rebounds
from solver.law.velocity import correct_impulses
from solver.rigid.bracket import next_length
from solver.rigid.space.contact import (
    TOUCH_TOLERANCE,
    chosen,
    contacts_of,
    halfway,
    moved_on,
    rotations,
    rows_of,
)
from solver.rigid.space.friction import friction_at_start, touched
from solver.rigid.space.model import BEARING, SpaceContacts, SpaceModel, SpaceSolution, SpaceState
from solver.rigid.space.motion import apply_forces, changes, compliance, mean_motion
from solver.rigid.space.rotation import cross, product, to_body, to_space
from solver.rigid.space.rows import count_impulses
from solver.rigid.space.step import solve
from solver.types import Array, Mask


@compiled
def spins(state: SpaceState, frames: Array) -> Array:
    """Angular velocities of all bodies in space, rad/s."""
    spin = np.zeros_like(state.spin)
    for b in range(len(frames) - 1):
        spin[b] = to_space(frames[b], state.spin[b])
    return spin


@compiled
def mobility(model: SpaceModel, frames: Array) -> tuple[Array, Array]:
    """Velocities per impulse: of centres (n + 1, 3) and of rotations (n + 1, 3, 3)."""
    n = len(frames)
    yields, turning = np.zeros((n, 3)), np.zeros((n, 3, 3))
    for b in range(n):
        if model.mass[b] > 0:
            yields[b, : 3 if b < n - 1 else 2] = 1 / model.mass[b]
        if b < n - 1:
            turning[b] = product(frames[b] / model.inertia[b], frames[b].T.copy())
    return yields, turning


@compiled
def push(
    model: SpaceModel, state: SpaceState, frames: Array, impulses: tuple[Array, Array, Array]
) -> None:
    """Change the velocities by impulses and their moments on all bodies, as of `apply_forces`."""
    yields, _ = mobility(model, frames)
    state.velocity[:, :] += yields * impulses[0]
    for b in range(len(frames) - 1):
        state.spin[b] += to_body(frames[b], impulses[1][b]) / model.inertia[b]


@compiled
def correct_velocity(
    model: SpaceModel, state: SpaceState, s: SpaceSolution, taken: float, tally: Array
) -> None:
    """Contact at velocity level: closed points neither approach nor, inside the cone, slip.

    Friction took `taken` (J) in the step `s`. The impulses are added to those of the step, N s.
    """
    shut = chosen(s.contacts, s.force[:, 0].copy())
    m = len(shut.body)
    if m == 0:
        return
    kept = np.flatnonzero(s.force[:, 0] > 0)
    frames = rotations(state.quaternion)
    shut = moved_on(shut, frames, state.place, 1.0)
    rows = rows_of(shut, frames, state.place)
    yields, turning = mobility(model, frames)
    W = compliance(shut, rows, yields, turning)
    velocity = changes(shut, rows, state.velocity, spins(state, frames)).reshape(3 * m)
    impulse, bounds = s.dt * s.force[kept], Bounds(s.mu[kept], s.dt * s.cohesion[kept], np.inf)
    flat, lands = (
        impulse.reshape(3 * m),
        bool(np.any(shut.gap > TOUCH_TOLERANCE * np.max(model.half))),
    )
    found = correct_impulses(3, W, velocity, flat, bounds, taken, state.settled, lands)
    if found.found:
        state.exchanged[3] += found.contact
        state.exchanged[1] += found.friction
        impulses = apply_forces(shut, rows, found.q.reshape((m, 3)), len(frames))
        count_impulses(model, state, frames, shut, impulses[2], tally)
        push(model, state, frames, impulses)


LOCATED = 1e-10
"""A gap at which a point touches, relative to the same."""

SMALLEST_PIECE = 1e-3
"""Impacts closer to the ends of a step than this part of it are taken a hair late, or early."""

LOCATING = 30
"""Tries to find when a point touches."""


@compiled
def gaps_after(
    model: SpaceModel, state: SpaceState, s: SpaceSolution, reach: float, ground: Array
) -> tuple[Array, Array]:
    """Gaps of the points that were clear, at the start and at the end of a step.

    Args:
        model: The bodies.
        state: At its start.
        s: The step; new contacts may be left out of it.
        reach: Step that tells which points are near, s.
        ground: Acceleration of the ground, m/s2.
    """
    frames, tolerance = rotations(state.quaternion), TOUCH_TOLERANCE * np.max(model.half)
    points = contacts_of(model, state, frames, reach, ground)
    clear = (touched(state, points) == 0) & (points.gap > tolerance)
    mean, shift = mean_motion(state, frames, s.moved, s.turned)
    rows = rows_of(halfway(points, state, frames, mean, shift), mean, shift)
    change = changes(points, rows, s.moved, s.turned)
    before = points.gap[clear]
    return before, before + change[:, 0][clear]


@compiled
def step_to_impact(
    model: SpaceModel, state: SpaceState, dt: float, start: Array, slope: Array
) -> tuple[bool, SpaceSolution]:
    """The step without new contacts at whose end the first point touches, if there is one.

    Args:
        model: The bodies.
        state: At the start of the step.
        dt: Longest step, s.
        start: Acceleration of the ground at the start, m/s2.
        slope: By how much it grows, m/s3.
    """
    size, length = np.max(model.half), dt
    bracket = np.zeros(5)
    s = solve(model, state, dt, start, start + dt * slope, False)
    for k in range(LOCATING):
        if not s.settled:
            return False, s
        before, after = gaps_after(model, state, s, dt, start + dt * slope)
        if len(after) == 0 or (k == 0 and np.min(after) > 0.0):
            return False, s
        gap = np.min(after)
        if abs(gap) <= LOCATED * size:
            break
        if k == 0:
            bracket[1] = np.min(before)
        length = next_length(bracket, length, gap)
        s = solve(model, state, length, start, start + length * slope, False)
    if length < SMALLEST_PIECE * dt or length > (1 - SMALLEST_PIECE) * dt:
        length = dt if length > 0.5 * dt else SMALLEST_PIECE * dt
        s = solve(model, state, length, start, start + length * slope, False)
    return s.settled, s


@compiled
def _touch(model: SpaceModel, state: SpaceState, points: SpaceContacts, lands: Mask) -> None:
    """Points that land bear from now on, so that no later piece of the step leaves them out."""
    memory = state.memory
    for q in np.flatnonzero(lands):
        k, slot = points.pair[q], points.slot[q]
        if memory.face[k, slot] != points.face[q]:
            memory.face[k, slot], memory.force[k, slot] = points.face[q], 0.0
            remember_open(model.law, k, memory.past[k, slot], 0.0)
        memory.force[k, slot, 0] = max(memory.force[k, slot, 0], BEARING)


@compiled
def collide(model: SpaceModel, state: SpaceState, dt: float, ground: Array, tally: Array) -> None:
    """Give the velocities a jump where points that touch approach each other, and book it.

    What lands within the smallest piece of a step lands at once.

    Args:
        model: The bodies.
        state: At the impact; its velocities change.
        dt: Length of the step, s.
        ground: Acceleration of the ground, m/s2.
        tally: Of the impulses, as of `accumulate_output`.
    """
    frames, tolerance, soon = (
        rotations(state.quaternion),
        TOUCH_TOLERANCE * np.max(model.half),
        SMALLEST_PIECE * dt,
    )
    points = contacts_of(model, state, frames, soon, ground)
    spin, rows = spins(state, frames), rows_of(points, frames, state.place)
    after = points.gap + soon * changes(points, rows, state.velocity, spin)[:, 0]
    touching = np.zeros(len(points.gap))
    touching[(points.gap <= tolerance) | (after <= 0.0)] = 1.0
    points = chosen(points, touching)
    m = len(points.body)
    if m == 0:
        return
    rows = rows_of(points, frames, state.place)
    velocity = changes(points, rows, state.velocity, spin)
    place, slope = np.empty((m, 3)), np.empty((m, 3))
    for q in range(m):
        i, j = points.body[q], points.base[q]
        place[q] = state.place[i] + to_space(frames[i], points.arm[q])
        slope[q] = cross(rows[0][q, 0], spin[i] - spin[j])
    restitution = model.restitution[points.pair]
    asked = rebounds(restitution, points.pair, place, slope, velocity[:, 0].copy())
    _touch(model, state, points, velocity[:, 0] < 0.0)
    if not np.any(asked.speed > 0.0):
        return
    yields, turning = mobility(model, frames)
    W = compliance(points, rows, yields, turning)
    mu, _ = friction_at_start(model, state, frames, points)
    found = impact(3, W, velocity.reshape(3 * m), asked, mu, state.settled)
    impulses = apply_forces(points, rows, found.impulse.reshape((m, 3)), len(frames))
    push(model, state, frames, impulses)
    state.exchanged[1] += found.friction
    state.exchanged[3] += found.contact
    count_impulses(model, state, frames, points, impulses[2], tally)
