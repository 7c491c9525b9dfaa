"""Natural vibration of meshed bodies: the lowest modes of the undeformed body, undamped."""

from __future__ import annotations

import math
from collections.abc import Callable

from petsc4py import PETSc

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp
from scipy.sparse.linalg import LinearOperator, eigsh

from solver.bodies.elastic_body import ElasticBody
from solver.scheme.generalized_alpha import TangentWeights
from solver.types import Array

STATIC = TangentWeights(mass=0.0, stiffness=1.0, interface=0.0, contact=0.0, spring=1.0)
"""Weights that make the tangent the stiffness K of the body with its springs to the ground."""

SWAYING_PART = 0.1
"""Part of the mass of a body that moves horizontally in a mode of sway, at least."""

FEWEST = 100
"""Unknowns that move, up to which all modes are computed at once: with few of them, iterations
leave the space that they span."""

DENSE_PART = 0.4
"""Part of all modes beyond which they are computed all at once, by dense algebra."""

LOOKED_AT = 8
"""Number of the lowest modes among which that of sway is looked for."""


def eigenvalues(body: ElasticBody, count: int = 1) -> Array:
    """Lowest eigenvalues omega^2 of K x = omega^2 M x with held supports, 1/s^2, rising.

    The body is on one rank, and held or on a spring, so that K is positive definite.
    """
    return lowest_modes(body, count)[0]


def sway_frequency(body: ElasticBody) -> float:
    """Natural frequency of the first sway mode of a body as `eigenvalues` takes it, rad/s.

    That is the lowest mode in which a tenth of the mass moves along a horizontal direction (the
    effective mass of Clough and Penzien), or that with the most if there is none.
    """
    squared, shapes = lowest_modes(body, LOOKED_AT)
    part = (body.directional_mass[:-1] @ shapes) ** 2 / body.mass
    most = part.max(axis=0)
    sways = np.flatnonzero(most >= SWAYING_PART)
    first = int(sways[0]) if len(sways) else int(most.argmax())
    return math.sqrt(float(squared[first]))


def compressed_rows(matrix: PETSc.Mat) -> sp.csr_matrix:
    """A matrix that one rank has, for scipy."""
    return sp.csr_matrix(matrix.getValuesCSR()[::-1], shape=matrix.size)


def lowest_modes(body: ElasticBody, count: int, shift: float = 0.0) -> tuple[Array, Array]:
    """Lowest eigenvalues, 1/s^2, rising, and their vectors x with x.M x = 1, as columns.

    The body is on one rank. K is positive definite with its supports, or K + `shift` M is (1/s^2).
    """
    factor = body.factorization(STATIC._replace(mass=shift))
    mass = body.mass_matrix.copy()
    if body.clamped:
        mass.zeroRowsColumns(body.fixed, 0.0)  # held unknowns take no part
    stiffness, inertia = compressed_rows(factor.matrix), compressed_rows(mass)
    free = np.setdiff1d(np.arange(body.size), body.fixed)
    if len(free) > FEWEST:
        squared, shapes = lowest_pairs(stiffness, inertia, count, factor.solve)
        return squared - shift, shapes
    shapes = np.zeros((body.size, min(count, len(free))))
    stiffness, inertia = stiffness[free][:, free], inertia[free][:, free]
    squared, shapes[free] = lowest_pairs(stiffness, inertia, count, factor.solve)
    return squared - shift, shapes


def lowest_pairs(
    stiffness: sp.csr_matrix, mass: sp.csr_matrix, count: int, solve: Callable[[Array], Array]
) -> tuple[Array, Array]:
    """Lowest values w of K x = w M x, rising, and their vectors with x.M x = 1, as columns.

    `solve` gives K^-1 f. Where the values are few, or many of them are wanted, all are computed.
    """
    size = stiffness.shape[0]
    if size <= FEWEST or count >= DENSE_PART * size:
        squared, shapes = la.eigh(stiffness.toarray(), mass.toarray())
        return squared[:count], shapes[:, :count]
    inverse = LinearOperator(stiffness.shape, matvec=solve, dtype=np.float64)
    start = mass @ np.ones(size)
    squared, shapes = eigsh(stiffness, count, mass, sigma=0.0, OPinv=inverse, v0=start)
    order = np.argsort(squared)
    return squared[order], shapes[:, order]
