"""The part of Nitsche's method that stands in every tangent: the theta term of tractions."""

from __future__ import annotations

from petsc4py import PETSc

import numpy as np
import scipy.sparse as sp

from solver.contact.nitsche_points import ContactPoints


def theta_matrix(points: ContactPoints, theta: int, like: PETSc.Mat) -> PETSc.Mat:
    """(theta/gamma_h) G_T^T w G_T, with the rows G_T of the tractions of the undeformed body.

    The matrix `like`, of the body, gives sizes and distribution.
    """
    d = points.dimension
    weight = np.repeat(theta * points.weight * (1.0 / points.gamma_h), d)
    rows = points.traction_rows()
    local = sp.csr_matrix(rows.T @ sp.diags(weight) @ rows)
    unknowns = (points.layer.nodes[:, None] * d + np.arange(d)).ravel().astype(PETSc.IntType)
    matrix = PETSc.Mat().createAIJ(like.getSizes(), comm=like.comm)
    matrix.setOption(PETSc.Mat.Option.NEW_NONZERO_ALLOCATION_ERR, False)
    start, end = like.getOwnershipRange()
    for row in np.flatnonzero((unknowns >= start) & (unknowns < end)):
        part = slice(local.indptr[row], local.indptr[row + 1])
        matrix.setValues(unknowns[row], unknowns[local.indices[part]], local.data[part])
    matrix.assemble()
    return matrix
