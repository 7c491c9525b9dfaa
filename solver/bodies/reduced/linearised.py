"""A meshed body linearised about its equilibrium under weight, P-delta included."""

from __future__ import annotations

from typing import NamedTuple

from petsc4py import PETSc

import numpy as np
import scipy.sparse as sp

from solver.bodies.elastic_body import ElasticBody
from solver.bodies.modes import STATIC
from solver.errors import NotConverged
from solver.types import Array

MOST_CORRECTIONS = 30
"""Newton corrections after which the search for the equilibrium is given up."""

SETTLED = 1e-8
"""A correction below this part of the displacement is the last one."""


class Linearised(NamedTuple):
    """Forces of strain F(u_s) + K (u - u_s) about an equilibrium u_s, and all other matrices."""

    u: Array
    """u_s, m."""
    force: Array
    """F(u_s) without that of springs, N."""
    energy: float
    """Strain energy at u_s, J."""
    stiffness: sp.csr_matrix
    """K, tangent at u_s: of the material and of the stresses there, N/m."""
    undeformed: sp.csr_matrix
    """K_0, of the undeformed body, which damping goes with, N/m."""
    mass: sp.csr_matrix
    """M, kg."""
    spring: sp.csr_matrix
    """Springs to the ground, N/m; empty where there are none."""


def linearised(body: ElasticBody, load: Array) -> Linearised:
    """A held body on one rank, about its equilibrium under a load (N), by Newton's method.

    The tangent of the body is afterwards that of the equilibrium.

    Raises:
        NotConverged: There is none: it buckles.
    """
    undeformed, mass = sparse(body.stiffness_matrix), sparse(body.mass_matrix)
    u = np.zeros(body.size)
    for _ in range(MOST_CORRECTIONS):
        body.begin_static(u)
        force = body.internal_force(u, static=True)
        left, spring = load - force, body.spring(u)
        if spring is not None:
            left -= spring
        left[body.fixed] = 0.0
        body.resume_stiffness(u)
        change = body.factorization(STATIC).solve(left)
        if np.linalg.norm(change) <= SETTLED * np.linalg.norm(u):
            break
        u = u + change
    else:
        raise NotConverged(f"{body.name}: no equilibrium under its weight, to linearise about")
    held = sp.csr_matrix(mass.shape)
    if body.spring_matrix is not None:
        held = sparse(body.spring_matrix)
    tangent = sparse(body.stiffness_matrix)
    return Linearised(u, force, body.strain_energy(u), tangent, undeformed, mass, held)


def sparse(matrix: PETSc.Mat) -> sp.csr_matrix:
    """A matrix of one rank as scipy has it."""
    return sp.csr_matrix(matrix.getValuesCSR()[::-1], shape=matrix.size)
