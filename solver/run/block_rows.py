"""The part of a row that tells of one block among meshed bodies, in one pass; compiled."""

from __future__ import annotations

import math

import numpy as np

from solver.bodies.kinematics import vector_of
from solver.history.block_columns import (
    PLANE,
    SPACE,
    MovingBlock,
    lean_in_space,
    write_plane_motion,
    write_space_motion,
)
from solver.law.compiled import compiled
from solver.types import Array, Mask


@compiled
def touch(force: Array, place: Array, may_touch: Mask, level: float, touching: Mask) -> int:
    """Fill in the closed points, or else the lowest and all that are within `level` of it (m).

    Where no point may touch, these are all. Returns their number. Points are given by their forces
    and places, (points, d).
    """
    count, lowest = 0, math.inf
    for p in range(len(force)):
        touching[p] = force[p, 0] > 0.0
        count += touching[p]
        if may_touch[p]:
            lowest = min(lowest, place[p, 0])
    if count:
        return count
    for p in range(len(force)):
        height = place[p, 0] if may_touch[p] else math.inf
        touching[p] = height <= lowest + level
        count += touching[p]
    return count


@compiled
def write_motion(row: Array, block: MovingBlock, rotation: Array) -> None:
    """Carry on the angles of a block, and fill in what follows from its motion.

    Its angular velocity about its own axes is found here, from its rotation (d, d).
    """
    angles, own_spin = block.angles, block.spin.copy()
    if len(rotation) == 2:
        lean = math.atan2(-rotation[1, 0], rotation[0, 0])
        angles[0] = lean + 2 * math.pi * np.round((angles[0] - lean) / (2 * math.pi))
        write_plane_motion(block, row)
        return
    angles[0] = lean_in_space(rotation, angles[0])
    vector_of(rotation, angles[1:])
    for i in range(3):
        own_spin[i] = 0.0
        for j in range(3):
            own_spin[i] += rotation[j, i] * block.spin[j]
    centre, velocity = block.centre, block.velocity
    write_space_motion(
        MovingBlock(block.mass, block.inertia, centre, velocity, angles, block.spin, own_spin), row
    )


@compiled
def write_block(
    row: Array,
    force: Array,
    place: Array,
    may_touch: Mask,
    inside: Mask,
    home: Array,
    level: float,
    moved: Array,
    velocity: Array,
    spin: Array,
    rotation: Array,
    mass: float,
    centre: Array,
    inertia: Array,
    angles: Array,
    slip: Array,
    touching: Mask,
) -> bool:
    """Fill in slip, forces, penetration and motion of a block; False where a home is not known.

    Then only the points that touch are filled in.

    Args:
        row: The part of the block; its gaps are left out.
        force: Forces of its own points in the frame of the carrier, (points, d), N.
        place: Their gaps and tangential positions, (points, d), m.
        may_touch: Points that may touch.
        inside: Those of them that are not beyond an edge of the carrier.
        home: Where points belong along the carrier, (points, d - 1), m; nan where not known yet.
        level: Points count as equally low within this, m.
        moved: Displacement of the centre, (d,), m.
        velocity: Its velocity, (d,), m/s.
        spin: Angular velocity, (1,) or (3,), rad/s.
        rotation: Of the block, (d, d).
        mass: kg.
        centre: Of the unmoved block, (d,), m.
        inertia: As in `MovingBlock`.
        angles: Those of `MovingBlock`, carried on from step to step.
        slip: Mean slip of the touching points, (d - 1,), m.
        touching: These points, as `touch` finds them.
    """
    m, d = force.shape
    count = touch(force, place, may_touch, level, touching)
    total, total_slip, lowest = np.zeros(d), np.zeros(d - 1), 0.0
    for p in range(m):
        if inside[p]:
            lowest = min(lowest, place[p, 0])
        for k in range(d):
            total[k] += force[p, k]
        if touching[p]:
            for k in range(1, d):
                total_slip[k - 1] += place[p, k] - home[p, k - 1]
    if math.isnan(total_slip[0]):
        return False
    for k in range(d - 1):
        slip[k] = total_slip[k] / count
    moving = MovingBlock(mass, inertia, centre + moved, velocity, angles, spin, spin)
    write_motion(row, moving, rotation)
    if d == 2:
        row[PLANE.slip_m], row[PLANE.penetration_m] = slip[0], 0.0 - lowest
        row[PLANE.normal_force_N], row[PLANE.friction_force_N] = total[0], total[1]
        return True
    row[SPACE.slip_m], row[SPACE.slip_second_m] = slip[0], slip[1]
    row[SPACE.penetration_m] = 0.0 - lowest
    row[SPACE.normal_force_N], row[SPACE.friction_force_N] = total[0], total[1]
    row[SPACE.friction_force_second_N] = total[2]
    return True
