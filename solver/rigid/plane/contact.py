"""Contact points of rigid blocks in the plane: gaps, rows, compliance, friction. Compiled.

A contact point is a corner of one block and a face of another, or the floor. Gap and tangential
place are taken in the frame of the block that has the face. A row has numbers for two bodies only:
that of the corner, and that of the face or the platform.

`solver.law.friction` has the law of friction. Without decay a point that is new or stuck in the
last step holds up to mu_s; one that slipped has mu_d.
"""

from __future__ import annotations

import math

import numpy as np

from solver.law.compiled import compiled
from solver.law.friction import Bounds, eased, followed, held, slips
from solver.law.newton import OPEN, STICK
from solver.rigid.plane.model import PlaneMemory, PlaneModel, PlaneState, PlaneWork
from solver.types import Array

#: Lengths below this part of the size of the blocks tell no side of a corner from the other.
CORNER_SIZE = 1e-6
#: Gaps below this part of the size of the blocks are round-off.
ROUND_OFF = 1e-12
#: Corners closer than this part of the size of the blocks touch already.
TOUCHING = 1e-9

TOP = 2


@compiled
def local_place(system: PlaneModel, q: Array, k: int) -> tuple[float, float]:
    """Place of the corner of point k in the frame of its face's block; in space for the floor."""
    b, c = system.corner_of[k], system.face_of[k]
    cosine, sine = math.cos(q[3 * b + 2]), math.sin(q[3 * b + 2])
    X, Y = system.corner[k, 0], system.corner[k, 1]
    x = q[3 * b] + cosine * X + sine * Y
    y = q[3 * b + 1] - sine * X + cosine * Y
    if c < 0:
        return x, y
    x -= q[3 * c]
    y -= q[3 * c + 1]
    cosine, sine = math.cos(q[3 * c + 2]), math.sin(q[3 * c + 2])
    return cosine * x - sine * y, sine * x + cosine * y


@compiled
def distance(system: PlaneModel, c: int, face: int, x: float, y: float) -> tuple[float, float]:
    """Gap of a local place to a face, and how far beyond the face's end it lies (inside: < 0)."""
    if c < 0:
        return y, -math.inf
    width, height = system.half[c, 0], system.half[c, 1]
    if face == 0:
        return -y - height, abs(x) - width
    if face == 1:
        return x - width, abs(y) - height
    if face == 2:
        return y - height, abs(x) - width
    return -x - width, abs(y) - height


@compiled
def nearest_face(system: PlaneModel, c: int, x: float, y: float) -> int:
    """The face of least penetration; at a corner of the block the top or bottom one."""
    if c < 0:
        return TOP
    upright = abs(y) - system.half[c, 1] + CORNER_SIZE * system.size
    if upright >= abs(x) - system.half[c, 0]:
        return 2 if y > 0.0 else 0
    return 1 if x > 0.0 else 3


@compiled
def local_velocity(system: PlaneModel, state: PlaneState, k: int) -> tuple[float, float, float]:
    """Velocity of point k in the frame of its face's block; a bound for its changes in a step."""
    q, v = state.q, state.v
    b, c = system.corner_of[k], system.face_of[k]
    cosine, sine = math.cos(q[3 * b + 2]), math.sin(q[3 * b + 2])
    X, Y = system.corner[k, 0], system.corner[k, 1]
    spin = v[3 * b + 2]
    arm_x, arm_y = cosine * X + sine * Y, -sine * X + cosine * Y
    x, y = v[3 * b] + spin * arm_y, v[3 * b + 1] - spin * arm_x
    bound = abs(v[3 * b]) + abs(v[3 * b + 1]) + 2.0 * system.size * abs(spin)
    if c < 0:
        drift = v[-1] if len(v) % 3 else 0.0
        return x - drift, y, bound + abs(drift)
    spin = v[3 * c + 2]
    far_x, far_y = q[3 * b] + arm_x - q[3 * c], q[3 * b + 1] + arm_y - q[3 * c + 1]
    x -= v[3 * c] + spin * far_y
    y -= v[3 * c + 1] - spin * far_x
    bound += abs(v[3 * c]) + abs(v[3 * c + 1]) + 2.0 * system.size * abs(spin)
    cosine, sine = math.cos(q[3 * c + 2]), math.sin(q[3 * c + 2])
    return cosine * x - sine * y, sine * x + cosine * y, bound


@compiled
def tangential_velocity(system: PlaneModel, state: PlaneState, work: PlaneWork, i: int) -> float:
    """Velocity of a near point along its face, m/s; the tangent is the normal turned clockwise."""
    x, y, _ = local_velocity(system, state, work.points[i])
    face = work.face[i]
    if face == TOP:
        return x
    if face == 0:
        return -x
    return -y if face == 1 else y


@compiled
def find_points(
    system: PlaneModel,
    state: PlaneState,
    memory: PlaneMemory,
    work: PlaneWork,
    dt: float,
    pull: float,
) -> None:
    """List in `work` the points that may touch a face during a step, with their gaps and offsets.

    Accelerations of gravity and ground are no larger than `pull`, m/s2.
    """
    count, tiny = 0, CORNER_SIZE * system.size
    for k in range(len(system.corner_of)):
        b, c = system.corner_of[k], system.face_of[k]
        x, y = local_place(system, state.q, k)
        face = nearest_face(system, c, x, y)
        gap, beyond = distance(system, c, face, x, y)
        speed_x, speed_y, bound = local_velocity(system, state, k)
        if gap > 2.0 * dt * bound + 4.0 * dt * dt * pull + tiny:
            continue
        # At the ends of a face the corners of the upper block count, not those of its carrier too.
        edge = tiny if system.upper[k] == b else -tiny
        if beyond > edge:
            beyond = distance(system, c, face, x + dt * speed_x, y + dt * speed_y)[1]
            if beyond > edge:
                continue
        stays = memory.closed[k] == 1 and memory.face[k] == face
        if stays and abs(gap - memory.gap[k]) < ROUND_OFF * system.size:
            gap = memory.gap[k]
        work.points[count], work.face[count], work.gap[count] = k, face, gap
        work.offset[count] = memory.offset[k] if stays else 0.0
        work.state[count] = memory.state[k] if stays else 0
        work.force[2 * count] = memory.force[k, 0] if stays else 0.0
        work.force[2 * count + 1] = memory.force[k, 1] if stays else 0.0
        count += 1
    work.counts[0] = count


@compiled
def clear_points(system: PlaneModel, work: PlaneWork) -> int:
    """Move the points that are clear of their face behind the others; returns how many are not."""
    touching = 0
    for i in range(work.counts[0]):
        if work.gap[i] > TOUCHING * system.size:
            continue
        for field in (work.points, work.face, work.state):
            field[touching], field[i] = field[i], field[touching]
        for length in (work.gap, work.offset):
            length[touching], length[i] = length[i], length[touching]
        for d in range(2):
            a, b = 2 * touching + d, 2 * i + d
            work.force[a], work.force[b] = work.force[b], work.force[a]
        touching += 1
    return touching


@compiled
def cardinal_sine(x: float) -> float:
    """sin(x)/x."""
    return math.sin(x) / x if abs(x) > 1e-4 else 1.0 - x * x / 6.0


@compiled
def write_rows(system: PlaneModel, q: Array, increment: Array, work: PlaneWork) -> None:
    """Rows G with G dq = change of gap and tangential place, exactly, for this increment dq.

    They stand at mid-step: R_{n+1} - R_n = 2 sin(dtheta/2) J R_m for each block, and in the frame
    of a turning face, with d from its block's centre to the point,

        R_{n+1}^T d_{n+1} - R_n^T d_n
            = R_m^T [cos(dtheta/2) (d_{n+1} - d_n) - 2 sin(dtheta/2) J (d_n + d_{n+1})/2].

    With an increment of zero they are the rows of the velocities.
    """
    rows = work.rows
    for i in range(work.counts[0]):
        for j in range(len(q)):
            rows[2 * i, j] = rows[2 * i + 1, j] = 0.0
        k = work.points[i]
        b, c = 3 * system.corner_of[k], 3 * system.face_of[k]
        half = 0.5 * increment[b + 2]
        cosine, sine = math.cos(q[b + 2] + half), math.sin(q[b + 2] + half)
        X, Y = system.corner[k, 0], system.corner[k, 1]
        arm_x, arm_y = cosine * X + sine * Y, -sine * X + cosine * Y
        turned, n, t = cardinal_sine(half), 2 * i, 2 * i + 1
        if c < 0:
            rows[n, b + 1], rows[n, b + 2] = 1.0, -turned * arm_x
            rows[t, b], rows[t, b + 2] = 1.0, turned * arm_y
            if len(q) % 3:
                rows[t, len(q) - 1] = -1.0
            continue
        rest = 0.5 * increment[c + 2]
        chord = math.cos(rest)
        cosine, sine = math.cos(q[c + 2] + rest), math.sin(q[c + 2] + rest)
        short = math.cos(half)
        d_x = q[b] - q[c] + 0.5 * (increment[b] - increment[c]) + short * arm_x
        d_y = q[b + 1] - q[c + 1] + 0.5 * (increment[b + 1] - increment[c + 1]) + short * arm_y
        carried = cardinal_sine(rest)
        face = work.face[i]
        if face == 0:
            n_x, n_y = -sine, -cosine
        elif face == 1:
            n_x, n_y = cosine, -sine
        elif face == 2:
            n_x, n_y = sine, cosine
        else:
            n_x, n_y = -cosine, sine
        fill_row(rows, n, b, c, n_x, n_y, chord, turned, carried, arm_x, arm_y, d_x, d_y)
        fill_row(rows, t, b, c, n_y, -n_x, chord, turned, carried, arm_x, arm_y, d_x, d_y)


@compiled
def fill_row(
    rows: Array,
    row: int,
    b: int,
    c: int,
    a_x: float,
    a_y: float,
    chord: float,
    turned: float,
    carried: float,
    arm_x: float,
    arm_y: float,
    d_x: float,
    d_y: float,
) -> None:
    """One row along (a_x, a_y) between two blocks; J (x, y) = (y, -x)."""
    rows[row, b], rows[row, b + 1] = chord * a_x, chord * a_y
    rows[row, b + 2] = chord * turned * (a_x * arm_y - a_y * arm_x)
    rows[row, c], rows[row, c + 1] = -chord * a_x, -chord * a_y
    rows[row, c + 2] = -carried * (a_x * d_y - a_y * d_x)


@compiled
def area(system: PlaneModel, work: PlaneWork, state: PlaneState, i: int) -> float:
    """Area that cohesion acts on at a point, m2: half of what the two faces share."""
    k, sideways = work.points[i], work.face[i] % 2  # 1 where the face is a side of its block
    b, c = system.corner_of[k], system.face_of[k]
    turn = state.q[3 * b + 2] - (state.q[3 * c + 2] if c >= 0 else 0.0)
    crosswise = 1 if abs(math.sin(turn)) > math.sqrt(0.5) else 0
    length, thickness = system.half[b, (sideways + crosswise) % 2], system.thickness[b]
    if c < 0:
        return length * thickness
    cosine, sine = math.cos(state.q[3 * c + 2]), math.sin(state.q[3 * c + 2])
    x, y = state.q[3 * b] - state.q[3 * c], state.q[3 * b + 1] - state.q[3 * c + 1]
    along = sine * x + cosine * y if sideways == 1 else cosine * x - sine * y
    reach = system.half[c, sideways]
    shared = min(along + length, reach) - max(along - length, -reach)
    return max(0.0, 0.5 * shared) * min(thickness, system.thickness[c])


@compiled
def unknowns_of(system: PlaneModel, work: PlaneWork, i: int) -> tuple[int, int, int]:
    """The first unknown of the corner's block of a near point; that of what has the face, and end.

    The ground has none, the platform one.
    """
    k, n = work.points[i], len(system.mass)
    b, c = 3 * system.corner_of[k], 3 * system.face_of[k]
    return (b, c, c + 3) if c >= 0 else (b, n - n % 3, n)


@compiled
def change(system: PlaneModel, work: PlaneWork, row: int, motion: Array) -> float:
    """A row times a motion: an increment or a velocity of all unknowns."""
    b, other, end = unknowns_of(system, work, row // 2)
    rows = work.rows
    total = rows[row, b] * motion[b] + rows[row, b + 1] * motion[b + 1]
    total += rows[row, b + 2] * motion[b + 2]
    for k in range(other, end):
        total += rows[row, k] * motion[k]
    return total


@compiled
def push(
    system: PlaneModel, work: PlaneWork, force: Array, flexibility: Array, motion: Array
) -> None:
    """Add to a motion what forces or impulses at the near points, flat, move all unknowns by."""
    for i in range(work.counts[0]):
        b, other, end = unknowns_of(system, work, i)
        normal, tangential, rows = force[2 * i], force[2 * i + 1], work.rows
        for k in range(b, b + 3):
            share = normal * rows[2 * i, k] + tangential * rows[2 * i + 1, k]
            motion[k] += flexibility[k] * share
        for k in range(other, end):
            share = normal * rows[2 * i, k] + tangential * rows[2 * i + 1, k]
            motion[k] += flexibility[k] * share


@compiled
def compliance(system: PlaneModel, work: PlaneWork, flexibility: Array) -> Array:
    """G diag(flexibility) G^T of the near points, (2 m, 2 m)."""
    size, rows = 2 * work.counts[0], work.rows
    W = np.empty((size, size))
    for row in range(size):
        b, other, end = unknowns_of(system, work, row // 2)
        for column in range(row + 1):
            total = 0.0
            for k in range(b, b + 3):
                total += rows[row, k] * flexibility[k] * rows[column, k]
            for k in range(other, end):
                total += rows[row, k] * flexibility[k] * rows[column, k]
            W[row, column] = W[column, row] = total
    return W


@compiled
def begin_friction(
    system: PlaneModel, state: PlaneState, memory: PlaneMemory, work: PlaneWork
) -> None:
    """Friction of the near points, by what they did in the last step."""
    for i in range(work.counts[0]):
        k = work.points[i]
        mu, cohesion = held(system.friction, system.upper[k], memory.past[k])
        work.friction[i] = mu
        work.cohesion[i] = cohesion * area(system, work, state, i) if cohesion > 0.0 else 0.0


@compiled
def follow_friction(
    system: PlaneModel, memory: PlaneMemory, work: PlaneWork, W: Array, dt: float, share: float
) -> bool:
    """Adapt friction to the slip that was found, as far as `eased`; True where anything changed."""
    changed = False
    for i in range(work.counts[0]):
        if work.state[i] == OPEN:
            continue
        k, slip, t = work.points[i], abs(work.place[2 * i + 1]), 2 * i + 1
        force = max(abs(work.force[2 * i]), abs(work.force[t]))
        slid = work.state[i] != STICK and slips(slip, W[t, t], force)
        work.slips[i] = 1 if slid else 0
        speed = slip / dt if slid else 0.0
        friction, coheres = followed(
            system.friction, system.upper[k], memory.past[k], work.friction[i], speed, slid
        )
        friction = eased(system.friction, system.upper[k], work.friction[i], friction, share)
        if abs(friction - work.friction[i]) > 1e-13:
            work.friction[i] = friction
            changed = True
        if not coheres and work.cohesion[i] > 0.0:
            work.cohesion[i] = 0.0
            changed = True
    return changed


@compiled
def bounds_of(work: PlaneWork) -> Bounds:
    """Friction of the near points for the local problem."""
    count = work.counts[0]
    return Bounds(work.friction[:count], work.cohesion[:count], np.inf)
