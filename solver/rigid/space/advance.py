"""The loop of rigid blocks in space: steps of the history, divided at impacts; compiled."""

from __future__ import annotations

import numpy as np

from solver.history.columns import RowLayout
from solver.law.compiled import compiled
from solver.rigid.space.contact import contacts_of, halfway, rotations, rows_of
from solver.rigid.space.friction import touched
from solver.rigid.space.model import SpaceModel, SpaceSolution, SpaceState
from solver.rigid.space.motion import changes, mean_motion
from solver.rigid.space.rows import RUN, record
from solver.rigid.space.solve import solve
from solver.rigid.space.step import take
from solver.rigid.space.velocity import correct_velocity
from solver.rigid.space.watch import watch
from solver.types import Array

EARLY = 0.02
"""How much of the way to an impact is left for the step of the impact."""

GRAVE = 0.03
"""An impact later than this part of a step divides it."""

LOOKING, TIMING, TIMED = 0, 1, 2
"""A step in which a point lands is solved once more without new contacts, to tell when."""

HAIR = 1e-9
"""Points nearer than this, relative to the largest half length, do not land: they are there."""


@compiled
def _lands(model: SpaceModel, state: SpaceState, s: SpaceSolution) -> bool:
    """Whether a point that was open, and not by a hair, touches in a step."""
    old, hair = touched(state, s.contacts), HAIR * np.max(model.half)
    for q in range(len(old)):
        if old[q] == 0 and s.force[q, 0] > 0 and s.contacts.gap[q] > hair:
            return True
    return False


@compiled
def _landing(model: SpaceModel, state: SpaceState, s: SpaceSolution, ground: Array) -> float:
    """The part of a step `s` without new contacts after which the first one comes; 1 without.

    The state is that at its start, the ground's acceleration that at its end, m/s2.
    """
    frames, hair = rotations(state.quaternion), HAIR * np.max(model.half)
    points = contacts_of(model, state, frames, s.dt, ground)
    old = touched(state, points)
    mean, shift = mean_motion(state, frames, s.moved, s.turned)
    rows = rows_of(halfway(points, state, frames, mean, shift), mean, shift)
    change = changes(points, rows, s.moved, s.turned)
    first = 1.0
    for q in range(len(change)):
        gap = points.gap[q]
        if old[q] == 0 and gap > hair and change[q, 0] < -gap:
            first = min(first, -gap / change[q, 0])
    return first


@compiled
def _accept(
    model: SpaceModel, state: SpaceState, s: SpaceSolution, start: Array, end: Array, tally: Array
) -> None:
    """Take a step, and correct the velocities at its end."""
    watch(model, state, s, tally)
    rubbed = -state.exchanged[1]
    take(model, state, s, start, end)
    rubbed += state.exchanged[1]
    if model.velocity_solve:
        correct_velocity(model, state, s, rubbed)


@compiled
def run(
    model: SpaceModel,
    state: SpaceState,
    dt: float,
    smallest: float,
    ground: Array,
    shift: Array,
    seen: Array,
    layout: RowLayout,
    rows: Array,
) -> tuple[int, int]:
    """As many steps as there are rows; times and the total at the start are left to the caller.

    A step is divided where a point lands within it, and halved where it fails, down to a smallest.
    The state, the last angles `seen`, (n, 4), and the rows are changed in place. The ground's
    accelerations, (steps + 1, 3), are linear in between; the shift is what their mean over each
    step has beyond that of its ends, (steps, 3), m/s2.

    Returns:
        Number of steps that succeeded, number of rejected solutions.
    """
    tally, rejected, k, done, h, phase = np.zeros((len(seen) + 1, 3)), 0, 0, 0.0, dt, LOOKING
    speed = state.velocity[-1].copy()
    rows[:, RUN.step_s], rows[:, RUN.newton_iterations] = dt, 0.0
    while k < len(rows):
        h, gained = min(h, dt - done), ground[k + 1] - ground[k]
        first = ground[k] + shift[k]
        start, end = first + gained * (done / dt), first + gained * ((done + h) / dt)
        s = solve(model, state, h, start, end, phase != TIMING)
        rows[k, RUN.newton_iterations] += s.iterations
        if phase == TIMING:
            part = _landing(model, state, s, end) if s.settled else 1.0
            if part < 1 and part * h > GRAVE * dt:
                h *= (1 - EARLY) * part
            phase = TIMED
        elif not s.settled:
            h, phase, rejected = 0.5 * h, LOOKING, rejected + 1
            if h < smallest:
                break
        elif phase == LOOKING and _lands(model, state, s):
            phase = TIMING
        else:
            _accept(model, state, s, start, end, tally)
            done += h
            if done > dt * (1 - 1e-9):
                tally /= dt
                gained = (state.velocity[-1] - speed) / dt
                record(model, state, ground[k + 1], seen, tally, gained, layout, rows[k])
                tally[:, :], done, k = 0.0, 0.0, k + 1
                speed[:] = state.velocity[-1]
            h, phase = dt - done, LOOKING
    return k, rejected
