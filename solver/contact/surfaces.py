"""What a body offers to contact: its hull, its faces as carriers, and its points over a carrier."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from dolfinx import mesh

from geometry.body_faces import BodyFaces
from geometry.foundation import face_frame
from geometry.tags import FacetTag
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
from solver.contact.edge_crossings import Outline, distance_inside, distance_to_edges
from solver.contact.facets import carrier_surface, extent, shared_layer
from solver.contact.hull import Hull
from solver.contact.interface import Interface
from solver.contact.nitsche_points import contact_points
from solver.scene import Bed, ContactSpec, FrictionSpec
from solver.types import Array


class BlockSurface:
    """The surface of a block, elastic or rigid: that of its convex hull, or of a convex part.

    Attributes:
        body: The block.
        number: Its number in the system.
        hull: Its hull; the faces are numbered as in `tags`.
        tags: Tags of its faces.
        top: Number of the top among them.
        below: Numbers of the corners of the bottom farthest out, (2 or 4,), in the hull's points.
    """

    def __init__(
        self,
        body: ElasticBody | RigidBox,
        number: int,
        faces: BodyFaces,
        contact: ContactSpec,
        facet_tags: mesh.MeshTags | None = None,
        *,
        ends: Array,
    ):
        """Take the block, its faces in the undeformed body, and the tags of its facets.

        `ends` are the corners of the bottom farthest out there, (2 or 4, d), m.
        """
        self.body, self.number, self._contact = body, number, contact
        self._facet_tags, self._faces = facet_tags, faces
        self.dimension = body.dimension
        self.thickness = body.shape.thickness if isinstance(body, RigidBox) else body.thickness
        self.tags = tuple(faces.loops)
        self.top = self.tags.index(int(FacetTag.TOP))
        self.below = np.abs(ends[:, None] - faces.corners).max(axis=2).argmin(axis=1)
        points: FacePoints
        if isinstance(body, ElasticBody):
            points = nodes_at(body, faces.corners)
        else:
            points = RigidPoints(body, faces.corners)
        loops = [faces.loops[tag] for tag in self.tags]
        self.hull = Hull(points, loops, is_whole=faces.is_whole)
        upright = self.hull.placed(np.zeros(body.size)).normals
        upright = np.round(upright, 12) + 0.0
        upright /= np.linalg.norm(upright, axis=1)[:, None]
        self._frames = {tag: face_frame(upright[k]) for k, tag in enumerate(self.tags)}

    def is_real(self, tag: int) -> bool:
        """True if the body has some of a face, which else spans a hollow."""
        return bool(self._faces.facets[tag])

    def touching(self, faces: Iterable[int]) -> frozenset[int]:
        """Tags of the facets whose points touch with some faces."""
        return frozenset().union(*(self._faces.points[tag] for tag in faces))

    def facets_towards(self, direction: Array) -> frozenset[int]:
        """Tags of the facets of the face that looks most in a direction of the undeformed body."""
        tag = max(self.tags, key=lambda tag: float(self._frames[tag][0] @ direction))
        return self._faces.facets[tag]

    def face(self, tag: int, margin: float) -> Face | None:
        """A face as a carrier, which carries what is beyond its edge by a part of a facet.

        None where it spans a hollow and carries nothing.
        """
        if not self.is_real(tag):
            return None
        frame, faces = self._frames[tag], self._faces
        if isinstance(self.body, RigidBox):
            return self._rigid_face(faces.patches[tag], frame, margin)
        assert self._facet_tags is not None
        surface = carrier_surface(self.body.space, self._facet_tags, *faces.facets[tag])
        return Face.of_mesh(self.body, surface, frame, margin)

    def _rigid_face(self, patches: tuple[Array, ...], frame: Array, margin: float) -> Face:
        """Where a rigid body has a face: sides, in space triangles, of a box a rectangle."""
        assert isinstance(self.body, RigidBox)
        if self.dimension == 2:
            sides = [ring[np.argsort(ring @ frame[1])] for ring in patches]
            sides.sort(key=lambda side: float(side[0] @ frame[1]))
            points = RigidPoints(self.body, np.concatenate(sides))
            facets = np.arange(2 * len(sides)).reshape(-1, 2)
            return Face(points, facets, frame, "interval", 1, margin, patches)
        points = RigidPoints(self.body, np.concatenate(patches))
        if self.body.shape.solid is None:
            corners = np.array([[0, 1, 3, 2]])  # as basix counts them
            return Face(points, corners, frame, "quadrilateral", 1, margin, patches)
        fans, first = list[list[int]](), 0
        for ring in patches:
            fans += [[first, first + k, first + k + 1] for k in range(1, len(ring) - 1)]
            first += len(ring)
        return Face(points, np.array(fans), frame, "triangle", 1, margin, patches)

    def corners_of(self, tag: int) -> FacePoints:
        """The corners of a face."""
        return self.hull.points.some(np.array(self._faces.loops[tag]))

    def over(
        self,
        carrier: Carrier,
        law: FrictionSpec,
        faces: frozenset[int],
        *,
        shared: frozenset[int] = frozenset(),
        bed: Bed | None = None,
    ) -> Interface:
        """The interface of the points of some facets, by their tags, with a carrier; collective.

        The theta term of facets that are `shared` stands in another interface. A rigid block has
        all its points in it.
        """
        if isinstance(self.body, RigidBox):
            points = RigidPoints(self.body, *self._rigid_points(carrier))
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

    def _rigid_points(self, carrier: Carrier) -> tuple[Array, Array]:
        """Points of a rigid block that may touch, and the area that each stands for, m2."""
        assert isinstance(self.body, RigidBox)
        facet = np.inf
        if isinstance(carrier, Face) and not isinstance(carrier.points, FixedPoints):
            facet = carrier.facet  # of what deforms
        if self.body.shape.solid is None:
            return rigid_points(self.body, facet)
        return points_of_shape(self.body, self._faces, facet)


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
    return NodePoints(body, layer, where).some(rank)


def rigid_points(body: RigidBox, facet: float) -> tuple[Array, Array]:
    """Points of a rigid box that may touch, and the area of the bottom that each stands for, m2.

    They are its corners, on facets that deform also a grid on its bottom, no closer than these, m
    (infinite on others): forces of more points than there are nodes below are not unique. Those of
    the top stand for as much as those of the bottom: they touch where the block lies on its back.
    """
    sides = np.ptp(body.bottom, axis=0)[:-1]
    fractions, cell = _grid(sides, facet)
    inner = (fractions > 0) & (fractions < 1)
    cell *= body.shape.thickness if body.dimension == 2 else 1.0
    area = cell * np.prod(np.where(inner, 1.0, 0.5), axis=1)
    between = inner.any(axis=1)
    upwards = np.zeros((np.count_nonzero(between), 1))
    grid = body.corners[0] + np.hstack([fractions[between] * sides, upwards])
    corners = np.full(len(body.corners), cell / 2 ** len(sides))
    return np.vstack([body.corners, grid]), np.concatenate([corners, area[between]])


def points_of_shape(body: RigidBox, faces: BodyFaces, facet: float) -> tuple[Array, Array]:
    """Points of a rigid block that is no box, as of `rigid_points`, and the area of each, m2.

    All stand for the same area, that of the bottom over the number of them there.
    """
    places, count = [faces.corners], 0
    for ring in faces.patches[int(FacetTag.BOTTOM)]:
        count += len(ring)
        far = np.abs(ring[:, None] - faces.corners).max(axis=2).min(axis=1)
        places.append(ring[far > 1e-9 * np.ptp(faces.corners)])  # corners within the hull
        places.append(_grid_on(ring, facet))
        count += len(places[-1])
    points = np.vstack(places)
    area = body.shape.bottom_area / max(count, 1)
    return points, np.full(len(points), area)


def _grid(sides: Array, facet: float) -> tuple[Array, float]:
    """A grid on a rectangle, over its sides, (n, t), no closer than facets, m; size of its cells.

    With the corners of the rectangle.
    """
    counts = [max(1, int(side / facet + 1e-9)) for side in sides]
    lines = [np.linspace(0, 1, count + 1) for count in counts]
    fractions = np.stack(np.meshgrid(*lines, indexing="ij"), -1).reshape(-1, len(sides))
    return fractions, float(np.prod(sides / counts))


def _grid_on(ring: Array, facet: float) -> Array:
    """Points on a level face of these corners, (n, d), m, no closer than facets, m."""
    low, sides = ring.min(axis=0)[:-1], np.ptp(ring, axis=0)[:-1]
    fractions, _ = _grid(sides, facet)
    places = low + fractions * sides
    if ring.shape[1] == 2:
        inside = (fractions[:, 0] > 0) & (fractions[:, 0] < 1)
    else:  # by half a facet: nearer ones are those of the corners
        inside = distance_inside(places, ring[:, :-1]) > 0.5 * facet
    return np.column_stack([places[inside], np.full(inside.sum(), ring[:, -1].mean())])


def outline_points(face: Face) -> FacePoints:
    """Points of a face that lie on its outline: of what cannot bend, its corners."""
    if not isinstance(face.points, NodePoints):
        return face.points
    tangents = face.reference_frame[1:].T
    along = face.points.reference @ tangents
    near = 1e-9 * np.ptp(along, axis=0).max()
    off = np.min([distance_to_edges(along, ring @ tangents) for ring in face.rings], axis=0)
    return face.points.some(np.flatnonzero(off < near))


def outline_of(face: Face, up: Array) -> Outline:
    """The edges of a face, anticlockwise as seen from where a unit normal points, (d,)."""
    frame = face.reference_frame
    if up @ frame[0] < 0:
        frame = np.array([-frame[0], frame[1], -frame[2]])
    return Outline(outline_points(face), face.degree, frame, face.rings)
