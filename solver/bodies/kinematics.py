"""Rotations in the plane and in space, and the rigid motion that fits a body best.

Compiled functions fill in small arrays.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

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


class RigidMotion(NamedTuple):
    """Motion of a body as a whole."""

    moved: NDArray[np.float64]
    """Displacement of its centre of mass, (d,), m."""
    velocity: NDArray[np.float64]
    """Velocity of the centre of mass, (d,), m/s."""
    spin: NDArray[np.float64]
    """Angular velocity, rad/s: (1,), clockwise; in space (3,), by the right-hand rule; empty where
    it cannot turn."""
    rotation: NDArray[np.float64]
    """Rotation that fits its displacement best, (d, d)."""


def polar_rotation(moment: NDArray[np.float64]) -> NDArray[np.float64]:
    """The rotation nearest to a moment matrix (d, d): its polar factor.

    `moment` = sum of m x (X - X_mean)^T over a body, x current and X reference positions; the
    result is the mass-weighted best-fit rotation of the body (Kabsch 1976).
    """
    rotation = np.empty_like(moment)
    polar_factor(moment, rotation)
    return rotation


def lean(rotation: NDArray[np.float64]) -> float:
    """Angle of a plane rotation, rad, positive when the body leans towards +x (clockwise)."""
    return math.atan2(-rotation[1, 0], rotation[0, 0])


def unwrap(angle: float, previous: float) -> float:
    """The value of `angle` modulo 2 pi that is nearest to `previous`."""
    return angle + 2 * math.pi * round((previous - angle) / (2 * math.pi))


def turn(vector: NDArray[np.float64]) -> NDArray[np.float64]:
    """The rotation by an angle (1,), clockwise, or by a rotation vector in space (3,), rad."""
    d = 2 if len(vector) == 1 else 3
    rotation = np.empty((d, d))
    turn_by(vector, rotation)
    return rotation


def rotation_vector(rotation: NDArray[np.float64]) -> NDArray[np.float64]:
    """The rotation vector of a rotation in space, rad: along its axis, as long as its angle."""
    vector = np.empty(3)
    vector_of(rotation, vector)
    return vector


def rigid_modes(arm: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Small rigid motions of nodes (n, d), as vectors (n d,): translations, then turns."""
    modes: list[NDArray[np.float64]] = []
    d = arm.shape[1]
    for k in range(d):
        mode = np.zeros_like(arm)
        mode[:, k] = 1.0
        modes.append(mode.ravel())
    for i, j in ((0, 1), (1, 2), (2, 0))[: 1 if d == 2 else 3]:
        mode = np.zeros_like(arm)
        mode[:, i], mode[:, j] = -arm[:, j], arm[:, i]
        modes.append(mode.ravel())
    return modes
