"""Flutter of a body that slides steadily on rigid ground: two of its modes couple by friction.

Friction mu N on the base follows the pressure N there, which the vibration itself changes: K and M
of the motion along the base become unsymmetric. With the modes x of the body whose base cannot
leave the ground, but slides freely (x.M x = 1, x.K x = omega^2), and for sliding along a direction,

    A q'' + (lambda_R A + beta_R B) q' + B q = 0,
    A = I + mu T^T M_n,    B = diag(omega^2) + mu T^T K_n,                                      (1)

where T has the displacements of the base along the direction and M_n, K_n the rows of M x and K x
across it, so that K_n q + M_n q'' is the change of N. Each nu of B x = nu A x gives the rates s of

    s^2 + s (lambda_R + beta_R nu) + nu = 0,                                                    (2)

and a rate with a positive real part grows (Hoffmann, Fischer, Allgaier and Gaul 2002, Mechanics
Research Communications 29). The coefficient of friction is held constant.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy.linalg as la
from numpy.typing import NDArray

from solver.bodies.elastic_body import ElasticBody
from solver.bodies.modes import compressed_rows, lowest_modes
from solver.scene.damping import DampingSpec
from solver.types import Array

MODES = 40
"""Modes of a body in which its flutter is looked for; the two that couple are among the lowest."""

SHIFT = 0.1
"""Frequency of the shift that lets rigid sliding have an inverse, over that of the held body."""

FRICTION_STEP = 0.02
"""Distance of the coefficients of friction among which the onset of flutter is looked for."""

BISECTIONS = 20
"""Halvings of such a distance."""

GROWTH = 1e-6
"""Real part of a rate over its size that round-off does not make."""


@dataclass(frozen=True, slots=True)
class Flutter:
    """The rate of (2) that grows most.

    Attributes:
        growth: Its real part, 1/s; negative where everything decays.
        frequency: Its imaginary part, rad/s.
        damping: Least beta_R that holds all modes, s, without mass-proportional damping.
    """

    growth: float
    frequency: float
    damping: float


@dataclass(frozen=True, slots=True)
class SlidingModes:
    """Matrices of (1).

    Attributes:
        squared: omega^2, (n,), 1/s^2.
        inertia: T^T M_n for sliding along each direction, (directions, n, n).
        stiffness: T^T K_n, likewise.
    """

    squared: Array
    inertia: Array
    stiffness: Array

    def flutter(self, friction: float, damping: DampingSpec) -> Flutter:
        """The fastest growing motion in steady sliding along any direction of the base."""
        directions = range(len(self.inertia))
        nu = np.concatenate([self._pencil(friction, direction) for direction in directions])
        half = (damping.mass + damping.stiffness * nu) / 2
        rates = -half + np.array([[1.0], [-1.0]]) * np.sqrt(half**2 - nu)
        rates = rates[np.abs(rates.imag) > GROWTH * np.abs(rates)]  # others decay
        if not len(rates):
            return Flutter(-math.inf, 0.0, 0.0)
        most = rates[rates.real.argmax()]
        # (2) with s = i omega: beta_R = |Im nu|/(|nu| sqrt(Re nu)).
        vibrates = nu.real > 0
        held = np.abs(nu.imag[vibrates]) / (np.abs(nu[vibrates]) * np.sqrt(nu.real[vibrates]))
        return Flutter(float(most.real), float(abs(most.imag)), float(held.max(initial=0.0)))

    def onset(self, most: float, damping: DampingSpec) -> float | None:
        """Least coefficient of friction up to `most` above which something grows, or None."""
        low = 0.0
        for high in np.arange(1, math.ceil(most / FRICTION_STEP) + 1) * FRICTION_STEP:
            if self._grows(high, damping):
                break
            low = high
        else:
            return None
        for _ in range(BISECTIONS):
            middle = (low + high) / 2
            low, high = (low, middle) if self._grows(middle, damping) else (middle, high)
        return float(high)

    def _grows(self, friction: float, damping: DampingSpec) -> bool:
        found = self.flutter(friction, damping)
        return found.growth > GROWTH * found.frequency

    def _pencil(self, friction: float, direction: int) -> NDArray[np.complex128]:
        """The values nu of B x = nu A x, without those of rigid sliding."""
        stiffness = np.diag(self.squared) + friction * self.stiffness[direction]
        inertia = np.eye(len(self.squared)) + friction * self.inertia[direction]
        found: NDArray[np.complex128] = la.eigvals(stiffness, inertia)
        return found[np.abs(found) > GROWTH * np.abs(found).max()]


def sliding_modes(body: ElasticBody, base: NDArray[np.int32], frequency: float) -> SlidingModes:
    """Modes of a body on one rank whose base is held across, and what friction does to them.

    Args:
        body: The body; its support holds the last direction of the base.
        base: Numbers of the nodes of the base.
        frequency: Of the body with a base that is held in all directions, rad/s: a scale.
    """
    squared, shapes = lowest_modes(body, MODES, shift=(SHIFT * frequency) ** 2)
    across = base * body.dimension + body.dimension - 1
    inertia, stiffness = (
        compressed_rows(matrix)[across] @ shapes
        for matrix in (body.mass_matrix, body.stiffness_matrix)
    )
    along = [shapes[base * body.dimension + k] for k in range(body.dimension - 1)]
    return SlidingModes(
        np.maximum(squared, 0.0),
        np.array([part.T @ inertia for part in along]),
        np.array([part.T @ stiffness for part in along]),
    )
