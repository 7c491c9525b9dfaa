"""Natural vibration of meshed bodies: the lowest mode of the undeformed body, undamped."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import LinearOperator, eigsh

from solver.bodies.elastic_body import ElasticBody
from solver.scheme.generalized_alpha import TangentWeights
from solver.types import Array

STATIC = TangentWeights(mass=0.0, stiffness=1.0, interface=0.0, contact=0.0, spring=1.0)
"""Weights that make the tangent the stiffness K of the body with its springs to the ground."""


def eigenvalues(body: ElasticBody, count: int = 1) -> Array:
    """Lowest eigenvalues omega^2 of K x = omega^2 M x with held supports, 1/s^2, rising.

    The body is on one rank, and held or on a spring, so that K is positive definite.
    """
    factor = body.factorization(STATIC)
    mass = body.mass_matrix.copy()
    if body.clamped:
        mass.zeroRowsColumns(body.fixed, 0.0)  # held unknowns take no part
    stiffness, inertia = (
        sp.csr_matrix(matrix.getValuesCSR()[::-1], shape=matrix.size)
        for matrix in (factor.matrix, mass)
    )
    inverse = LinearOperator(stiffness.shape, matvec=factor.solve, dtype=np.float64)
    found = eigsh(
        stiffness,
        count,
        inertia,
        sigma=0.0,
        OPinv=inverse,
        v0=inertia @ np.ones(len(body.nodes) * body.dimension),
        return_eigenvectors=False,
    )
    return np.sort(found)
