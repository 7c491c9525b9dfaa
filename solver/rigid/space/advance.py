"""The loop of rigid blocks in space: steps of the history, divided at impacts; compiled."""

from __future__ import annotations

import numpy as np

from solver.history.columns import RowLayout
from solver.law.compiled import compiled
from solver.rigid.space.contact import TOUCH_TOLERANCE
from solver.rigid.space.friction import touched
from solver.rigid.space.impulses import collide, correct_velocity, gaps_after, step_to_impact
from solver.rigid.space.model import SpaceModel, SpaceSolution, SpaceState
from solver.rigid.space.rows import RUN, accumulate_output, record
from solver.rigid.space.step import solve, take
from solver.types import Array

IMPACT_MARGIN = 0.02
"""How much of the way to an impact is left for the step of the impact."""

MIN_CUT_FRACTION = 0.03
"""An impact later than this part of a step divides it."""

LOOKING, TIMING, TIMED = 0, 1, 2
"""A step in which a point lands is solved once more without new contacts, to tell when."""

CUTS = 5
"""Impacts with a restitution that one step may be cut at; later ones are plastic."""


@compiled
def _lands(model: SpaceModel, state: SpaceState, s: SpaceSolution) -> bool:
    """Whether a point that was open, and not by a hair, touches in a step."""
    old, tolerance = touched(state, s.contacts), TOUCH_TOLERANCE * np.max(model.half)
    for q in range(len(old)):
        if old[q] == 0 and s.force[q, 0] > 0 and s.contacts.gap[q] > tolerance:
            return True
    return False


@compiled
def _landing(model: SpaceModel, state: SpaceState, s: SpaceSolution, ground: Array) -> float:
    """The part of a step `s` without new contacts after which the first one comes; 1 without.

    The state is that at its start, the ground's acceleration that at its end, m/s2.
    """
    first = 1.0
    before, after = gaps_after(model, state, s, s.dt, ground)
    for q in range(len(before)):
        if after[q] < 0.0:
            first = min(first, before[q] / (before[q] - after[q]))
    return first


@compiled
def _accept(
    model: SpaceModel, state: SpaceState, s: SpaceSolution, start: Array, end: Array, tally: Array
) -> None:
    """Take a step, and correct the velocities at its end."""
    accumulate_output(model, state, s, tally)
    rubbed = -state.exchanged[1]
    take(model, state, s, start, end, tally[-1])
    rubbed += state.exchanged[1]
    if model.velocity_solve:
        correct_velocity(model, state, s, rubbed, tally)


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
    Where a block has a restitution it is cut at the instant of an impact. The state, the last
    angles `seen`, (n, 4), and the rows are changed in place. The ground's accelerations,
    (steps + 1, 3), are linear in between; the shift is what their mean over each step has beyond
    that of its ends, (steps, 3), m/s2.

    Returns:
        Number of steps that succeeded, number of rejected solutions.
    """
    tally, rejected, k, done, h, phase = np.zeros((len(seen) + 1, 3)), 0, 0, 0.0, dt, LOOKING
    speed, bounces, cuts = state.velocity[-1].copy(), bool(np.any(model.restitution > 0.0)), 0
    rows[:, RUN.step_s], rows[:, RUN.newton_iterations] = dt, 0.0
    while k < len(rows):
        h, gained = min(h, dt - done), ground[k + 1] - ground[k]
        first = ground[k] + shift[k]
        start, end = first + gained * (done / dt), first + gained * ((done + h) / dt)
        s = solve(model, state, h, start, end, phase != TIMING)
        rows[k, RUN.newton_iterations] += s.iterations
        hits, lands = False, phase == LOOKING and s.settled and _lands(model, state, s)
        if lands and bounces and cuts < CUTS:
            hits, short = step_to_impact(model, state, h, start, gained / dt)
            cuts = cuts + 1 if hits else CUTS
            if hits:
                s, end = short, start + gained * (short.dt / dt)
        if phase == TIMING:
            part = _landing(model, state, s, end) if s.settled else 1.0
            if part < 1 and part * h > MIN_CUT_FRACTION * dt:
                h *= (1 - IMPACT_MARGIN) * part
            phase = TIMED
        elif not s.settled:
            h, phase, rejected = 0.5 * h, LOOKING, rejected + 1
            if h < smallest:
                break
        elif lands and not hits:
            phase = TIMING
        else:
            _accept(model, state, s, start, end, tally)
            if hits:
                collide(model, state, dt, end, tally)
            done += s.dt
            if done > dt * (1 - 1e-9):
                tally /= dt
                gained = (state.velocity[-1] - speed) / dt
                record(model, state, ground[k + 1], seen, tally, gained, layout, rows[k])
                tally[:, :], done, k, cuts = 0.0, 0.0, k + 1, 0
                speed[:] = state.velocity[-1]
            h, phase = dt - done, LOOKING
    return k, rejected
