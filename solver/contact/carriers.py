"""Surfaces that carry contact points: the protocol, an endless plane, and a face of facets.

For points in space a carrier gives the gap g along the normal of the step's frame and the
tangential position s, in the coordinates of its own material, so that the stick memory travels with
it. The frame of a step stands in the kinematics; a carrier itself never changes. The increments of
g and s between two instants are products of its rows with increments of position, exactly: that is
what makes the work of contact forces a difference of states.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import basix
import numpy as np

from geometry.foundation import level_frame
from solver.bodies.elastic_body import ElasticBody
from solver.bodies.reduced_body import ReducedBody
from solver.contact.body_points import (
    FacePoints,
    FixedPoints,
    NodePoints,
    RigidPoints,
    SurfaceState,
)
from solver.contact.facets import Facets, outlines
from solver.contact.kinematics import (
    ClosestPoints,
    ContactKinematics,
    in_frames,
    in_space,
    spread,
)
from solver.kernels import meshed
from solver.types import Array, Indices, Mask


class Carrier(Protocol):
    """A surface that carries contact points."""

    turns: bool
    """True if its frame turns with its body."""

    @property
    def points(self) -> FacePoints | None:
        """The carrier's own points, on which forces act; None for the ground."""

    @property
    def reference_frame(self) -> Array:
        """Rows normal and tangents of the undeformed carrier, (d, d)."""

    def frame(self, rotation: Array) -> Array:
        """Rows normal and tangents where its body has turned, (d, d)."""

    def kinematics(
        self, position: Array, carrier: SurfaceState | None, frame: Array
    ) -> ContactKinematics:
        """Gaps and tangential positions of points in space, in a frame of the carrier."""

    def vectors(self, old: ContactKinematics, new: ContactKinematics, force: Array) -> Array:
        """Point forces (normal, tangential) as vectors in space, whose work is exact."""

    def work_defect(self, old: ContactKinematics, new: ContactKinematics, force: Array) -> float:
        """Work of these vectors less that of the forces on (g, s), where it is not exact, J."""

    def reaction(
        self, old: ContactKinematics, new: ContactKinematics, vectors: Array
    ) -> Array | None:
        """Forces on the carrier's own points."""

    def carried(self, kinematics: ContactKinematics, values: Array) -> Array:
        """Vectors of the carrier's points, interpolated at the contact points; (1, d) on planes."""

    def beyond_edge(self, kinematics: ContactKinematics) -> Mask | None:
        """Points beyond the edge of the carrier; None where it has none."""


class Plane:
    """An endless plane that does not turn: the ground's, or that of a rigid platform.

    Attributes:
        reference_frame: Rows normal and tangents, (d, d).
        origin: A point of it, m.
        points: One point of the platform that it belongs to; None for the ground.
    """

    turns = False

    def __init__(self, frame: Array, origin: Array, platform: RigidPoints | None = None):
        """Take rows normal and tangents, (d, d), a point of the plane, m, and one of a platform."""
        self.reference_frame: Array = np.ascontiguousarray(frame)
        self.origin, self.points = origin, platform

    @classmethod
    def level(cls, dimension: int, platform: RigidPoints | None = None) -> Plane:
        """The horizontal plane at level 0."""
        return cls(level_frame(dimension), np.zeros(dimension), platform)

    def frame(self, rotation: Array) -> Array:
        """Rows normal and tangents, (d, d), which do not turn."""
        return self.reference_frame

    def kinematics(
        self, position: Array, carrier: SurfaceState | None, frame: Array
    ) -> ContactKinematics:
        """Gaps and tangential positions of points in space, in a frame of the carrier."""
        origin = self.origin if carrier is None else self.origin + carrier.position[0]
        place = in_frames(position - origin, frame)
        return ContactKinematics(place, place, frame, carrier)

    def vectors(self, old: ContactKinematics, new: ContactKinematics, force: Array) -> Array:
        """Point forces (normal, tangential) as vectors in space, whose work is exact."""
        return in_space(force, new.frame)

    def work_defect(self, old: ContactKinematics, new: ContactKinematics, force: Array) -> float:
        """Zero: the work of the vectors is exact."""
        return 0.0

    def beyond_edge(self, kinematics: ContactKinematics) -> Mask | None:
        """None: it has no edge."""
        return None

    def reaction(
        self, old: ContactKinematics, new: ContactKinematics, vectors: Array
    ) -> Array | None:
        """Forces on the carrier's own points; None for the ground."""
        return None if self.points is None else -vectors.sum(axis=0)[None, :]

    def carried(self, kinematics: ContactKinematics, values: Array) -> Array:
        """Vectors of the carrier's point, the same for all contact points, (1, d)."""
        return values[:1]


class FacetCarrier:
    """A carrier that is part of a mesh, whose nodes take what presses on it."""

    turns = True
    points: FacePoints
    """Its nodes."""

    def reaction(
        self, old: ContactKinematics, new: ContactKinematics, vectors: Array
    ) -> Array | None:
        """Forces on the nodes: half at the places before, half at those after.

        None where nothing presses, or all of it on what is fixed.
        """
        if not (self.turns and vectors.any()):
            return None
        assert old.projection is not None and new.projection is not None
        return spread(old.projection, new.projection, -vectors, self.points.count)

    def carried(self, kinematics: ContactKinematics, values: Array) -> Array:
        """Vectors of the nodes, interpolated at the contact points."""
        assert kinematics.projection is not None
        return kinematics.projection.carried(values)


class FacetShapes(NamedTuple):
    """Shape functions of the facets of a face; t = d - 1 coordinates on each."""

    facets: Indices
    """Nodes of each facet, (facets, k)."""
    powers: Indices
    """Powers of the coordinates in the monomials of a shape function, (k, t)."""
    factors: Array
    """Factors of these monomials in each shape function, (k, k)."""
    derivatives: Array
    """Derivatives of the shape functions at a facet's own nodes, (k, t, k)."""
    undeformed: Array
    """Inverses of the derivatives of undeformed tangential positions at each facet's nodes,
    (facets, k, t, t), 1/m."""
    meeting: Indices
    """Facets that meet at nodes, and which of a facet's nodes that is, node after node, (.., 2)."""
    first: Indices
    """Number of the first of them at each node, and of all, (n + 1,)."""
    along: Array
    """Tangential positions of the nodes in the undeformed face, (n, t), m."""
    corners: int
    """Number of corners of a facet: 2 for intervals, 3 for triangles, 4 for quadrilaterals."""
    margin: float
    """Part of a facet by which points may be beyond its edge."""


FootPointArrays = tuple[Indices, Array, Array, Array, Array, Array]
"""Foot points on a face at one instant: nodes, weights, slope and stretch as in `ClosestPoints`,
places (g, s), (m, d), m, and positions of the nodes of the face, (n, d), m."""

CAME_ROUND = 0.05
"""Part of the face's length: a point farther behind the face came there round its edge."""


class Face(FacetCarrier):
    """Facets of a body that can carry points of another one.

    Attributes:
        points: The nodes of the face.
        facets: Nodes of each facet, (facets, k).
        reference_frame: Rows normal and tangents of the undeformed face, (d, d).
        degree: Polynomial degree on a facet.
        margin: Part of a facet by which points may be beyond its edge.
        rings: Corners around the pieces of the face, (n, d), m, anticlockwise from outside, in the
            undeformed body, in the plane their ends; none of a face that touches nothing with them.
        length: Of the longest side of the face, m.
        facet: Length of its smallest facet, m.
    """

    def __init__(
        self,
        points: FacePoints,
        facets: Indices,
        frame: Array,
        cell: str,
        degree: int = 1,
        margin: float = 1e-9,
        rings: Sequence[Array] = (),
    ):
        """Take the nodes of the face and of each facet, (facets, k), in the plane in their order.

        The frame has rows normal and tangents of the undeformed face. A cell is an "interval",
        "triangle" or "quadrilateral". Points may be beyond an edge by the margin, a part of a
        facet; negative: must be inside.
        """
        self.margin, self.rings = margin, tuple(rings)
        if cell == "interval" and degree == 2:
            facets = facets[:, [0, 2, 1]]  # as basix counts them: ends first
        frame = np.ascontiguousarray(frame)
        self.points, self.facets, self.degree = points, facets, degree
        self.turns = not isinstance(points, FixedPoints)
        self.reference_frame = frame
        along = points.reference @ frame[1:].T
        kind = getattr(basix.CellType, cell)
        corners = len(basix.geometry(kind))
        self._shapes = facet_shapes(facets, kind, degree, along, margin)
        chains = along[facets[:, :corners]]
        self.length = float(np.max(np.ptp(chains.reshape(-1, chains.shape[-1]), axis=0)))
        self.facet = float(np.min(np.max(np.ptp(chains, axis=1), axis=1)))

    @classmethod
    def of_mesh(
        cls, body: ElasticBody | ReducedBody, surface: Facets, frame: Array, margin: float = 1e-9
    ) -> Face:
        """A face of a meshed body by its facets; frame and margin as above."""
        nodes, rings = NodePoints(body, surface.layer, surface.positions), outlines(surface)
        return cls(nodes, surface.nodes, frame, surface.cell, surface.degree, margin, rings)

    def frame(self, rotation: Array) -> Array:
        """Rows normal and tangents where its body has turned, (d, d)."""
        return np.asarray(self.reference_frame @ rotation.T) if self.turns else self.reference_frame

    def kinematics(
        self, position: Array, carrier: SurfaceState | None, frame: Array
    ) -> ContactKinematics:
        """Gaps and tangential positions of points in space, in a frame of the carrier."""
        assert carrier is not None
        (count, d), k = position.shape, self.facets.shape[1]
        nodes, weights = np.empty((count, k), dtype=np.int64), np.empty((count, k))
        slope, stretch = np.empty((count, d - 1)), np.empty((count, d - 1, d - 1))
        closest = nodes, weights, slope, stretch, np.empty(count, dtype=np.bool_)
        place = np.empty((count, d))
        meshed.project_onto_facets(
            *self._shapes, position, carrier.position, frame, place, *closest
        )
        return ContactKinematics(place, place, frame, carrier, ClosestPoints(*closest))

    def vectors(self, old: ContactKinematics, new: ContactKinematics, force: Array) -> Array:
        """Point forces as vectors in space such that their work on increments is exact."""
        vectors = np.empty(force.shape)
        before, after = foot_point_arrays(old), foot_point_arrays(new)
        meshed.forces_in_space(*before, *after, new.frame, self.facet, force, vectors)
        return vectors

    def work_defect(self, old: ContactKinematics, new: ContactKinematics, force: Array) -> float:
        """Work of the vectors of point forces less that of the forces on (g, s), J."""
        before, after = foot_point_arrays(old), foot_point_arrays(new)
        return meshed.work_defect(*before, *after, new.frame, self.facet, force)

    def can_touch(self, kinematics: ContactKinematics) -> Mask:
        """Points not so far behind the face that they can only have come there round its edge."""
        mask: Mask = kinematics.place[:, 0] > -CAME_ROUND * self.length
        return mask

    def beyond_edge(self, kinematics: ContactKinematics) -> Mask | None:
        """Points beyond the edge of the face."""
        assert isinstance(kinematics.projection, ClosestPoints)
        return kinematics.projection.beyond_edge


def foot_point_arrays(kinematics: ContactKinematics) -> FootPointArrays:
    """Foot points on a face at one instant."""
    closest, carrier = kinematics.projection, kinematics.carrier
    assert isinstance(closest, ClosestPoints) and carrier is not None
    surface = closest.nodes, closest.weights, closest.slope, closest.stretch
    return *surface, kinematics.place, carrier.position


def facet_shapes(
    facets: Indices, cell: basix.CellType, degree: int, along: Array, margin: float
) -> FacetShapes:
    """The shape functions of facets as sums of monomials, and what else stays the same of a face.

    Args:
        facets: Nodes of each, (facets, k).
        cell: Their shape.
        degree: Polynomial degree.
        along: Tangential positions of the nodes in the undeformed face, (n, d-1), m.
        margin: Part of a facet by which points may be beyond its edge.
    """
    variant = basix.LagrangeVariant.gll_warped
    element = basix.create_element(basix.ElementFamily.P, cell, degree, variant)
    places = element.points
    counts = np.indices((degree + 1,) * places.shape[1]).reshape(places.shape[1], -1).T
    if cell == basix.CellType.triangle:
        counts = counts[counts.sum(axis=1) <= degree]
    monomials = np.prod(places[:, None, :] ** counts, axis=2)  # at the nodes
    derivatives = np.ascontiguousarray(np.moveaxis(element.tabulate(1, places)[1:, :, :, 0], 1, 0))
    gradients = np.einsum("cjk,fki->fcij", derivatives, along[facets])
    order = np.argsort(facets.ravel(), kind="stable")
    first = np.cumsum([0, *np.bincount(facets.ravel(), minlength=len(along))])
    return FacetShapes(
        facets=np.ascontiguousarray(facets, dtype=np.int64),
        powers=np.ascontiguousarray(counts, dtype=np.int64),
        factors=np.ascontiguousarray(np.linalg.inv(monomials).T),
        derivatives=derivatives,
        undeformed=np.ascontiguousarray(np.linalg.inv(gradients)),
        meeting=np.ascontiguousarray(np.stack(np.divmod(order, facets.shape[1]), axis=1)),
        first=first,
        along=np.ascontiguousarray(along),
        corners=len(basix.geometry(cell)),
        margin=margin,
    )
