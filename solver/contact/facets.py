"""What the boundary facets of a mesh contribute to its contact points, evaluated facet by facet."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import basix
import basix.ufl
import numpy as np
from dolfinx import fem, mesh
from numpy.typing import NDArray

from solver.parallel import Layer

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Evaluations:
    """One evaluation of the displacement gradient for each facet and rule point.

    The rows are in one order on every rank.
    """

    nodes: NDArray[np.int64]
    values: Array
    gradients: Array
    node_positions: Array
    normal: Array
    weight: Array
    size: Array
    tag: NDArray[np.int64]
    position: Array


def facet_rule(points: str, degree: int, cell: str) -> tuple[Array, Array]:
    """Points and weights on the unit facet: Gauss-Lobatto ("nodes") or Gauss ("gauss")."""
    kind = {"interval": basix.CellType.interval}[cell]
    if points == "nodes":
        return basix.make_quadrature(kind, 2 * degree - 1, basix.QuadratureType.gll)
    return basix.make_quadrature(kind, 2 * degree + 1, basix.QuadratureType.gauss_jacobi)


def evaluate_facets(
    V: fem.FunctionSpace, facet_tags: mesh.MeshTags, points: str, degree: int
) -> list[tuple[Any, ...]]:
    """One record for each owned facet and rule point: as in `Evaluations`, with global nodes."""
    domain = V.mesh
    tdim, topology = domain.topology.dim, domain.topology
    topology.create_connectivity(tdim - 1, tdim)
    topology.create_connectivity(tdim, tdim - 1)
    to_cell, to_facet = topology.connectivity(tdim - 1, tdim), topology.connectivity(tdim, tdim - 1)
    cell_type = domain.basix_cell()
    corners, faces = basix.geometry(cell_type), basix.topology(cell_type)[tdim - 1]
    outward, face_size = (
        basix.cell.facet_outward_normals(cell_type),
        basix.cell.facet_reference_volumes(cell_type),
    )
    facet_kind = basix.cell.subentity_types(cell_type)[tdim - 1][0].name
    rule, rule_weight = facet_rule(points, degree, facet_kind)
    shape = basix.ufl.element("Lagrange", domain.basix_cell().name, degree)
    map_shape = basix.ufl.element("Lagrange", domain.basix_cell().name, domain.geometry.cmap.degree)
    centre = corners.mean(axis=0)[None, :]
    node_positions = V.tabulate_dof_coordinates()[:, :tdim]
    exterior = np.intersect1d(mesh.exterior_facet_indices(topology), facet_tags.indices)
    tag_of = dict(zip(facet_tags.indices.tolist(), facet_tags.values.tolist(), strict=True))
    records = []
    for facet in exterior.tolist():
        cell = to_cell.links(facet)[0]
        side = int(np.flatnonzero(to_facet.links(cell) == facet)[0])
        origin = corners[faces[side][0]]
        edges = np.array([corners[k] - origin for k in faces[side][1:tdim]])
        local = origin + rule @ edges
        x = domain.geometry.x[domain.geometry.dofmap[cell], :tdim]
        volume, area = (
            _measure(map_shape, x, p, outward[side]) for p in (centre, local.mean(axis=0)[None, :])
        )
        h = volume[0] * basix.cell.volume(cell_type) / (area[1] * face_size[side])
        values, map_values = shape.tabulate(1, local), map_shape.tabulate(1, local)
        dofs = V.dofmap.cell_dofs(cell)
        nodes = V.dofmap.index_map.local_to_global(dofs)
        for q, weight in enumerate(rule_weight):
            inverse = np.linalg.inv(np.einsum("jk,ki->ij", map_values[1:, q], x))
            normal = inverse.T @ outward[side]
            area_q = _measure(map_shape, x, local[q][None, :], outward[side])[1]
            gradients, position = values[1:, q].T @ inverse, map_values[0, q] @ x
            normal = normal / np.linalg.norm(normal)
            size = weight * area_q * face_size[side]
            record = nodes, values[0, q], gradients, node_positions[dofs], normal, size, h
            records.append((*record, tag_of[facet], position))
    return records


def _measure(element: Any, x: Array, point: Array, outward: Array) -> tuple[float, float]:
    """Current over reference volume, and the same of facet areas, at a point of a cell."""
    jacobian = np.einsum("jk,ki->ij", element.tabulate(1, point)[1:, 0], x)
    volume = abs(float(np.linalg.det(jacobian)))
    return volume, volume * float(np.linalg.norm(np.linalg.inv(jacobian).T @ outward))


def gather(
    V: fem.FunctionSpace, records: list[tuple[Any, ...]], scale: float
) -> tuple[Evaluations, Layer]:
    """All records in an order that no partition changes, and the layer of their nodes.

    Places that are nearer than 1e-9 of `scale` are one.
    """
    comm = V.mesh.comm
    everything = [record for part in comm.allgather(records) for record in part]
    nodes, values, gradients, where, normal, weight, size, tag, position = (
        np.array(column) for column in zip(*everything, strict=True)
    )
    places = np.round(np.column_stack([position, where.mean(axis=1)]) / scale, 9)
    order = np.lexsort((*places.T[::-1], tag))
    unique, first, inverse = np.unique(nodes, return_index=True, return_inverse=True)
    node_positions = where.reshape(-1, where.shape[-1])[first]
    canonical = np.lexsort(np.round(node_positions / scale, 9).T[::-1])
    rank_in_layer = np.empty(len(unique), dtype=np.int64)
    rank_in_layer[canonical] = np.arange(len(unique))
    start, end = V.dofmap.index_map.local_range
    mine = (unique >= start) & (unique < end)
    layer = Layer(
        comm, (unique[mine] - start).astype(np.int32), rank_in_layer[mine], unique[canonical]
    )
    table = Evaluations(
        nodes=rank_in_layer[inverse.reshape(nodes.shape)][order],
        values=values[order],
        gradients=gradients[order],
        node_positions=node_positions[canonical],
        normal=normal[order],
        weight=weight[order],
        size=size[order],
        tag=tag[order],
        position=position[order],
    )
    return table, layer
