"""The facets of a body's face as what carries contact points of another one."""

from __future__ import annotations

import basix
import numpy as np

from solver.contact.body_points import FacePoints, FixedPoints, SurfaceState
from solver.contact.kernels.facets import Feet, stand_on_facets
from solver.contact.kernels.shapes import FacetShapes
from solver.contact.kernels.way import StandArrays, forces_in_space, work_defect
from solver.contact.plane_target import FacetCarrier
from solver.contact.projection import ContactKinematics, Projection
from solver.types import Array, Indices, Mask

CAME_ROUND = 0.05
"""Part of the face's length: a point farther behind the face came there round its edge."""


class Face(FacetCarrier):
    """Facets of a body that can carry points of another one.

    Attributes:
        points: The nodes of the face.
        facets: Nodes of each facet, (facets, k).
        frame: Rows normal and tangents of the coming step, (d, d).
        reference_frame: Those of the undeformed face.
        degree: Polynomial degree on a facet.
        margin: Part of a facet by which points may be beyond its edge.
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
    ):
        """Take the nodes of the face and of each facet, (facets, k), in the plane in their order.

        The frame has rows normal and tangents of the undeformed face. A cell is an "interval",
        "triangle" or "quadrilateral". Points may be beyond an edge by the margin, a part of a
        facet; negative: must be inside.
        """
        self.margin = margin
        if cell == "interval" and degree == 2:
            facets = facets[:, [0, 2, 1]]  # as basix counts them: ends first
        frame = np.ascontiguousarray(frame)
        self.points, self.facets, self.degree = points, facets, degree
        self.turns = not isinstance(points, FixedPoints)
        self.reference_frame = self.frame = frame
        along = points.reference @ frame[1:].T
        kind = getattr(basix.CellType, cell)
        corners = len(basix.geometry(kind))
        self._shapes = facet_shapes(facets, kind, degree, along, margin)
        n, t = along.shape
        self._room = np.empty((n, t + 1)), np.empty((len(facets), t, t))
        chains = along[facets[:, :corners]]
        self.length = float(np.max(np.ptp(chains.reshape(-1, chains.shape[-1]), axis=0)))
        self.facet = float(np.min(np.max(np.ptp(chains, axis=1), axis=1)))

    def rotate_frame(self, rotation: Array) -> None:
        """Let the frame of the coming step be that of the turned body."""
        self.frame = self.reference_frame @ rotation.T

    def kinematics(self, position: Array, carrier: SurfaceState | None) -> ContactKinematics:
        """Gaps and tangential positions of points in space."""
        assert carrier is not None
        (count, d), k = position.shape, self.facets.shape[1]
        feet = Feet(
            nodes=np.empty((count, k), dtype=np.int64),
            weights=np.empty((count, k)),
            slope=np.empty((count, d - 1)),
            stretch=np.empty((count, d - 1, d - 1)),
            beyond_edge=np.empty(count, dtype=np.bool_),
        )
        place = np.empty((count, d))
        where = position, carrier.position, self.frame
        stand_on_facets(tuple(self._shapes), self._room, *where, place, tuple(feet))
        return ContactKinematics(place, place, self.frame, carrier, Projection(feet))

    def vectors(self, old: ContactKinematics, new: ContactKinematics, force: Array) -> Array:
        """Point forces as vectors in space such that their work on increments is exact."""
        vectors = np.empty(force.shape)
        stands = stand_arrays(old), stand_arrays(new)
        forces_in_space(*stands, self.frame, self.facet, force, vectors)
        return vectors

    def work_defect(self, old: ContactKinematics, new: ContactKinematics, force: Array) -> float:
        """Work of the vectors of point forces less that of the forces on (g, s), J."""
        return work_defect(stand_arrays(old), stand_arrays(new), self.frame, self.facet, force)

    def can_touch(self, kinematics: ContactKinematics) -> Mask:
        """Points not so far behind the face that they can only have come there round its edge."""
        mask: Mask = kinematics.place[:, 0] > -CAME_ROUND * self.length
        return mask

    def beyond_edge(self, kinematics: ContactKinematics) -> Mask | None:
        """Points beyond the edge of the face."""
        assert isinstance(kinematics.foot, Projection)
        return kinematics.foot.beyond_edge


def stand_arrays(kinematics: ContactKinematics) -> StandArrays:
    """Where points stand on a face, as arrays."""
    assert isinstance(kinematics.foot, Projection) and kinematics.carrier is not None
    return *kinematics.foot.feet[:4], kinematics.place, kinematics.carrier.position


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
