"""Rotations in the plane and in space as compiled functions of small arrays."""

from __future__ import annotations

import math

import numpy as np

from solver.law.compiled import compiled
from solver.types import Array


@compiled
def polar_factor(moment: Array, rotation: Array) -> None:
    """Fill in the rotation (d, d) nearest to a matrix: its polar factor (Kabsch 1976)."""
    if len(moment) == 2:
        c, s = moment[0, 0] + moment[1, 1], moment[1, 0] - moment[0, 1]
        length = math.sqrt(c * c + s * s)
        rotation[0, 0] = rotation[1, 1] = c / length
        rotation[1, 0], rotation[0, 1] = s / length, -s / length
        return
    left, _, right = np.linalg.svd(moment)
    if np.linalg.det(left) * np.linalg.det(right) < 0.0:
        left[:, -1] *= -1.0
    rotation[:] = 0.0
    for i in range(len(rotation)):
        for j in range(len(rotation)):
            for k in range(len(rotation)):
                rotation[i, j] += left[i, k] * right[k, j]


@compiled
def best_rotation(u: Array, moment_row: Array, moment: Array, rotation: Array) -> None:
    """Fill in the rotation that fits a displacement (n d,) best, from the moments of its mass.

    Args:
        u: Displacements of the nodes, (n d,), m.
        moment_row: M times the places of the nodes from the centre, (n, d), kg m.
        moment: Sum of these places times their moments, (d, d), kg m2.
        rotation: (d, d).
    """
    d, total = len(moment), moment.copy()
    for i in range(d):
        for j in range(d):
            moved = 0.0
            for n in range(len(moment_row)):
                moved += u[n * d + i] * moment_row[n, j]
            total[i, j] += moved
    polar_factor(total, rotation)


@compiled
def turn_by(vector: Array, rotation: Array) -> None:
    """Fill in the rotation by an angle (1,), clockwise, or by a vector in space (3,), rad."""
    if len(vector) == 1:
        c, s = math.cos(vector[0]), math.sin(vector[0])
        rotation[0, 0], rotation[0, 1], rotation[1, 0], rotation[1, 1] = c, s, -s, c
        return
    x, y, z = vector[0], vector[1], vector[2]
    angle = math.sqrt(x * x + y * y + z * z)
    half = 0.5 * angle
    share = math.sin(half) / angle if angle > 0.0 else 0.5
    w, x, y, z = math.cos(half), share * x, share * y, share * z
    rotation[0, 0], rotation[0, 1] = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w)
    rotation[0, 2], rotation[1, 0] = 2.0 * (x * z + y * w), 2.0 * (x * y + z * w)
    rotation[1, 1], rotation[1, 2] = 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)
    rotation[2, 0], rotation[2, 1] = 2.0 * (x * z - y * w), 2.0 * (y * z + x * w)
    rotation[2, 2] = 1.0 - 2.0 * (x * x + y * y)


@compiled
def vector_of(rotation: Array, vector: Array) -> None:
    """Fill in the rotation vector (3,) of a rotation in space, rad: as long as its angle."""
    # The largest component of the unit quaternion first: the others are divided by it.
    trace = rotation[0, 0] + rotation[1, 1] + rotation[2, 2]
    largest = trace
    first = -1
    for i in range(3):
        if rotation[i, i] > largest:
            largest, first = rotation[i, i], i
    if first < 0:
        w = 1.0 + trace
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            vector[i] = rotation[k, j] - rotation[j, k]
    else:
        j, k = (first + 1) % 3, (first + 2) % 3
        w = rotation[k, j] - rotation[j, k]
        vector[first] = 1.0 - trace + 2.0 * rotation[first, first]
        vector[j] = rotation[j, first] + rotation[first, j]
        vector[k] = rotation[k, first] + rotation[first, k]
    if w < 0.0:
        w = -w
        for i in range(3):
            vector[i] = -vector[i]
    size = math.sqrt(vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2)
    scale = 2.0 * math.atan2(size, w) / size if size > 0.0 else 0.0
    for i in range(3):
        vector[i] *= scale


@compiled
def turning_ahead(
    spin: Array, before: Array, last_rate: Array, last: float, dt: float, turning: Array
) -> None:
    """Fill in how a body turns in a coming step: rates, those of them to count on, and angles.

    What an impact did cannot be counted on: it is the smaller of two changes of the angular
    velocity, and none where they go different ways.

    Args:
        spin: Angular velocity at its start, (n,), rad/s.
        before: That at the start of the last step.
        last_rate: Change of the angular velocity in the last step, (n,), rad/s2.
        last: Length of the last step, s.
        dt: Length of the coming one, s.
        turning: The three, (3, n), rad/s2 and rad.
    """
    for i in range(len(spin)):
        rate = (spin[i] - before[i]) / last
        steady = rate if abs(rate) < abs(last_rate[i]) else last_rate[i]
        if not rate * last_rate[i] > 0.0:
            steady = 0.0
        turning[0, i], turning[1, i] = rate, steady
        turning[2, i] = dt * (spin[i] + 0.5 * dt * steady)
