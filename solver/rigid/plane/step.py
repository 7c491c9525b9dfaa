"""One step of rigid blocks in the plane: its solution, its bookkeeping. Compiled.

Generalized-alpha with impulses outside the average (`solver.scheme.generalized_alpha` has the
formulas): contact at the end of the step, loads by their mean, the dashpot at the mean velocity.
The blocks have no stiffness, so that only the platform has an inertia force p besides, that of its
spring, and the effective mass is diagonal. What is solved for are the contact forces, and with them
the rotations that the rows of contact are taken at.
"""

from __future__ import annotations

import math

from solver.law.compiled import compiled
from solver.law.friction import ITERATIONS, SHARES, remember, remember_open
from solver.law.local_problem import solve
from solver.law.newton import OPEN, product
from solver.rigid.plane.contact import (
    begin_friction,
    bounds_of,
    change,
    compliance,
    follow_friction,
    local_place,
    push,
    write_rows,
)
from solver.rigid.plane.impulses import add_impulses, correct_velocity
from solver.rigid.plane.model import (
    PlaneGround,
    PlaneMemory,
    PlaneModel,
    PlaneState,
    PlaneWork,
)
from solver.types import Array

#: Rows are right when their error moves no point by more than this part of the size of the blocks.
CONVERGED = 1e-16
#: Diagonal added to the compliance of the points, relative to its own.
REGULAR = 1e-9


@compiled
def mean_of(ground: PlaneGround, dt: float) -> tuple[float, float]:
    """The mean acceleration of the ground over a step along x and y, m/s2."""
    x = 0.5 * (ground.x + (ground.x + dt * ground.rise_x))
    return x, 0.5 * (ground.y + (ground.y + dt * ground.rise_y))


@compiled
def free_motion(
    system: PlaneModel, state: PlaneState, work: PlaneWork, dt: float, ground: PlaneGround
) -> None:
    """Write the increment of q without contact forces, and the flexibility of each unknown."""
    free, flexibility, (x, y) = work.free, work.flexibility, mean_of(ground, dt)
    pull_x, pull_y, load = system.gravity[0] - x, system.gravity[1] - y, 0.0
    for k in range(len(free)):
        load = system.mass_x[k] * pull_x + system.mass_y[k] * pull_y
        flexibility[k] = 0.5 * dt * dt * system.flexibility[k]
        free[k] = dt * state.v[k] + flexibility[k] * load
    if len(free) % 3:
        alpha_m, alpha_f, beta = system.scheme[0], system.scheme[1], system.scheme[2]
        k, c, weight = system.spring[0], system.spring[1], 0.5 * (1 - alpha_m) / beta
        u, v, p = state.q[-1], state.v[-1], state.p[0]
        inertial = (1 - alpha_m) / (beta * dt * dt) * system.mass[-1]
        stiffness = inertial + (1 - alpha_f) * k + weight * c / dt
        right = weight * load - k * u + inertial * dt * v
        right += ((1 - alpha_m) * (0.5 / beta - 1) - alpha_m) * p
        free[-1] = right / stiffness
        flexibility[-1] = weight / stiffness


@compiled
def platform_inertia(system: PlaneModel, state: PlaneState, work: PlaneWork) -> None:
    """p_{n+1} of the platform: (1 - alpha_m) p_{n+1} + alpha_m p_n + k u_alpha = 0."""
    alpha_m, alpha_f = system.scheme[0], system.scheme[1]
    spring = system.spring[0] * (state.q[-1] + (1 - alpha_f) * work.increment[-1])
    work.inertia[0] = -(spring + alpha_m * state.p[0]) / (1 - alpha_m)


@compiled
def solve_step(
    system: PlaneModel,
    state: PlaneState,
    memory: PlaneMemory,
    work: PlaneWork,
    dt: float,
    ground: PlaneGround,
) -> bool:
    """Solve a step for the near points in `work`; returns whether it was solved.

    Their forces and places, the increment and the inertia force are written there.
    """
    free_motion(system, state, work, dt, ground)
    work.increment[:] = work.free
    work.slips[:] = 0
    solved = True
    if work.counts[0] > 0:
        solved = contact_iteration(system, state, memory, work, dt)
    if len(work.free) % 3:
        platform_inertia(system, state, work)
    return solved


@compiled
def contact_iteration(
    system: PlaneModel, state: PlaneState, memory: PlaneMemory, work: PlaneWork, dt: float
) -> bool:
    """Iterate rows, friction and forces until none of them changes."""
    count = work.counts[0]
    begin_friction(system, state, memory, work)
    force, states, fixed = work.force[: 2 * count], work.state[:count], work.fixed[: 2 * count]
    for k in range(ITERATIONS * len(SHARES)):
        work.counts[1] += 1
        write_rows(system, state.q, work.increment, work)
        W = definite_compliance(system, work)
        places_without_forces(system, work)
        if not solve(2, W, fixed, bounds_of(work), force, states, work.counts[2:]):
            return False
        pushed = product(W, force)
        for row in range(2 * count):
            work.place[row] = fixed[row] + pushed[row]
        if next_increment(system, work) > CONVERGED * system.size:
            continue
        if not follow_friction(system, memory, work, W, dt, SHARES[k // ITERATIONS]):
            return True
    return False


@compiled
def definite_compliance(system: PlaneModel, work: PlaneWork) -> Array:
    """W of the near points in the step, with the relative diagonal that makes it definite.

    Two sticking corners have four rows on three unknowns.
    """
    W = compliance(system, work, work.flexibility)
    for row in range(len(W)):
        W[row, row] *= 1.0 + REGULAR
    return W


@compiled
def places_without_forces(system: PlaneModel, work: PlaneWork) -> None:
    """Write the free values of the local problem.

    What has sunk in by more than round-off is held where it is: pushed out, it would gain energy.
    """
    for i in range(work.counts[0]):
        gap = work.gap[i] if work.gap[i] > -1e-12 * system.size else 0.0
        work.fixed[2 * i] = gap + change(system, work, 2 * i, work.free)
        work.fixed[2 * i + 1] = work.offset[i] + change(system, work, 2 * i + 1, work.free)


@compiled
def next_increment(system: PlaneModel, work: PlaneWork) -> float:
    """Write the increment by the forces that were found; returns by how much it may be wrong, m.

    What its change does to the rows is smaller by the largest angle of the step.
    """
    last, new, changed, turned = work.increment, work.tried, 0.0, 0.0
    new[:] = work.free
    push(system, work, work.force, work.flexibility, new)
    for k in range(len(new)):
        changed = max(changed, abs(new[k] - last[k]))
    for b in range(len(system.half)):
        turned = max(turned, abs(new[3 * b + 2]))
    last[:] = new
    return changed * turned


@compiled
def finish_step(
    system: PlaneModel,
    state: PlaneState,
    memory: PlaneMemory,
    work: PlaneWork,
    dt: float,
    ground: PlaneGround,
) -> None:
    """Take the solved step: ledger, new state, memory; then contact at velocity level."""
    book_step(system, state, work, dt, ground)
    for row in range(2 * work.counts[0]):
        work.moved[row] = change(system, work, row, work.increment)
    rubbed = book_contact(state, work)
    follow_slip(system, state, work)
    for k in range(len(state.q)):
        state.v[k] = 2.0 * work.increment[k] / dt - state.v[k]
        state.q[k] += work.increment[k]
    state.p[0] = work.inertia[0]
    remember_points(system, memory, work, dt)
    add_impulses(system, work, dt, work.force)
    if system.velocity_solve:
        correct_velocity(system, state, work, dt, rubbed)


@compiled
def book_step(
    system: PlaneModel, state: PlaneState, work: PlaneWork, dt: float, ground: PlaneGround
) -> None:
    """Work of the ground, impulse on it, and what dashpot and averaging of the time stepping take.

    The last is (1/2 - alpha_f) du dr with r = p + k u of the platform. The mean force of its spring
    is that which the velocity of a step knows, -(2 beta p_{n+1} + (1 - 2 beta) p_n).
    """
    du, (x, y) = work.increment, mean_of(ground, dt)
    for k in range(len(du)):
        state.exchanged[0] -= (system.mass_x[k] * x + system.mass_y[k] * y) * du[k]
    if len(du) % 3:
        k, c = system.spring[0], system.spring[1]
        change = work.inertia[0] - state.p[0] + k * du[-1]
        state.exchanged[2] += c * du[-1] * du[-1] / dt
        state.exchanged[4] += (0.5 - system.scheme[1]) * du[-1] * change
        later = 2.0 * system.scheme[2]
        spring = -(later * work.inertia[0] + (1.0 - later) * state.p[0])
        work.pushed[0] += dt * spring + c * du[-1]


@compiled
def book_contact(state: PlaneState, work: PlaneWork) -> float:
    """Friction, returned: -f_t times the way of the anchor; contact: the rest of -f.dy."""
    friction, total, moved = 0.0, 0.0, work.moved
    for i in range(work.counts[0]):
        n, t = 2 * i, 2 * i + 1
        if work.state[i] != OPEN:
            friction -= work.force[t] * work.place[t]
            total -= work.force[n] * moved[n] + work.force[t] * moved[t]
    state.exchanged[1] += friction
    state.exchanged[3] += total - friction
    return friction


@compiled
def follow_slip(system: PlaneModel, state: PlaneState, work: PlaneWork) -> None:
    """Add to the slip of each block the mean way of the points that carry it, or its lowest one's.

    `state` is still that of the start of the step.
    """
    for b in range(len(system.half)):
        way, closed = 0.0, 0
        for i in range(work.counts[0]):
            k = work.points[i]
            if system.upper[k] == b and work.state[i] != OPEN:
                # Backwards on the bottom of a block, along which a tangent points backwards, too.
                way += work.moved[2 * i + 1]
                closed += 1
        if closed > 0:
            state.slip[b] += way / closed
        else:
            state.slip[b] += way_in_flight(system, state.q, work.increment, b)


@compiled
def way_in_flight(system: PlaneModel, q: Array, increment: Array, b: int) -> float:
    """Tangential way of the lowest corner of a block over its carrier."""
    lowest, way, after = math.inf, 0.0, q + increment
    for k in range(4 * b, 4 * b + 4):
        x, y = local_place(system, after, k)
        if y < lowest:
            lowest, way = y, x - local_place(system, q, k)[0]
    if system.carrier[b] < 0 and len(q) % 3:
        way -= increment[-1]
    return way


@compiled
def remember_points(system: PlaneModel, memory: PlaneMemory, work: PlaneWork, dt: float) -> None:
    """Keep gaps, anchors and states of the closed points for the next step, and all pasts."""
    memory.closed[:], moved = 0, work.moved
    for i in range(work.counts[0]):
        if work.state[i] == OPEN:
            continue
        k, n, t = work.points[i], 2 * i, 2 * i + 1
        memory.closed[k], memory.face[k], memory.state[k] = 1, work.face[i], work.state[i]
        memory.gap[k] = work.gap[i] + moved[n]
        memory.offset[k] = work.offset[i] + moved[t] - work.place[t]
        speed, slid = abs(work.place[t]) / dt, work.slips[i] == 1
        remember(system.friction, system.upper[k], memory.past[k], speed, slid, dt)
        memory.force[k, 0], memory.force[k, 1] = work.force[n], work.force[t]
    for k in range(len(memory.past)):
        if memory.closed[k] == 0:
            remember_open(system.friction, system.upper[k], memory.past[k], dt)
