"""Momentum of each body in a step against the forces that contact puts on it."""

from __future__ import annotations

import numpy as np

from solver.build.assembly import build, initial_state
from solver.scene import Scene


def imbalance(run: Scene, steps: int, *, petsc_options: tuple[str, ...] = ()) -> float:
    """Largest difference of the forces that blocks get and need in a step, over their weights.

    By the scheme alone, a block moves by m (du - dt v_n) = dt^2/2 (f + c_{n+1}), with f its mean
    weight in the accelerated ground.
    """
    assembly, dt, largest = build(run, petsc_options=petsc_options), run.time.step, 0.0
    stepper, (state, _) = assembly.stepper, initial_state(run, assembly)
    system, gravity = stepper.system, float(np.linalg.norm(stepper.gravity))
    for _ in range(steps):
        started = stepper.prepare(state, dt).contacts
        new, _ = stepper.advance(state, dt)
        given = np.zeros((len(system.bodies), run.dimension))
        for link, before, after in zip(stepper.links, started, new.contacts, strict=True):
            pair = before.kinematics, after.kinematics
            total = link.interface.point_forces(*pair, after.force)[0].sum(axis=0)
            if link.body is not None:
                given[link.body] += total
            if link.carrier is not None:
                given[link.carrier] -= total
        weight = stepper.gravity - stepper.mean_base(state.time, dt)
        for body, own, has in zip(system.bodies, system.slices, given, strict=True):
            moved = system.directional_mass[:, own] @ (new.u - state.u - dt * state.v)[own]
            needs = 2 * moved / dt**2 - body.mass * weight
            largest = max(largest, float(np.abs(has - needs).max()) / (body.mass * gravity))
        state = new
    return largest
