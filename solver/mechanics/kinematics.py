"""Rotations in the plane and in space, and the rigid motion that fits a body best."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def polar_rotation(moment: NDArray[np.float64]) -> NDArray[np.float64]:
    """The rotation nearest to a moment matrix (d, d): its polar factor.

    `moment` = sum of m x (X - X_mean)^T over a body, x current and X reference positions; the
    result is the mass-weighted best-fit rotation of the body (Kabsch 1976).
    """
    if moment.shape == (2, 2):
        c, s = float(moment[0, 0] + moment[1, 1]), float(moment[1, 0] - moment[0, 1])
        length = (c * c + s * s) ** 0.5
        c, s = c / length, s / length
        return np.array([[c, -s], [s, c]])
    left, _, right = np.linalg.svd(moment)
    left[:, -1] *= np.sign(np.linalg.det(left @ right))
    return left @ right


def lean(rotation: NDArray[np.float64]) -> float:
    """Angle of a plane rotation, rad, positive when the body leans towards +x (clockwise)."""
    return float(np.arctan2(-rotation[1, 0], rotation[0, 0]))


def unwrap(angle: float, previous: float) -> float:
    """The value of `angle` modulo 2 pi that is nearest to `previous`."""
    return float(angle + 2 * np.pi * np.round((previous - angle) / (2 * np.pi)))


def rotation_vector(rotation: NDArray[np.float64]) -> NDArray[np.float64]:
    """The rotation vector of a rotation in space, rad: along its axis, as long as its angle."""
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_matrix(rotation).as_rotvec())
