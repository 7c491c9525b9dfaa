"""Rotations of rigid blocks in space: exact increments, and quaternions there and back."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from solver.rigid.space.rotation import (
    advanced,
    cross,
    end_factor,
    free_rule,
    free_tangent,
    inverse,
    product,
    quaternion_of,
    rotation_of,
    rotation_vector,
)

RANDOM = np.random.default_rng(3)
QUATERNION = RANDOM.normal(size=4)
QUATERNION /= np.linalg.norm(QUATERNION)
PSI = np.array([0.3, -0.5, 0.9])


def test_the_cayley_map_moves_points_along_their_mean_arm() -> None:
    """R_1 - R_0 = skew(psi) (R_0 + R_1)/2, which makes work and energy agree."""
    before, after = rotation_of(QUATERNION), rotation_of(advanced(QUATERNION, PSI))
    point = np.array([0.2, 0.7, -0.4])
    moved = cross(PSI, 0.5 * (before + after) @ point)
    np.testing.assert_allclose((after - before) @ point, moved, atol=1e-15)


def test_the_cayley_vector_is_twice_the_tangent_of_half_the_angle() -> None:
    angle = 0.7
    axis = PSI / np.linalg.norm(PSI)
    turn = rotation_of(advanced(np.array([1.0, 0, 0, 0]), 2 * np.tan(angle / 2) * axis))
    np.testing.assert_allclose(turn, Rotation.from_rotvec(angle * axis).as_matrix(), atol=1e-15)


@pytest.mark.parametrize("vector", [(0.1, 0.2, 0.3), (3.1, 0, 0), (0, -3.1, 0), (0, 0.1, 3.1)])
def test_quaternions_of_matrices(vector: tuple[float, float, float]) -> None:
    matrix = Rotation.from_rotvec(vector).as_matrix()
    np.testing.assert_allclose(rotation_of(quaternion_of(matrix)), matrix, atol=1e-15)
    np.testing.assert_allclose(rotation_vector(quaternion_of(matrix), np.zeros(3)), vector)


def test_rotation_vectors_go_on_beyond_a_turn() -> None:
    axis, vector, quaternion = np.array([0.6, 0.0, 0.8]), np.zeros(3), np.array([1.0, 0, 0, 0])
    for _ in range(100):
        quaternion = advanced(quaternion, 2 * np.tan(0.05) * axis)
        vector = rotation_vector(quaternion, vector)
    np.testing.assert_allclose(vector, 10 * axis, atol=1e-12)


def test_tangent_of_the_free_rule() -> None:
    inertia, velocity, h = np.array([1.0, 2.5, 3.0]), np.array([1.0, -2.0, 0.5]), 1e-6
    slopes = [
        (
            free_rule(inertia, PSI + h * e, velocity, 0.1)
            - free_rule(inertia, PSI - h * e, velocity, 0.1)
        )
        / (2 * h)
        for e in np.eye(3)
    ]
    np.testing.assert_allclose(free_tangent(inertia, PSI), np.transpose(slopes), atol=1e-8)


def test_the_rule_is_the_balance_of_angular_momentum() -> None:
    """For W_1 = 2 Psi/dt - W_0 the rule over dt is Q^T (L_1 - L_0), Q = R_0 (I + skew(Psi)/2)."""
    inertia, velocity, dt = np.array([1.0, 2.5, 3.0]), np.array([1.0, -2.0, 0.5]), 0.1
    before = rotation_of(QUATERNION)
    after = rotation_of(advanced(QUATERNION, before @ PSI))
    gained = after @ (inertia * (2 * PSI / dt - velocity)) - before @ (inertia * velocity)
    rule = free_rule(inertia, PSI, velocity, dt) / dt
    np.testing.assert_allclose(end_factor(PSI) @ before.T @ gained, rule, atol=1e-12)


def test_small_matrices() -> None:
    a, b = RANDOM.normal(size=(2, 3, 3))
    np.testing.assert_allclose(product(a, b), a @ b, atol=1e-14)
    np.testing.assert_allclose(inverse(a) @ a, np.eye(3), atol=1e-12)
