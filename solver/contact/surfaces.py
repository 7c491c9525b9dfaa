"""What a body offers to contact: its hull, its faces as carriers, and its points over a carrier."""

from __future__ import annotations

import numpy as np
from dolfinx import mesh

from geometry.block import FACES, Block
from geometry.foundation import face_frame
from geometry.tags import FacetTag, tags_of_faces
from solver.bodies.elastic_body import ElasticBody
from solver.bodies.rigid_body import RigidBox
from solver.contact.body_points import (
    FacePoints,
    FixedPoints,
    NitschePoints,
    NodePoints,
    RigidPoints,
)
from solver.contact.carriers import Carrier, Face
from solver.contact.edge_crossings import Outline, distance_inside
from solver.contact.facets import carrier_surface, extent, shared_layer
from solver.contact.hull import Hull
from solver.contact.interface import Interface
from solver.contact.nitsche_points import contact_points
from solver.scene import Bed, ContactSpec, FrictionSpec
from solver.types import Array

BOX_FACES: dict[int, dict[FacetTag, tuple[int, ...]]] = {
    2: {
        FacetTag.BOTTOM: (0, 1),
        FacetTag.RIGHT: (1, 2),
        FacetTag.TOP: (2, 3),
        FacetTag.LEFT: (3, 0),
    },
    3: dict(
        zip(
            (
                *(FacetTag.BOTTOM, FacetTag.TOP),
                *(FacetTag.FRONT, FacetTag.RIGHT, FacetTag.BACK, FacetTag.LEFT),
            ),
            FACES,
            strict=True,
        )
    ),
}
"""Corners around each face of a block, anticlockwise from outside, as `Block.corners` has them."""


def loops_of(shape: Block | None, dimension: int) -> dict[int, list[int]]:
    """Tags of the faces of a block, and the corners around each, anticlockwise from outside.

    Of what is no box, a convex shape, tags are those of its mesh; None: a box.
    """
    if shape is None or shape.solid is None:
        return {int(tag): list(loop) for tag, loop in BOX_FACES[dimension].items()}
    (part,) = shape.solid.parts
    tags = tags_of_faces([float(rise) for rise in part.normals[:, -1]])
    return {tag: list(face) for tag, face in zip(tags, part.faces, strict=True)}


class BlockSurface:
    """The surface of a block, elastic or rigid.

    Attributes:
        body: The block.
        number: Its number in the system.
        hull: Its hull; the faces are numbered as in `tags`.
        tags: Tags of its faces.
        top: Number of the top among them.
        below: Numbers of the corners of the bottom farthest out, (2 or 4,), in the hull's points.
    """

    has_outline = True

    def __init__(
        self,
        body: ElasticBody | RigidBox,
        number: int,
        corners: Array,
        contact: ContactSpec,
        facet_tags: mesh.MeshTags | None = None,
        *,
        shape: Block | None = None,
    ):
        """Take the block, its undeformed corners, (n, d), m, and the tags of its facets.

        The shape is asked for where it is no box.
        """
        self.body, self.number, self._contact = body, number, contact
        self._facet_tags, self._corners = facet_tags, corners
        self.dimension = body.dimension
        self.thickness = body.shape.thickness if isinstance(body, RigidBox) else body.thickness
        self._loops = loops_of(shape, self.dimension)
        self.tags = tuple(self._loops)
        self.top = self.tags.index(int(FacetTag.TOP))
        self._is_box = shape is None or shape.solid is None
        self.below = np.arange(2 ** (self.dimension - 1))
        if shape is not None and shape.solid is not None:
            places, ends = (
                np.array(some(self.dimension)) for some in (shape.corners, shape.bottom_corners)
            )
            self.below = np.abs(ends[:, None] - places).max(axis=2).argmin(axis=1)
        points: FacePoints
        if isinstance(body, ElasticBody):
            points = nodes_at(body, corners)
        else:
            points = RigidPoints(body, corners)
        self.hull = Hull(points, [self._loops[tag] for tag in self.tags])
        upright = self.hull.placed(np.zeros(body.size)).normals
        upright = np.round(upright, 0 if self._is_box else 12) + 0.0
        upright /= np.linalg.norm(upright, axis=1)[:, None]
        self._frames = {tag: face_frame(upright[k]) for k, tag in enumerate(self.tags)}

    def face(self, tag: int, margin: float) -> Face:
        """A face as a carrier, which carries what is beyond its edge by a part of a facet."""
        frame, corners = self._frames[tag], self._corners[self._loops[tag]]
        ring = None if self._is_box or self.dimension == 2 else corners
        if isinstance(self.body, ElasticBody):
            assert self._facet_tags is not None
            surface = carrier_surface(self.body.space, self._facet_tags, tag)
            nodes = NodePoints(self.body, surface.layer, surface.positions)
            cell, degree = surface.cell, surface.degree
            return Face(nodes, surface.nodes, frame, cell, degree, margin, ring)
        if ring is not None:  # a fan of triangles
            fan = np.array([[0, k, k + 1] for k in range(1, len(ring) - 1)])
            return Face(RigidPoints(self.body, ring), fan, frame, "triangle", 1, margin, ring)
        # In the order of basix: the first tangent runs fastest.
        order = np.lexsort(np.round((corners @ frame[1:].T) / np.ptp(self._corners), 9).T)
        points = RigidPoints(self.body, corners[order])
        cell = "interval" if self.dimension == 2 else "quadrilateral"
        return Face(points, np.arange(len(corners))[None], frame, cell, 1, margin)

    def over(
        self,
        carrier: Carrier,
        law: FrictionSpec,
        faces: frozenset[int],
        *,
        shared: frozenset[int] = frozenset(),
        bed: Bed | None = None,
    ) -> Interface:
        """The interface of the points of some faces with a carrier; collective.

        The theta term of faces that are `shared` stands in another interface. A rigid block has all
        its points in it.
        """
        if isinstance(self.body, RigidBox):
            points = RigidPoints(self.body, *rigid_points(self.body, carrier))
            return Interface(points, carrier, law, bed=bed)
        assert self._facet_tags is not None
        how = self._contact
        chosen = np.isin(self._facet_tags.values, list(faces))
        indices, values = self._facet_tags.indices[chosen], self._facet_tags.values[chosen]
        space = self.body.space
        tags = mesh.meshtags(space.mesh, self._facet_tags.dim, indices, values)
        own = NitschePoints(
            self.body,
            contact_points(space, tags, self.body.material, points=how.points, gamma=how.gamma),
        )
        return Interface(own, carrier, law, theta=how.theta, bed=bed, shared=shared)


def nodes_at(body: ElasticBody, places: Array) -> NodePoints:
    """The nodes of a meshed body at some undeformed places, (n, d), m; collective."""
    space, scale = body.space, extent(body.space.mesh)
    off = np.abs(body.nodes[:, None] - places[None]).max(axis=2)
    rows, which = np.nonzero(off < 1e-6 * scale)
    start = space.dofmap.index_map.local_range[0]
    found = space.mesh.comm.allgather((rows + start, which, body.nodes[rows]))
    numbers, which, positions = (np.concatenate(part) for part in zip(*found, strict=True))
    order = np.argsort(which, kind="stable")
    assert np.array_equal(which[order], np.arange(len(places)))
    rank, where, layer = shared_layer(space, numbers[order], positions[order], scale)
    return NodePoints(body, layer, where, chosen=rank)


def rigid_points(body: RigidBox, carrier: Carrier) -> tuple[Array, Array]:
    """Points of a rigid block that may touch, and the area of the bottom that each stands for, m2.

    They are its corners, on facets that deform also a grid on its bottom, no closer than the
    facets: forces of more points than there are nodes below are not unique. Those of the top stand
    for as much as those of the bottom: they touch where the block lies on its back.

    Of what is no box all stand for the same area, that of the bottom over the number of them there.
    """
    if body.shape.solid is not None:
        return _points_of_shape(body, carrier)
    sides = np.ptp(body.bottom, axis=0)[:-1]
    counts = [1] * len(sides)
    if isinstance(carrier, Face) and not isinstance(carrier.points, FixedPoints):
        counts = [max(1, int(side / carrier.facet + 1e-9)) for side in sides]
    lines = [np.linspace(0, 1, count + 1) for count in counts]
    fractions = np.stack(np.meshgrid(*lines, indexing="ij"), -1).reshape(-1, len(sides))
    inner = (fractions > 0) & (fractions < 1)
    cell = float(np.prod(sides / counts)) * (body.shape.thickness if body.dimension == 2 else 1.0)
    area = cell * np.prod(np.where(inner, 1.0, 0.5), axis=1)
    between = inner.any(axis=1)
    upwards = np.zeros((np.count_nonzero(between), 1))
    grid = body.corners[0] + np.hstack([fractions[between] * sides, upwards])
    corners = np.full(len(body.corners), cell / 2 ** len(sides))
    return np.vstack([body.corners, grid]), np.concatenate([corners, area[between]])


def _points_of_shape(body: RigidBox, carrier: Carrier) -> tuple[Array, Array]:
    """Points of a rigid block that is no box, and the area that each stands for, m2."""
    ring = body.bottom
    grid = np.empty((0, body.dimension))
    if isinstance(carrier, Face) and not isinstance(carrier.points, FixedPoints):
        low, sides = ring.min(axis=0)[:-1], np.ptp(ring, axis=0)[:-1]
        counts = [max(1, int(side / carrier.facet + 1e-9)) for side in sides]
        lines = [np.linspace(0, 1, count + 1) for count in counts]
        fractions = np.stack(np.meshgrid(*lines, indexing="ij"), -1).reshape(-1, len(sides))
        places = low + fractions * sides
        if body.dimension == 2:
            inside = (fractions[:, 0] > 0) & (fractions[:, 0] < 1)
        else:  # by half a facet: nearer ones are those of the corners
            inside = distance_inside(places, ring[:, :-1]) > 0.5 * carrier.facet
        grid = np.column_stack([places[inside], np.full(inside.sum(), ring[:, -1].mean())])
    points = np.vstack([body.corners, grid])
    area = body.shape.bottom_area / (len(ring) + len(grid))
    return points, np.full(len(points), area)


def outline_points(points: FacePoints, frame: Array, ring: Array | None = None) -> FacePoints:
    """Points of a face that lie on its outline: of what cannot bend, its corners.

    Args:
        points: Of the face.
        frame: Rows normal and tangents of the undeformed face.
        ring: Corners around it in space, (n, 3), m; None: it is a rectangle along the frame.
    """
    if isinstance(points, RigidPoints):
        return points
    along = points.reference @ frame[1:].T
    if ring is not None:
        assert isinstance(points, NodePoints)
        inside = np.abs(distance_inside(along, ring @ frame[1:].T))
        outline = np.flatnonzero(inside < 1e-9 * np.ptp(along, axis=0).max())
        return NodePoints(points.body, points.layer, points.reference, chosen=outline)
    near = 1e-9 * np.ptp(along, axis=0)
    low, high = along.min(axis=0) + near, along.max(axis=0) - near
    extreme = (along < low) | (along > high)
    if isinstance(points, FixedPoints):
        return FixedPoints(points.reference[np.all(extreme, axis=1)])
    outline = np.flatnonzero(np.any(extreme, axis=1))
    return NodePoints(points.body, points.layer, points.reference, chosen=outline)


def outline_of(face: Face, up: Array) -> Outline:
    """The edges of a face, anticlockwise as seen from where a unit normal points, (d,)."""
    frame = face.reference_frame
    if up @ frame[0] < 0:
        frame = np.array([-frame[0], frame[1], -frame[2]])
    points = outline_points(face.points, frame, face.ring)
    return Outline(points, face.degree, frame, face.ring)
