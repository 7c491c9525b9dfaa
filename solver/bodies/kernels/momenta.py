"""Momenta of a meshed body, and its motion as a whole; compiled."""

from __future__ import annotations

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
    n, d = arm.shape
    sums[:] = 0.0
    for i in range(d):
        for k in range(n * d):
            sums[i] += directional_mass[i, k] * u[k]
            sums[d + i] += directional_mass[i, k] * v[k]
    for axis in range(len(sums) - 2 * d):
        i, j = (1, 0) if d == 2 else ((axis + 1) % 3, (axis + 2) % 3)
        for a in range(n):
            along, across = arm[a, i] + u[d * a + i], arm[a, j] + u[d * a + j]
            sums[2 * d + axis] += along * momentum[d * a + j] - across * momentum[d * a + i]


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
    n, d = arm.shape
    after[:] = u
    for a in range(n):
        for i in range(d):
            after[d * a + i] += way[i]
            for j in range(d):
                turned = turn[i, j] - (1.0 if i == j else 0.0)
                after[d * a + i] += turned * (arm[a, j] + u[d * a + j] - moved[j])
