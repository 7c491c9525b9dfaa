"""A block that sways and slides: an independent answer for elastic blocks on a shaken floor.

The block is its base and some oscillators on it, the modes of the block held at its base with
their effective masses m_i and frequencies w_i (Clough and Penzien); friction acts on the base.

    m_b (x'' + a) = F + sum m_i w_i^2 q_i,     q_i'' + w_i^2 q_i = -(x'' + a)

with |F| = mu m g against x' while it slides, and x' = 0 while |F| is less. Between events the
equations are linear: each step is exact for a ground acceleration that is constant within it.
"""

from __future__ import annotations

from collections.abc import Callable

from mpi4py import MPI

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp
from numpy.typing import NDArray

from geometry.block import Block
from geometry.mesh import block_mesh
from solver.bodies.elastic_body import ElasticBody
from solver.scene.material import Material

Array = NDArray[np.float64]

SLIGHT = 1e-3
"""Part of the mass below which a mode is left out."""


def sway_modes(shape: Block, material: Material, cells: tuple[int, int]) -> tuple[Array, Array]:
    """Frequencies (rad/s) and effective horizontal masses (kg) of a block held at its base."""
    domain = block_mesh(
        shape, cells=cells, cell="quadrilateral", refinement=1.0, comm=MPI.COMM_SELF
    )
    body = ElasticBody(domain.mesh, material, thickness=shape.thickness)
    K, M = (
        sp.csr_matrix(matrix.getValuesCSR()[::-1], shape=matrix.size).toarray()
        for matrix in (body.stiffness_matrix, body.mass_matrix)
    )
    height = body.nodes[:, 1]
    free = np.repeat(~np.isclose(height, height.min()), 2)
    squared, modes = la.eigh(K[np.ix_(free, free)], M[np.ix_(free, free)], subset_by_index=(0, 7))
    moved = np.tile([1.0, 0.0], len(height))
    mass = (modes.T @ M[free] @ moved) ** 2
    kept = mass > SLIGHT * body.mass
    return np.sqrt(squared[kept]), mass[kept]


class SwayingBlock:
    """Mass, modes and friction of a block."""

    def __init__(self, mass: float, modes: tuple[Array, Array], held: float, step: float):
        """Take the whole mass, its modes, the friction mu m g, and the length of a step."""
        self.held, self.step = held, step
        self.frequency, self.masses = modes
        self.base = mass - self.masses.sum()
        self._steps = {slides: self._propagator(slides, step) for slides in (False, True)}

    def _propagator(self, slides: bool, step: float) -> tuple[Array, Array]:
        """Of (x, x', q, q') and of (a, F) over a step."""
        k = len(self.masses)
        A, B = np.zeros((2 + 2 * k, 2 + 2 * k)), np.zeros((2 + 2 * k, 2))
        A[2 : 2 + k, 2 + k :] = np.eye(k)
        A[2 + k :, 2 : 2 + k] = -np.diag(self.frequency**2)
        B[2 + k :, 0] = -1.0
        if slides:
            A[0, 1] = 1.0
            A[1, 2 : 2 + k] = self.masses * self.frequency**2 / self.base
            B[1] = -1.0, 1 / self.base
            A[2 + k :] -= A[1]
            B[2 + k :] = 0.0, -1 / self.base
        both = la.expm(step * np.block([[A, B], [np.zeros((2, 2 * k + 4))]]))
        return both[:-2, :-2], both[:-2, -2:]

    def slip(self, ground: Callable[[float], float], end: float) -> tuple[Array, Array]:
        """Times and slips, from rest at time 0."""
        k, way = len(self.masses), 0.0
        state, times = np.zeros(2 + 2 * k), np.arange(0.0, end + self.step / 2, self.step)
        slips = np.zeros(len(times))
        for number, time in enumerate(times[:-1]):
            if not way:
                swaying = (self.masses * self.frequency**2) @ state[2 : 2 + k]
                needed = self.base * ground(time) - swaying
                if abs(needed) > self.held:
                    way = -float(np.sign(needed))
            given = np.array([ground(time + self.step / 2), -way * self.held])
            after, forced = self._steps[bool(way)]
            new = after @ state + forced @ given
            if way * new[1] < 0:  # it stops within the step
                part = self.step * state[1] / (state[1] - new[1])
                after, forced = self._propagator(True, part)
                stopped = after @ state + forced @ given
                after, forced = self._propagator(False, self.step - part)
                stopped[1] = way = 0.0
                new = after @ stopped + forced @ [given[0], 0.0]
            state, slips[number + 1] = new, new[0]
        return times, slips


def decrement(drift: Array, after: int) -> float:
    """Mean logarithmic decrement of a decaying vibration, from its turning points after a row."""
    free = drift[after:]
    inner = np.abs(free[1:-1])
    at = 1 + np.flatnonzero((inner > np.abs(free[:-2])) & (inner >= np.abs(free[2:])))
    peaks = np.log(np.abs(free[at]))
    return float(-2 * np.polyfit(np.arange(len(peaks)), peaks, 1)[0])
