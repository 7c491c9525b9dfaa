"""A face of a meshed body as what carries others: its facets and their nodes, in order."""

from __future__ import annotations

from dataclasses import dataclass

import basix
import numpy as np
from dolfinx import fem, mesh

from solver.bodies.surface_layer import Layer
from solver.contact.facets import (
    Sides,
    cell_nodes,
    facet_frames,
    facet_kind,
    shared_layer,
    tagged_sides,
)
from solver.contact.nitsche_points import extent
from solver.types import Array, Indices


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
    """Where the nodes of the face are in the undeformed body, (nodes, d), m."""
    layer: Layer
    """The exchange of their values between ranks, in the same order."""
    degree: int
    """Polynomial degree of the displacement: 1 or 2."""
    cell: str
    """Shape of the facets: "interval", "triangle" or "quadrilateral"."""

    @property
    def outlines(self) -> Array:
        """Places that cut the facets of a surface opposite, m (`cuts` of `contact_points`).

        In the plane where facets end, (facets + 1, 2); in space corners in turn, (facets, k, 3).
        """
        if self.cell == "interval":
            return self.positions[[*self.nodes[:, 0], self.nodes[-1, -1]]]
        ring = [0, 1, 2] if self.cell == "triangle" else [0, 1, 3, 2]
        return self.positions[self.nodes[:, ring]]


def carrier_surface(V: fem.FunctionSpace, facet_tags: mesh.MeshTags, tag: int) -> Facets:
    """The face `tag` of a body, whose displacement has degree 1 or 2, as a carrier; collective.

    Raises:
        ValueError: For other degrees, for a face without facets, and in the plane for a face that
            is not one piece with two ends.
    """
    degree, domain = V.ufl_element().degree, V.mesh
    if degree not in (1, 2):
        raise ValueError(f"carrier_surface: got degree {degree}, allowed 1 or 2")
    chosen = facet_tags.indices[facet_tags.values == tag]
    tags = mesh.meshtags(domain, facet_tags.dim, chosen, np.full(len(chosen), tag, np.int32))
    mine = _outward_nodes(V, tagged_sides(domain, tags), degree)
    everything = domain.comm.allgather(mine)
    numbers, places = (np.concatenate(part) for part in zip(*everything, strict=True))
    if not len(numbers):
        raise ValueError(f"carrier_surface: the body has no facets with tag {tag}")
    scale = extent(domain)
    nodes, positions, layer = shared_layer(V, numbers, places, scale)
    order = np.lexsort(np.round(places.mean(axis=1) / scale, 9).T[::-1])
    if domain.topology.dim == 2:
        # From basix's order (ends first) to that along the facet.
        nodes = nodes[:, [0, *range(2, degree + 1), 1]]
        order = _chain(nodes[:, 0], nodes[:, -1])
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


def _chain(first: Indices, last: Indices) -> Indices:
    """Order in which facets follow one another, from the one that no other ends at."""
    follower = {int(node): facet for facet, node in enumerate(first)}
    starts = np.flatnonzero(~np.isin(first, last))
    order = [int(starts[0])] if len(starts) == 1 else []
    while order and int(last[order[-1]]) in follower:
        order.append(follower[int(last[order[-1]])])
    if len(order) != len(first):
        raise ValueError("carrier_surface: the facets are not one piece with two ends")
    return np.array(order, dtype=np.int64)
