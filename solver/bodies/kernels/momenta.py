"""Momenta of a meshed body, and its motion as a whole; compiled."""

from __future__ import annotations

import numpy as np

from solver.law.compiled import compiled
from solver.types import Array


@compiled
def momenta(
    arm: Array, u: Array, v: Array, momentum: Array, directional_mass: Array, sums: Array
) -> None:
    """Fill in sums over the nodes of a body: of m u and m v, (d,) each, and of (arm + u) x M v.

    The moments are about the axes of space; in the plane there is one, which turns clockwise.

    Args:
        arm: Places of the nodes from the centre of the undeformed body, (n, d), m.
        u: Displacements, (n d,), m.
        v: Velocities, (n d,), m/s.
        momentum: M v, (n d,), kg m/s.
        directional_mass: Mass of each unknown in motion along each direction, (d, n d), kg.
        sums: The sums, (2 d + 1,) or in space (2 d + 3,).
    """
    d = arm.shape[1]
    for i in range(d):
        sums[i] = np.sum(directional_mass[i] * u)
        sums[d + i] = np.sum(directional_mass[i] * v)
    for axis in range(len(sums) - 2 * d):
        i, j = (1, 0) if d == 2 else ((axis + 1) % 3, (axis + 2) % 3)
        along, across = arm[:, i] + u[i::d], arm[:, j] + u[j::d]
        sums[2 * d + axis] = np.sum(along * momentum[j::d] - across * momentum[i::d])


@compiled
def move_on(arm: Array, u: Array, moved: Array, turn: Array, way: Array, after: Array) -> None:
    """Fill in displacements of a body that turns and moves on as a whole, its strains unchanged.

    Args:
        arm: Places of the nodes from the centre of the undeformed body, (n, d), m.
        u: Displacements before, (n d,), m.
        moved: That of the centre, (d,), m.
        turn: Rotation by which the body turns, (d, d).
        way: How far its centre moves, (d,), m.
        after: Displacements after, (n d,), m.
    """
    d = arm.shape[1]
    after[:] = u
    for i in range(d):
        after[i::d] += way[i]
        for j in range(d):
            turned = turn[i, j] - (1.0 if i == j else 0.0)
            after[i::d] += turned * (arm[:, j] + u[j::d] - moved[j])


@compiled
def turn_all(vectors: Array, rotation: Array, turned: Array) -> None:
    """Fill in R x for vectors x, one after another in (n d,)."""
    d = len(rotation)
    turned[:] = 0.0
    for i in range(d):
        for j in range(d):
            turned[i::d] += rotation[i, j] * vectors[j::d]
