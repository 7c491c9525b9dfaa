"""Forces of the ground on bodies that supports hold or springs tie to it.

A step weighs elastic forces by p (M6), so their mean in it is gamma_n p_{n+1} + (1 - gamma_n) p_n:
with it momentum is balanced to the last digit. At supports p is what (M6) and (M10) make of the
elastic forces there, p_{n+1} = -(F_alpha + alpha_m p_n)/(1 - alpha_m), and so it is for springs.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from solver.bodies.rigid_body import DenseBody
from solver.stepping.balance import Step
from solver.stepping.ledger import StepEnds
from solver.stepping.state import GroundForces, State
from solver.stepping.system import System
from solver.types import Array


class HeldForces(NamedTuple):
    """Forces at the unknowns that do not move, `System.fixed`, N."""

    balance: Array
    """Residual of the step."""
    inertia: Array
    """p there by (M10), with p_n = 0."""


def ground_forces(
    system: System, state: State, step: Step, ends: StepEnds, p: Array, held: HeldForces
) -> tuple[Array, GroundForces]:
    """The p at supports and springs after a step, and what the ground did in it, the mean.

    `p` is that of all other unknowns after the step, N.
    """
    scheme, gamma = step.scheme, step.scheme.gamma
    new: Array = state.held
    nodal: Array = np.zeros(system.size)
    if system.clamped:
        new, nodal = _at_supports(system, state, step, ends, held)
    moving, total = gamma * p + (1 - gamma) * step.p, np.zeros(system.dimension)
    moving[system.fixed] = 2 * scheme.beta * held.inertia
    for body, own in system.grounded:
        drag = body.drag(ends.mean[own])
        total += body.resultant(moving[own] if drag is None else moving[own] - drag)
    return new, GroundForces(nodal, total)


def _at_supports(
    system: System, state: State, step: Step, ends: StepEnds, held: HeldForces
) -> tuple[Array, Array]:
    """The p at supports and springs of meshed bodies after a step, and what these did in it, N."""
    scheme, old = step.scheme, state.held
    am, af, gamma = scheme.alpha_m, scheme.alpha_f, scheme.gamma
    elastic, nodal = np.zeros(system.size), np.zeros(system.size)
    elastic[system.fixed] = held.balance - (1 - am) * held.inertia
    springs: list[tuple[slice, Array]] = []
    for body, own in system.clamped:
        spring, before = body.spring(ends.u[own]), body.spring(state.u[own])
        if spring is not None and before is not None:
            elastic[own] += (1 - af) * spring + af * before
            springs.append((own, body.dashpot(ends.mean[own])))
    new = np.asarray(-(elastic + am * old) / (1 - am), dtype=np.float64)
    mean = gamma * new + (1 - gamma) * old
    for own, dashpot in springs:
        nodal[own] += mean[own] - dashpot
    nodal[system.fixed] = 2 * scheme.beta * held.inertia - mean[system.fixed]
    return new, nodal


def with_impulses(system: System, forces: GroundForces, change: Array, dt: float) -> GroundForces:
    """The forces with what holds supports while velocities change by impulses (m/s) in a step."""
    if not system.clamped:  # on all ranks alike: collective
        return forces
    nodal, total = forces.nodal.copy(), forces.total.copy()
    for body, own in system.clamped:
        impulse = np.zeros(body.size)
        impulse[body.fixed] = body.inertia(change[own])[body.fixed]
        nodal[own] += impulse / dt
        total += body.resultant(impulse) / dt
    return GroundForces(nodal, total)


def forces_at_rest(system: System, state: State, gravity: Array) -> GroundForces:
    """Forces of the ground at the start, where nothing moves yet; gravity in m/s2, (d,)."""
    nodal, total = state.held.copy(), np.zeros(system.dimension)
    weight = gravity @ system.directional_mass
    nodal[system.fixed] = -state.held[system.fixed] - weight[system.fixed]
    for body, own in system.grounded:
        total += body.resultant(state.p[own] if isinstance(body, DenseBody) else nodal[own])
    return GroundForces(nodal, total)
