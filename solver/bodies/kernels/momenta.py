"""Momenta of a meshed body, and its motion as a whole; compiled."""

from __future__ import annotations

import numpy as np

from solver.bodies.kernels.rotation import turn_by
from solver.law.compiled import compiled
from solver.types import Array


@compiled
def momenta(
    arm: Array, u: Array, v: Array, momentum: Array, directional_mass: Array, sums: Array
) -> None:
    """Fill in sums over the nodes of a body: m u and m v, (d,) each, (arm + u) x M v, and v.M v.

    The moments are about the axes of space; in the plane there is one, which turns clockwise.

    Args:
        arm: Places of the nodes from the centre of the undeformed body, (n, d), m.
        u: Displacements, (n d,), m.
        v: Velocities, (n d,), m/s.
        momentum: M v, (n d,), kg m/s.
        directional_mass: Mass of each unknown in motion along each direction, (d, n d), kg.
        sums: The sums, (2 d + 2,) or in space (2 d + 4,).
    """
    d = arm.shape[1]
    sums[:] = 0.0
    for i in range(d):
        for n in range(len(u)):
            sums[i] += directional_mass[i, n] * u[n]
            sums[d + i] += directional_mass[i, n] * v[n]
    for n in range(len(v)):
        sums[-1] += v[n] * momentum[n]
    for axis in range(len(sums) - 2 * d - 1):
        i, j = (1, 0) if d == 2 else ((axis + 1) % 3, (axis + 2) % 3)
        for n in range(len(arm)):
            along, across = arm[n, i] + u[n * d + i], arm[n, j] + u[n * d + j]
            sums[2 * d + axis] += along * momentum[n * d + j] - across * momentum[n * d + i]


@compiled
def resultant(forces: Array, total: Array) -> None:
    """Fill in the sum (d,) of forces on nodes, one after another in (n d,), N."""
    d = len(total)
    total[:] = 0.0
    for n in range(0, len(forces), d):
        for i in range(d):
            total[i] += forces[n + i]


@compiled
def velocities(
    sums: Array, mass: float, rotation: Array, inertia: Array, motion: Array, spin: Array
) -> None:
    """Fill in how a body moves as a whole, by sums over its nodes as `momenta` gives them.

    Args:
        sums: Over the nodes of all ranks.
        mass: Of the body, kg.
        rotation: That fits its displacement best, (d, d).
        inertia: Inertia tensor of the unrotated body about its centre, (3, 3), in the plane its
            polar inertia, (1, 1), kg m2.
        motion: Displacement (m) and velocity (m/s) of the centre, (2, d).
        spin: Angular velocity, (1,) or (3,), rad/s.
    """
    d, axes = len(rotation), len(spin)
    for k in range(d):
        motion[0, k], motion[1, k] = sums[k] / mass, sums[d + k] / mass
    own = np.empty(axes)
    for axis in range(axes):
        i, j = (1, 0) if d == 2 else ((axis + 1) % 3, (axis + 2) % 3)
        centre = motion[0, i] * motion[1, j] - motion[0, j] * motion[1, i]
        own[axis] = sums[2 * d + axis] - mass * centre
    if d == 2:
        spin[0] = own[0] / inertia[0, 0]
        return
    turned, spin[:] = np.zeros(3), 0.0
    for i in range(3):
        for j in range(3):
            turned[i] += rotation[j, i] * own[j]
    own_frame = np.linalg.solve(inertia, turned)
    for i in range(3):
        for j in range(3):
            spin[i] += rotation[i, j] * own_frame[j]


@compiled
def move_on(arm: Array, u: Array, moved: Array, vector: Array, way: Array, after: Array) -> None:
    """Fill in displacements of a body that turns and moves on as a whole, its strains unchanged.

    Args:
        arm: Places of the nodes from the centre of the undeformed body, (n, d), m.
        u: Displacements before, (n d,), m.
        moved: That of the centre, (d,), m.
        vector: Angle (1,) or rotation vector (3,) by which the body turns, rad.
        way: How far its centre moves, (d,), m.
        after: Displacements after, (n d,), m.
    """
    d = arm.shape[1]
    turn = np.empty((d, d))
    turn_by(vector, turn)
    for i in range(d):
        turn[i, i] -= 1.0
    for n in range(len(arm)):
        for i in range(d):
            after[n * d + i] = u[n * d + i] + way[i]
            for j in range(d):
                after[n * d + i] += turn[i, j] * (arm[n, j] + u[n * d + j] - moved[j])


@compiled
def turn_all(vectors: Array, vector: Array, turned: Array) -> None:
    """Fill in vectors x, one after another in (n d,), turned by an angle (1,) or a vector (3,)."""
    d = 2 if len(vector) == 1 else 3
    rotation = np.empty((d, d))
    turn_by(vector, rotation)
    for n in range(0, len(vectors), d):
        for i in range(d):
            turned[n + i] = 0.0
            for j in range(d):
                turned[n + i] += rotation[i, j] * vectors[n + j]
