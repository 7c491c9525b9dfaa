"""The boundary facets of a mesh.

Where they are, what they contribute to contact points, and the face of a body as what carries
others.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import basix
import basix.ufl
import numpy as np
from dolfinx import fem, mesh

from geometry.compat import geometry_degree, geometry_nodes
from geometry.polygon import without_straight
from solver.bodies.surface_layer import Layer
from solver.contact.quadrature import Cut, facet_rule, on_facets
from solver.types import Array, Indices


class Evaluations(NamedTuple):
    """One evaluation of the displacement gradient for each facet and rule point, e of them."""

    nodes: Indices
    """Nodes of the cell, (e, k): their global numbers, or places in a layer."""
    node_positions: Array
    """Where these are, (e, k, d), m."""
    values: Array
    """Their shape functions there, (e, k)."""
    gradients: Array
    """Derivatives of these, (e, k, d), 1/m."""
    normal: Array
    """Outward unit normals, (e, d)."""
    weight: Array
    """Length or area that each stands for, (e,), m or m2."""
    size: Array
    """Cell volume over facet area, (e,), m."""
    tag: Indices
    """Tag of the facet, (e,)."""
    position: Array
    """(e, d), m."""


@dataclass(frozen=True, slots=True)
class Sides:
    """Boundary facets that this rank owns, as sides of cells."""

    cells: Indices
    """Cell that each facet belongs to, (facets,)."""
    sides: Indices
    """Which of the cell's facets it is, (facets,)."""
    tags: Indices
    """Its tag, (facets,)."""


def extent(domain: mesh.Mesh) -> float:
    """The largest side of the box around a mesh, m; the same on every rank."""
    places = domain.geometry.x
    corners = places.min(axis=0, initial=np.inf), places.max(axis=0, initial=-np.inf)
    low, high = zip(*domain.comm.allgather(corners), strict=True)
    return float(np.max(np.max(high, axis=0) - np.min(low, axis=0)))


def tagged_sides(domain: mesh.Mesh, facet_tags: mesh.MeshTags) -> Sides:
    """The tagged boundary facets of a mesh."""
    tdim, topology = domain.topology.dim, domain.topology
    topology.create_connectivity(tdim - 1, tdim)
    topology.create_connectivity(tdim, tdim - 1)
    to_cell, to_facet = topology.connectivity(tdim - 1, tdim), topology.connectivity(tdim, tdim - 1)
    facets = np.intersect1d(mesh.exterior_facet_indices(topology), facet_tags.indices)
    cells = to_cell.array[to_cell.offsets[facets]].astype(np.int64)
    count = len(basix.topology(domain.basix_cell())[tdim - 1])
    sides = np.argmax(to_facet.array.reshape(-1, count)[cells] == facets[:, None], axis=1)
    tags = facet_tags.values[np.searchsorted(facet_tags.indices, facets)]
    return Sides(cells, sides, tags.astype(np.int64))


def facet_frames(cell: basix.CellType) -> tuple[Array, Array]:
    """Frames of the reference facets in the reference cell.

    Returns:
        Origins (facets, d) and edges (facets, d - 1, d): xi -> origin + xi @ edges. The first three
        corners of a facet span it, since the reference facets are parallelograms or triangles.
    """
    corners = basix.geometry(cell)
    faces = basix.topology(cell)[-2]
    origin = np.array([corners[face[0]] for face in faces])
    edges = np.array([corners[face[1 : corners.shape[1]]] - corners[face[0]] for face in faces])
    return origin, edges


def facet_kind(cell: basix.CellType) -> basix.CellType:
    """Shape of the facets of a cell."""
    kind: basix.CellType = basix.cell.subentity_types(cell)[-2][0]
    return kind


def cell_nodes(V: fem.FunctionSpace, cells: Indices) -> tuple[Indices, Array]:
    """Global numbers (cells, k) and positions (cells, k, d) of the nodes of cells."""
    dofs = V.dofmap.list[cells]
    numbers = V.dofmap.index_map.local_to_global(dofs.ravel()).reshape(dofs.shape)
    return numbers, V.tabulate_dof_coordinates()[dofs, : V.mesh.topology.dim]


def evaluate_facets(
    V: fem.FunctionSpace,
    facet_tags: mesh.MeshTags,
    points: str,
    degree: int,
    cut: Cut | None = None,
) -> Evaluations:
    """Evaluations of all owned facets and rule points, with global nodes.

    The rule may be one on pieces of them, that `cut` gives.
    """
    domain, kind = V.mesh, V.mesh.basix_cell()
    found = tagged_sides(domain, facet_tags)
    origin, edges = (part[found.sides] for part in facet_frames(kind))
    x = domain.geometry.x[geometry_nodes(domain)[found.cells], : domain.topology.dim]
    shape = basix.ufl.element("Lagrange", kind.name, degree)
    mapping = basix.ufl.element("Lagrange", kind.name, geometry_degree(domain))
    if cut is None:
        rule = on_facets(len(x), facet_rule(points, degree, facet_kind(kind)))
    else:
        at = np.concatenate([origin[:, None], origin[:, None] + edges], axis=1).swapaxes(0, 1)
        corners = np.stack([_places(mapping, place, x) for place in at], axis=1)
        rule = cut(corners, facet_kind(kind), degree)
    row, local, weight = rule
    at = origin[row] + np.einsum("ej,eji->ei", local, edges[row])
    values, places = tabulated(shape, 1, at), tabulated(mapping, 1, at)
    jacobian = np.einsum("jek,eki->eij", places[1:], x[row])
    inverse = np.linalg.inv(jacobian)
    normal = np.einsum(
        "eji,ej->ei", inverse, basix.cell.facet_outward_normals(kind)[found.sides[row]]
    )
    nodes, node_positions = cell_nodes(V, found.cells)
    return Evaluations(
        nodes=nodes[row],
        node_positions=node_positions[row],
        values=values[0],
        gradients=np.einsum("jek,eji->eki", values[1:], inverse),
        normal=normal / np.linalg.norm(normal, axis=1)[:, None],
        weight=weight * _area(jacobian, edges[row]),
        size=_cell_heights(mapping, kind, x, found.sides)[row],
        tag=found.tags[row],
        position=_places(mapping, at, x[row]),
    )


def _places(mapping: Any, at: Array, x: Array) -> Array:
    """Places of one reference point for each cell with corners x, (cells, d)."""
    places: Array = np.einsum("fk,fki->fi", tabulated(mapping, 0, at)[0], x)
    return places


def tabulated(element: Any, order: int, at: Array) -> Array:
    """An element's functions and derivatives at points (n, d), which may be none on a rank.

    Asked for derivatives at no point at all, basix ends the program.
    """
    table: Array = element.tabulate(order, at if len(at) else np.zeros((1, at.shape[1])))
    return table[:, : len(at)]


def _area(jacobian: Array, edges: Array) -> Array:
    """Length or area of a facet for one of parameters, (n,)."""
    spanned = np.einsum("eij,ekj->eki", jacobian, edges)
    if spanned.shape[1] == 1:
        return np.linalg.norm(spanned[:, 0], axis=1)
    return np.linalg.norm(np.cross(spanned[:, 0], spanned[:, 1]), axis=1)


def _cell_heights(mapping: Any, kind: basix.CellType, x: Array, sides: Indices) -> Array:
    """Cell volume over facet area, both from the Jacobian at their centres, m, (facets,)."""
    origin, edges = facet_frames(kind)
    corners = basix.geometry(facet_kind(kind))
    centres = origin + np.einsum("j,sji->si", corners.mean(axis=0), edges)

    def jacobian(at: Array) -> Array:
        """Jacobian of each facet's cell at one place each."""
        derivatives = tabulated(mapping, 1, at)[1:]
        jacobians: Array = np.einsum("jfk,fki->fij", derivatives, x)
        return jacobians

    middle = np.broadcast_to(basix.geometry(kind).mean(axis=0), (len(x), x.shape[2]))
    volume = basix.cell.volume(kind) * np.abs(np.linalg.det(jacobian(middle)))
    area = basix.cell.volume(facet_kind(kind)) * _area(jacobian(centres[sides]), edges[sides])
    heights: Array = volume / area
    return heights


def shared_layer(
    V: fem.FunctionSpace, nodes: Indices, positions: Array, scale: float
) -> tuple[Indices, Array, Layer]:
    """The layer of some nodes, in an order that no partition changes.

    Args:
        V: Displacement space.
        nodes: Global numbers, the same on every rank, repeated as they come, of any shape.
        positions: Their positions, (..., d).
        scale: Of the whole body, m: places that are nearer than 1e-9 of it are one.

    Returns:
        Where each of `nodes` stands in the layer, positions of the layer's nodes, the layer.
    """
    unique, first, inverse = np.unique(nodes, return_index=True, return_inverse=True)
    where = positions.reshape(-1, positions.shape[-1])[first]
    canonical = np.lexsort(np.round(where / scale, 9).T[::-1])
    rank_in_layer = np.empty(len(unique), dtype=np.int64)
    rank_in_layer[canonical] = np.arange(len(unique))
    start, end = V.dofmap.index_map.local_range
    mine = (unique >= start) & (unique < end)
    layer = Layer(
        V.mesh.comm, (unique[mine] - start).astype(np.int32), rank_in_layer[mine], unique[canonical]
    )
    return rank_in_layer[inverse.reshape(nodes.shape)], where[canonical], layer


def gather(
    V: fem.FunctionSpace, owned: Evaluations, scale: float
) -> tuple[Evaluations, Array, Layer]:
    """The evaluations of all ranks in an order that no partition changes; collective.

    Also the positions of their nodes, and the layer of these. Places that are nearer than 1e-9 of
    `scale` are one.
    """
    columns = zip(*V.mesh.comm.allgather(owned), strict=True)
    table = Evaluations(*(np.concatenate(column) for column in columns))
    middles = table.node_positions.mean(axis=1)
    places = np.round(np.column_stack([table.position, middles]) / scale, 9)
    order = np.lexsort((*places.T[::-1], table.tag))
    numbers, positions, layer = shared_layer(V, table.nodes, table.node_positions, scale)
    table = table._replace(nodes=numbers)
    return Evaluations(*(column[order] for column in table)), positions, layer


@dataclass(frozen=True, slots=True, kw_only=True)
class Facets:
    """The facets of one face of a body, in one order on every rank.

    In the plane the facets follow one another along the face, in the direction of its tangent (the
    outward normal turned clockwise: +x on a top), and so do the nodes of each. In space they are
    ordered by place, and the nodes of each are in the order of basix's Lagrange element on the
    facet, first the corners, such that (second - first) x (third - first) points outwards.
    """

    nodes: Indices
    """Nodes of each facet, as places in `positions`, (facets, k)."""
    positions: Array
    """Places of the nodes of the face in the undeformed body, (nodes, d), m."""
    layer: Layer
    """The exchange of their values between ranks, in the same order."""
    degree: int
    """Polynomial degree of the displacement: 1 or 2."""
    cell: str
    """Shape of the facets: "interval", "triangle" or "quadrilateral"."""


def carrier_surface(V: fem.FunctionSpace, facet_tags: mesh.MeshTags, *tags: int) -> Facets:
    """The facets of a body with some tags as a carrier; collective.

    The displacement has degree 1 or 2.

    Raises:
        ValueError: For other degrees, without such facets, and in the plane where they go round in
            a circle.
    """
    degree, domain = V.ufl_element().degree, V.mesh
    if degree not in (1, 2):
        raise ValueError(f"carrier_surface: got degree {degree}, allowed 1 or 2")
    chosen = facet_tags.indices[np.isin(facet_tags.values, tags)]
    marked = mesh.meshtags(domain, facet_tags.dim, chosen, np.zeros(len(chosen), np.int32))
    mine = _outward_nodes(V, tagged_sides(domain, marked), degree)
    everything = domain.comm.allgather(mine)
    numbers, places = (np.concatenate(part) for part in zip(*everything, strict=True))
    if not len(numbers):
        raise ValueError(
            f"carrier_surface: the body has no facets with tags {tuple(map(int, tags))}"
        )
    scale = extent(domain)
    nodes, positions, layer = shared_layer(V, numbers, places, scale)
    order = np.lexsort(np.round(places.mean(axis=1) / scale, 9).T[::-1])
    if domain.topology.dim == 2:
        # From basix's order (ends first) to that along the facet.
        nodes = nodes[:, [0, *range(2, degree + 1), 1]]
        order = _chains(nodes[:, 0], nodes[:, -1], positions)
    kind = facet_kind(domain.basix_cell()).name
    return Facets(nodes=nodes[order], positions=positions, layer=layer, degree=degree, cell=kind)


def _outward_nodes(V: fem.FunctionSpace, found: Sides, degree: int) -> tuple[Indices, Array]:
    """Global nodes and positions of facets, (facets, k) and (facets, k, d), turned outwards."""
    kind = V.mesh.basix_cell()
    places, turned = _facet_nodes(kind, degree)
    numbers, positions = cell_nodes(V, found.cells)
    chosen = places[found.sides]
    where = np.take_along_axis(positions, chosen[:, :, None], axis=1)
    spanned = where[:, 1:3] - where[:, :1]
    if spanned.shape[2] == 2:
        normal = spanned[:, 0] @ np.array([[0.0, 1.0], [-1.0, 0.0]])
    else:
        normal = np.cross(spanned[:, 0], spanned[:, 1])
    inwards = np.einsum("fi,fi->f", normal, where.mean(axis=1) - positions.mean(axis=1)) < 0
    chosen = np.where(inwards[:, None], chosen[:, turned], chosen)
    return (
        np.take_along_axis(numbers, chosen, axis=1),
        np.take_along_axis(positions, chosen[:, :, None], axis=1),
    )


def _facet_nodes(kind: basix.CellType, degree: int) -> tuple[Indices, Indices]:
    """Nodes of the cell on each of its facets, (facets, k), and the order that turns a facet over.

    Both found by place: the node of the cell that lies where the facet's own element has one.
    """
    cell, facet = (_node_places(which, degree) for which in (kind, facet_kind(kind)))
    origin, edges = facet_frames(kind)
    on_cell = origin[:, None] + np.einsum("kj,sji->ski", facet, edges)
    turned = 1 - facet if facet.shape[1] == 1 else facet[:, ::-1]
    return _nearest(cell, on_cell), _nearest(facet, turned)


def _node_places(kind: basix.CellType, degree: int) -> Array:
    """Reference positions of the nodes of a Lagrange element."""
    variant = basix.LagrangeVariant.gll_warped
    places: Array = basix.create_element(basix.ElementFamily.P, kind, degree, variant).points
    return places


def _nearest(places: Array, wanted: Array) -> Indices:
    """Number of the place that is nearest to each wanted one."""
    distance = np.linalg.norm(wanted[..., None, :] - places, axis=-1)
    nearest: Indices = np.argmin(distance, axis=-1)
    return nearest


def _chains(first: Indices, last: Indices, positions: Array) -> Indices:
    """Order in which facets follow one another, each chain from one that no other ends at.

    Chains follow in the direction from the first to the last node of facets.
    """
    follower = {int(node): facet for facet, node in enumerate(first)}
    starts = np.flatnonzero(~np.isin(first, last))
    along = np.sum(positions[last] - positions[first], axis=0)
    order: list[int] = []
    for start in starts[np.argsort(positions[first[starts]] @ along, kind="stable")]:
        order.append(int(start))
        while int(last[order[-1]]) in follower:
            order.append(follower[int(last[order[-1]])])
    if len(order) != len(first):
        raise ValueError("carrier_surface: got facets that go round in a circle, allowed a face")
    return np.array(order, dtype=np.int64)


def outlines(surface: Facets) -> tuple[Array, ...]:
    """Corners around the pieces of a face, (n, d), m, that around the outermost first.

    In the plane the two ends of each piece.
    """
    nodes, places = surface.nodes, surface.positions
    if places.shape[1] == 2:
        starts = np.flatnonzero(~np.isin(nodes[:, 0], nodes[:, -1]))
        ends = np.append(starts[1:], len(nodes)) - 1
        return tuple(places[[nodes[a, 0], nodes[b, -1]]] for a, b in zip(starts, ends, strict=True))
    ring = [0, 1, 2] if surface.cell == "triangle" else [0, 1, 3, 2]
    facets = nodes[:, ring]
    sides = np.stack([facets, np.roll(facets, -1, axis=1)], axis=2).reshape(-1, 2)
    there = {(int(a), int(b)) for a, b in sides}
    follower: dict[int, list[int]] = {}
    for a, b in sides:
        if (int(b), int(a)) not in there:
            follower.setdefault(int(a), []).append(int(b))
    found = []
    while follower:
        start = min(follower)
        loop, here = [start], follower[start].pop()
        while here != start:
            loop.append(here)
            here = follower[here].pop()
        follower = {a: more for a, more in follower.items() if more}
        found.append(without_straight(places[loop], 1e-9 * float(np.ptp(places))))
    return tuple(sorted(found, key=lambda ring: -float(np.ptp(ring, axis=0).max())))
