"""Contact points of a meshed surface: where they are, rows that give position and traction there.

A point is a quadrature point of the boundary facets. With the rule "nodes" (Gauss-Lobatto) the
points of neighbouring facets coincide: they are merged face by face, weights add and tractions
average. A corner thus carries one point for each face that meets there.
"""

from __future__ import annotations

from typing import NamedTuple

from petsc4py import PETSc

import numpy as np
import scipy.sparse as sp
from dolfinx import fem, mesh

from solver.bodies.surface_layer import Layer
from solver.contact.facets import Evaluations, evaluate_facets, extent, gather
from solver.contact.quadrature import Cut
from solver.scene.material import Material
from solver.types import Array, Indices


def same(chosen: Indices, before: Indices) -> bool:
    """True if these are the same points in order; np.array_equal takes ten times as long."""
    return chosen is before or chosen.tobytes() == before.tobytes()


def normal_stress_map(material: Material, normal: Array) -> Array:
    """Rows D with S N = D (2 E) for normals N (n, d), the strain's entries in one: (n, d, d d).

    D is symmetric in the strain's indices, so that D^T gives symmetric matrices.
    """
    count, d = normal.shape
    shared = np.einsum("ik,nl->nikl", np.eye(d), normal)
    rows = material.shear * (shared + shared.swapaxes(2, 3))
    rows += material.lame * normal[:, :, None, None] * np.eye(d)
    return np.asarray(0.5 * rows.reshape(count, d, d * d))


class SurfaceRows(NamedTuple):
    """Rows from displacements to positions and tractions: e evaluations that make p points."""

    numbers: Indices
    """The point that each evaluation belongs to, and the nodes that it reaches, (e, 1 + k)."""
    table: Array
    """Numbers of each evaluation, one after another, (e, 1 + k + k d + d d d): its weight in the
    averages of its point, the shape functions N of the nodes, their derivatives, 1/m, and D with
    S N = D (2 E), Pa."""
    reference: Array
    """Positions of the points in the undeformed body, (p, d), m."""

    def parts(self) -> tuple[Array, Array, Array, Array]:
        """The numbers of `table`, (e,), (e, k), (e, k, d) and (e, d, d, d)."""
        (e, d), k = (len(self.table), self.reference.shape[1]), self.numbers.shape[1] - 1
        share, values, gradients, stiffness = np.split(
            self.table, [1, 1 + k, 1 + k + k * d], axis=1
        )
        return share[:, 0], values, gradients.reshape(e, k, d), stiffness.reshape(e, d, d, d)


class NitscheState(NamedTuple):
    """Positions and nominal tractions of the points of a surface in one configuration."""

    values: Array
    """All of it, (2 p + e (d + 1), d): x and T of all points, and for each evaluation F and S N,
    the second Piola-Kirchhoff stress on the normal, Pa."""
    position: Array
    """x, (p, d), m."""
    traction: Array
    """T = F S N, (p, d), Pa, averaged over the evaluations of a point."""


def new_state(rows: SurfaceRows) -> NitscheState:
    """Room for the state of a surface, which `meshed.evaluate` fills in."""
    p, d = rows.reference.shape
    values = np.empty((2 * p + len(rows.numbers) * (d + 1), d))
    return NitscheState(values, values[:p], values[p : 2 * p])


class TractionPull(NamedTuple):
    """Factor of the gradient of the traction: theta/gamma_h (w T - w_c f)."""

    scale: Array
    """theta w/gamma_h, m2/Pa or m3/Pa, and theta/gamma_h, m/Pa, (p, 2)."""
    force: Array
    """w_c f, (p, d), N: normal, tangential."""
    frame: Array
    """Rows normal and tangents that they are given in, (d, d)."""
    old: float
    """Weight of the traction at t_n: alpha_f, or 0 to leave the theta term out."""
    new: float
    """At t_{n+1}: 1 - alpha_f, or 0."""


class ContactPoints:
    """The points of a surface, and the linear maps between them and the unknowns of its layer.

    Attributes:
        rows: What turns displacements of the layer's nodes into positions and tractions.
        values_T: Forces on these nodes by those at the points, for all directions alike.
    """

    def __init__(
        self,
        table: Evaluations,
        node_positions: Array,
        layer: Layer,
        material: Material,
        *,
        gamma: float,
        degree: int,
        size: float,
        merge: bool,
    ):
        """Merge the evaluations of all facets into points; gamma is Nitsche's, without dimension.

        `merge`: evaluations of one face at one place are one point. Places that are nearer than
        1e-9 of the size of the whole body (m) are one.
        """
        self.layer, self.size, self.node_positions = layer, size, node_positions
        self.dimension = table.position.shape[1]
        first, point = _merged(table, size) if merge else _apart(table)
        self.count = len(first)
        self.weight: Array = np.asarray(np.bincount(point, table.weight), dtype=np.float64)
        share = table.weight / self.weight[point]
        each = np.arange(len(point))
        average = sp.csr_matrix((share, (point, each)), shape=(self.count, len(point)))
        self.reference: Array = table.position[first]
        self.tag = table.tag[first]
        self.normal = average @ table.normal
        self.gamma_h: Array = gamma * material.longitudinal * degree**2 / (average @ table.size)
        shape_functions = np.where(np.abs(table.values) < 1e-14, 0.0, table.values)
        stiffness = normal_stress_map(material, table.normal)
        parts = share, shape_functions, table.gradients, stiffness
        self.rows = SurfaceRows(
            np.ascontiguousarray(np.column_stack([point, table.nodes]), dtype=np.int64),
            np.ascontiguousarray(np.column_stack([each.reshape(len(point), -1) for each in parts])),
            np.ascontiguousarray(self.reference),
        )
        self.values_T = sp.csr_matrix(self._rows_of(share[:, None] * shape_functions).T)

    def _rows_of(self, each: Array) -> sp.csr_matrix:
        """Rows of the points by those of their evaluations, added up, without zeros.

        The latter are (e, k), or (e, k, d, d) where each node has d columns and each point d rows.
        """
        numbers = self.rows.numbers
        d = each.shape[-1] if each.ndim == 4 else 1
        each = each.reshape(*each.shape[:2], d, d)
        rows = numbers[:, :1, None, None] * d + np.arange(d)[:, None]
        columns = numbers[:, 1:, None, None] * d + np.arange(d)
        places = (np.broadcast_to(part, each.shape).ravel() for part in (rows, columns))
        shape = self.count * d, self.layer.size * d
        found = sp.csr_matrix((each.ravel(), tuple(places)), shape=shape)
        found.eliminate_zeros()  # what tabulation leaves at other nodes
        return found

    def traction_rows(self) -> sp.csr_matrix:
        """T of the undeformed body as a linear map, (points d, nodes d): C sym(grad u) N."""
        share, _, gradients, stiffness = self.rows.parts()
        along = np.einsum("eijl,eal->eaij", stiffness, gradients)
        return self._rows_of(2.0 * share[:, None, None, None] * along)

    def position_rows(self) -> sp.csr_matrix:
        """Positions as a linear map of the displacements, (points d, nodes d)."""
        return sp.csr_matrix(sp.kron(self.values_T.T, sp.identity(self.dimension), "coo"))


def _merged(table: Evaluations, size: float) -> tuple[Indices, Indices]:
    """The first evaluation of each point and the point of each evaluation: those at one place."""
    keys = np.column_stack([table.tag, np.round(table.position / size, 9)])
    _, first, point = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    return first, point.ravel()


def _apart(table: Evaluations) -> tuple[Indices, Indices]:
    """The first evaluation and the point of each, where every evaluation is its own point."""
    each = np.arange(len(table.position))
    return each, each


def contact_points(
    V: fem.FunctionSpace,
    facet_tags: mesh.MeshTags,
    material: Material,
    *,
    points: str,
    gamma: float,
    cut: Cut | None = None,
) -> ContactPoints:
    """The contact points of all tagged boundary facets of a body; the same on every rank.

    They are "nodes" or "gauss"; gamma is Nitsche's parameter without dimension. `cut` gives Gauss
    points on pieces of the facets.

    Raises:
        ValueError: For pieces with "nodes", and as `facet_rule`.
    """
    if cut is not None and points != "gauss":
        raise ValueError(f"contact_points: got cuts with points at {points!r}, allowed 'gauss'")
    degree = V.ufl_element().degree
    size = extent(V.mesh)
    owned = evaluate_facets(V, facet_tags, points, degree, cut)
    return ContactPoints(
        *gather(V, owned, size),
        material,
        gamma=gamma,
        degree=degree,
        size=size,
        merge=points == "nodes",
    )


def theta_matrix(points: ContactPoints, scale: Array, like: PETSc.Mat) -> PETSc.Mat:
    """(theta/gamma_h) G_T^T w G_T, with the rows G_T of the tractions of the undeformed body.

    The scale is theta w/gamma_h of each point, (points,), m2/Pa or m3/Pa. The matrix `like`, of the
    body, gives sizes and distribution.
    """
    d = points.dimension
    weight = np.repeat(scale, d)
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
