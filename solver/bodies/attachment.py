"""Places on bodies at which links and forces act.

A place is a vector that follows its body: a point of it, a mean over points, or an axis that turns
with it. Of a meshed body it is linear in the unknowns, of a rigid one a sum of material points; so
rows over a step give its change exactly, and forces along them do exactly the work of that change.
The places of a body are points of it as contact has them (`solver/contact/body_points.py`).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import basix.ufl
import numpy as np
import scipy.sparse as sp
import ufl
from dolfinx import fem, geometry, la, mesh

from solver.bodies.elastic_body import ElasticBody
from solver.bodies.packed_form import PackedForm
from solver.bodies.reduced_body import ReducedBody
from solver.parallel import global_sum
from solver.types import Array, Indices


class MeshedPlace(NamedTuple):
    """A place of a meshed body.

    Attributes:
        rows: What turns the owned unknowns into its displacement, (d, unknowns).
        reference: It in the undeformed body, (d,), m.
    """

    rows: sp.csr_matrix
    reference: Array


class RigidPlace(NamedTuple):
    """A place of a rigid body: a sum of material points.

    Attributes:
        points: The points, (m, d), m.
        shares: By how much each counts, (m,).
    """

    points: Array
    shares: Array


def point_of(body: ElasticBody, place: Array) -> MeshedPlace:
    """A point of a meshed body, in the cell that is nearest, (d,), m; collective."""
    d, domain, comm = body.dimension, body.space.mesh, body.comm
    target = np.zeros((1, 3))
    target[0, :d] = place
    cell, away = _nearest_cell(domain, target)
    distances = comm.allgather(away)
    holder = int(np.argmin(distances))
    found = None
    if comm.rank == holder:
        nodes, weights = _shape_functions(body, cell, target[0])
        found = body.space.dofmap.index_map.local_to_global(nodes.astype(np.int32)), weights
    numbers, weights = comm.bcast(found, root=holder)
    first = body.space.dofmap.index_map.local_range[0]
    own = numbers - first
    inside = (own >= 0) & (own < body.owned)
    return MeshedPlace(_alike(own[inside], weights[inside], body), np.array(place, dtype=float))


def _nearest_cell(domain: mesh.Mesh, target: Array) -> tuple[int, float]:
    """The owned cell of this rank nearest to a point, (1, 3), and its distance, m."""
    cells = np.arange(domain.topology.index_map(domain.topology.dim).size_local, dtype=np.int32)
    if not len(cells):
        return -1, np.inf
    tree = geometry.bb_tree(domain, domain.topology.dim, cells)
    middles = geometry.create_midpoint_tree(domain, domain.topology.dim, cells)
    (cell,) = geometry.compute_closest_entity(tree, middles, domain, target)
    (square,) = geometry.squared_distance(domain, domain.topology.dim, np.array([cell]), target)
    return int(cell), float(np.sqrt(square))


def _shape_functions(body: ElasticBody, cell: int, target: Array) -> tuple[Indices, Array]:
    """Nodes of a cell of this rank, and shape functions at a point, (3,)."""
    domain = body.space.mesh
    x = domain.geometry.x[domain.geometry.dofmap[cell]]
    place = domain.geometry.cmap.pull_back(target[None], x)
    kind = domain.basix_cell()
    element = basix.ufl.element("Lagrange", kind.name, body.space.ufl_element().degree)
    return body.space.dofmap.list[cell], element.tabulate(0, place)[0, 0]


def _alike(nodes: Indices, weights: Array, body: ElasticBody | ReducedBody) -> sp.csr_matrix:
    """Rows that weigh owned nodes, in all directions alike."""
    row = sp.csr_matrix((weights, (np.zeros(len(nodes), int), nodes)), (1, body.owned))
    return sp.csr_matrix(sp.kron(row, sp.identity(body.dimension), format="csr"))


def _nodal(body: ElasticBody, integrand: Any) -> Array:
    """Owned entries of a form that is linear in the displacement."""
    vector = la.vector(body.space.dofmap.index_map, body.space.dofmap.index_map_bs)
    PackedForm(integrand).vector(vector.array)
    vector.scatter_reverse(la.InsertMode.add)
    return np.array(vector.array[: body.size])


def face_of(body: ElasticBody, facet_tags: mesh.MeshTags, *tags: int) -> MeshedPlace:
    """The mean of facets of a meshed body: a force on it is a traction that is even; collective."""
    domain, d = body.space.mesh, body.dimension
    ds = ufl.Measure("ds", domain, subdomain_data=facet_tags)(tags)
    test, x = ufl.TestFunction(body.space), ufl.SpatialCoordinate(domain)
    area = _integral(body, _one(domain) * ds)
    rows = [_nodal(body, test[k] * ds) / area for k in range(d)]
    middle = [_integral(body, x[k] * ds) / area for k in range(d)]
    return MeshedPlace(sp.csr_matrix(np.array(rows)), np.array(middle))


def _integral(body: ElasticBody, integrand: Any) -> float:
    """An integral over all ranks."""
    return float(global_sum(body.comm, np.array([PackedForm(integrand).scalar()]))[0])


def _one(domain: mesh.Mesh) -> Any:
    """The constant 1."""
    return fem.Constant(domain, 1.0)


def centre_of(body: ElasticBody) -> MeshedPlace:
    """The centre of mass of a meshed body: a force on it acts as its weight does."""
    return MeshedPlace(sp.csr_matrix(body.directional_mass / body.mass), body.centre)


def axes_of(body: ElasticBody) -> list[MeshedPlace]:
    """The unit vectors of the undeformed body, by the mean of its deformation gradient; collective.

    They turn with it as a whole, and are linear in the displacement.
    """
    if body.clamped:
        nothing = sp.csr_matrix((body.dimension, body.size))
        return [MeshedPlace(nothing, axis) for axis in np.eye(body.dimension)]
    domain, d = body.space.mesh, body.dimension
    test = ufl.TestFunction(body.space)
    volume = _integral(body, _one(domain) * ufl.dx)
    found = []
    for axis in range(d):
        rows = [_nodal(body, ufl.grad(test)[k, axis] * ufl.dx) / volume for k in range(d)]
        found.append(MeshedPlace(sp.csr_matrix(np.array(rows)), np.eye(d)[axis]))
    return found
