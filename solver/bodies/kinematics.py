"""Rotations in the plane and in space, and the rigid motion that fits a body best."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from solver.kernels import meshed


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
    meshed.polar_factor(moment, rotation)
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
    meshed.turn_by(vector, rotation)
    return rotation


def rotation_vector(rotation: NDArray[np.float64]) -> NDArray[np.float64]:
    """The rotation vector of a rotation in space, rad: along its axis, as long as its angle."""
    vector = np.empty(3)
    meshed.vector_of(rotation, vector)
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
