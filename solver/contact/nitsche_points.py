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

    @classmethod
    def of(
        cls,
        *,
        nodes: Indices,
        values: Array,
        gradients: Array,
        point: Indices,
        share: Array,
        stress_rows: Array,
        reference: Array,
    ) -> SurfaceRows:
        """The parts, as the fields name them, put together."""
        e = len(nodes)
        parts = share[:, None], values, gradients.reshape(e, -1), stress_rows.reshape(e, -1)
        numbers: Indices = np.ascontiguousarray(np.column_stack([point, nodes]), dtype=np.int64)
        whole: Array = np.ascontiguousarray(np.concatenate(parts, axis=1))
        return cls(numbers, whole, np.ascontiguousarray(reference))


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
        self.layer, self.material, self.size = layer, material, size
        self.node_positions = table.node_positions
        self.dimension = table.position.shape[1]
        first, point = _merged(table, size) if merge else _apart(table)
        self.count = len(first)
        self.weight: Array = np.asarray(np.bincount(point, table.weight), dtype=np.float64)
        average = _averages(table, point, self.weight)
        self.reference: Array = table.position[first]
        self.tag = table.tag[first]
        self.normal = average @ table.normal
        self.gamma_h: Array = gamma * material.longitudinal * degree**2 / (average @ table.size)
        self._normal = table.normal
        shape_functions = np.where(np.abs(table.values) < 1e-14, 0.0, table.values)
        values = sp.csr_matrix(average @ _node_rows(table, shape_functions, layer))
        values.eliminate_zeros()  # what tabulation leaves at other nodes
        self._sparse = average, values, _gradient_rows(table, layer)
        self.values_T = sp.csr_matrix(values.T)
        self.rows = SurfaceRows.of(
            nodes=table.nodes,
            values=shape_functions,
            gradients=table.gradients,
            point=point,
            share=table.weight / self.weight[point],
            stress_rows=normal_stress_map(material, table.normal),
            reference=self.reference,
        )

    def traction_rows(self) -> sp.csr_matrix:
        """T of the undeformed body as a linear map, (points d, nodes d): C sym(grad u) N."""
        d, lame, shear = self.dimension, self.material.lame, self.material.shear
        average, _, gradient = self._sparse
        along = [gradient[j::d] for j in range(d)]
        normals = [sp.diags(self._normal[:, j]) for j in range(d)]
        across = sum(normals[j] @ along[j] for j in range(d))
        blocks = [
            [
                lame * normals[i] @ along[k]
                + shear * normals[k] @ along[i]
                + (shear * across if i == k else 0 * across)
                for k in range(d)
            ]
            for i in range(d)
        ]
        points = sp.bmat([[average @ blocks[i][k] for k in range(d)] for i in range(d)]).tocsr()
        rows = np.arange(self.count * d).reshape(d, self.count).T.ravel()
        columns = np.arange(self.layer.size * d).reshape(d, self.layer.size).T.ravel()
        return sp.csr_matrix(points[rows][:, columns])

    def position_rows(self) -> sp.csr_matrix:
        """Positions as a linear map of the displacements, (points d, nodes d)."""
        return sp.csr_matrix(sp.kron(self._sparse[1], sp.identity(self.dimension), "coo"))


def _merged(table: Evaluations, size: float) -> tuple[Indices, Indices]:
    """The first evaluation of each point and the point of each evaluation: those at one place."""
    keys = np.column_stack([table.tag, np.round(table.position / size, 9)])
    _, first, point = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    return first, point.ravel()


def _apart(table: Evaluations) -> tuple[Indices, Indices]:
    """The first evaluation and the point of each, where every evaluation is its own point."""
    each = np.arange(len(table.position))
    return each, each


def _averages(table: Evaluations, point: Indices, weight: Array) -> sp.csr_matrix:
    """Averages over the evaluations that meet in a point, (points, evaluations)."""
    each = np.arange(len(point))
    share = table.weight / weight[point]
    return sp.csr_matrix((share, (point, each)), shape=(len(weight), len(point)))


def _node_rows(table: Evaluations, factors: Array, layer: Layer) -> sp.csr_matrix:
    """Factors at the nodes of each evaluation as rows over the layer, (evaluations, nodes)."""
    count, nodes = table.nodes.shape
    rows = np.repeat(np.arange(count), nodes)
    return sp.csr_matrix((factors.ravel(), (rows, table.nodes.ravel())), shape=(count, layer.size))


def _gradient_rows(table: Evaluations, layer: Layer) -> sp.csr_matrix:
    """Derivatives at the evaluations, (evaluations d, nodes): d rows for each evaluation."""
    count, dimension = table.position.shape
    directions = [_node_rows(table, table.gradients[:, :, j], layer) for j in range(dimension)]
    order = np.arange(count * dimension).reshape(dimension, count).T.ravel()
    return sp.vstack(directions).tocsr()[order]


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
    table, layer = gather(V, evaluate_facets(V, facet_tags, points, degree, cut), size)
    return ContactPoints(
        table,
        layer,
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
