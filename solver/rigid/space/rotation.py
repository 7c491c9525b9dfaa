"""Rotations in space for the compiled steps of rigid blocks: quaternions and the Cayley map.

A step turns a body by the Cayley vector psi (in space; Psi in the body), so that

    R_{n+1} - R_n = skew(psi) (R_n + R_{n+1})/2

holds exactly: a point r of the body moves by psi x (R_n + R_{n+1}) r/2, and a force on it has the
moment of its mean arm. With the angular velocity W in the body and Psi = dt (W_n + W_{n+1})/2 the
energy-momentum rule (Simo and Wong 1991) for the moment M about the centre reads

    2 J (Psi - dt W_n) + Psi x J Psi = dt^2 (I - skew(Psi)/2) R_n^T M.                         (1)

It is dt Q^T times the balance of angular momentum R_{n+1} J W_{n+1} - R_n J W_n = dt M with
Q = R_n (I + skew(Psi)/2) = R_{n+1} (I - skew(Psi)/2), and since Q Psi = psi its product with Psi
is that of energy: psi.M is the change of W.J W/2. Nothing of it is approximate.
"""

from __future__ import annotations

import math

import numpy as np

from solver.law.compiled import compiled
from solver.types import Array


@compiled
def cross(a: Array, b: Array) -> Array:
    """The vector product a x b."""
    c = np.empty(3)
    c[0] = a[1] * b[2] - a[2] * b[1]
    c[1] = a[2] * b[0] - a[0] * b[2]
    c[2] = a[0] * b[1] - a[1] * b[0]
    return c


@compiled
def to_space(rotation: Array, x: Array) -> Array:
    """R x: components in space of a vector given in the body."""
    y = np.empty(3)
    for i in range(3):
        y[i] = rotation[i, 0] * x[0] + rotation[i, 1] * x[1] + rotation[i, 2] * x[2]
    return y


@compiled
def to_body(rotation: Array, x: Array) -> Array:
    """R^T x: components in the body of a vector given in space."""
    y = np.empty(3)
    for i in range(3):
        y[i] = rotation[0, i] * x[0] + rotation[1, i] * x[1] + rotation[2, i] * x[2]
    return y


@compiled
def product(a: Array, b: Array) -> Array:
    """The product of two matrices (3, 3): faster than `@` at this size."""
    c = np.empty((3, 3))
    for i in range(3):
        for j in range(3):
            c[i, j] = a[i, 0] * b[0, j] + a[i, 1] * b[1, j] + a[i, 2] * b[2, j]
    return c


@compiled
def inverse(a: Array) -> Array:
    """The inverse of a regular matrix (3, 3), by cofactors."""
    rows = np.empty((3, 3))
    rows[:, 0] = cross(a[1], a[2])
    rows[:, 1] = cross(a[2], a[0])
    rows[:, 2] = cross(a[0], a[1])
    determinant = a[0, 0] * rows[0, 0] + a[0, 1] * rows[1, 0] + a[0, 2] * rows[2, 0]
    return rows / determinant


@compiled
def rotation_of(quaternion: Array) -> Array:
    """The rotation matrix of a unit quaternion (w, x, y, z)."""
    w, x, y, z = quaternion[0], quaternion[1], quaternion[2], quaternion[3]
    rotation = np.empty((3, 3))
    rotation[0, 0] = 1 - 2 * (y * y + z * z)
    rotation[1, 1] = 1 - 2 * (x * x + z * z)
    rotation[2, 2] = 1 - 2 * (x * x + y * y)
    rotation[0, 1], rotation[1, 0] = 2 * (x * y - w * z), 2 * (x * y + w * z)
    rotation[0, 2], rotation[2, 0] = 2 * (x * z + w * y), 2 * (x * z - w * y)
    rotation[1, 2], rotation[2, 1] = 2 * (y * z - w * x), 2 * (y * z + w * x)
    return rotation


def quaternion_of(rotation: Array) -> Array:
    """The unit quaternion of a rotation matrix, w >= 0 (Shepperd 1978)."""
    diagonal = np.diag(rotation)
    squares = np.array([1 + diagonal.sum(), *(1 + 2 * diagonal - diagonal.sum())]) / 4
    largest = int(np.argmax(squares))
    skew = np.array([rotation[2, 1], rotation[0, 2], rotation[1, 0]])
    skew -= [rotation[1, 2], rotation[2, 0], rotation[0, 1]]
    products = np.zeros((4, 4))
    products[0, 1:] = products[1:, 0] = skew / 4
    products[1:, 1:] = (rotation + rotation.T) / 4
    np.fill_diagonal(products, squares)
    found: Array = products[largest] / np.sqrt(squares[largest])
    return found * np.copysign(1.0, found[0])


@compiled
def advanced(quaternion: Array, psi: Array) -> Array:
    """The quaternion after the rotation of Cayley vector `psi` in space: (1, psi/2) q, of length 1.

    Normalised in each step, so that a rotation stays one however many steps follow.
    """
    half = 0.5 * psi
    new = np.empty(4)
    new[0] = quaternion[0]
    for i in range(3):
        new[0] -= half[i] * quaternion[i + 1]
    new[1:] = quaternion[1:] + half * quaternion[0] + cross(half, quaternion[1:])
    new /= math.sqrt(new[0] ** 2 + new[1] ** 2 + new[2] ** 2 + new[3] ** 2)
    return new


@compiled
def rotation_vector(quaternion: Array, previous: Array) -> Array:
    """The rotation vector, rad; of all that mean the same rotation the one nearest `previous`."""
    sine = math.sqrt(quaternion[1] ** 2 + quaternion[2] ** 2 + quaternion[3] ** 2)
    length = math.sqrt(previous[0] ** 2 + previous[1] ** 2 + previous[2] ** 2)
    if sine < 1e-12:
        # No axis of its own: whole turns keep the old one.
        turns = np.round(length / (2 * math.pi))
        if turns == 0.0:
            return 2.0 * math.copysign(1.0, quaternion[0]) * quaternion[1:]
        return previous * (turns * 2 * math.pi / length)
    axis = quaternion[1:] / sine
    angle = 2 * math.atan2(sine, quaternion[0])
    along = axis[0] * previous[0] + axis[1] * previous[1] + axis[2] * previous[2]
    return axis * (angle + 2 * math.pi * np.round((along - angle) / (2 * math.pi)))


@compiled
def free_rule(inertia: Array, psi: Array, velocity: Array, dt: float) -> Array:
    """The left-hand side of (1), kg m2, with principal moments J; psi and W_n in the body."""
    return 2 * inertia * (psi - dt * velocity) + cross(psi, inertia * psi)


@compiled
def free_tangent(inertia: Array, psi: Array) -> Array:
    """Derivative of `free_rule` with respect to Psi: 2 J + skew(Psi) J - skew(J Psi)."""
    a, b, c = inertia[0], inertia[1], inertia[2]
    tangent = np.empty((3, 3))
    tangent[0, 0], tangent[1, 1], tangent[2, 2] = 2 * a, 2 * b, 2 * c
    tangent[0, 1], tangent[0, 2] = (c - b) * psi[2], (c - b) * psi[1]
    tangent[1, 0], tangent[1, 2] = (a - c) * psi[2], (a - c) * psi[0]
    tangent[2, 0], tangent[2, 1] = (b - a) * psi[1], (b - a) * psi[0]
    return tangent


@compiled
def end_factor(psi: Array) -> Array:
    """I - skew(Psi)/2: what stands before the moment in (1)."""
    factor = np.empty((3, 3))
    factor[0, 0], factor[1, 1], factor[2, 2] = 1.0, 1.0, 1.0
    factor[0, 1], factor[1, 0] = 0.5 * psi[2], -0.5 * psi[2]
    factor[0, 2], factor[2, 0] = -0.5 * psi[1], 0.5 * psi[1]
    factor[1, 2], factor[2, 1] = 0.5 * psi[0], -0.5 * psi[0]
    return factor
