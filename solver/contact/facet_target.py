"""The facets of a body's face as what carries contact points of another one."""

from __future__ import annotations

import basix
import numpy as np

from solver.contact.body_points import FacePoints, SurfaceState
from solver.contact.foot_way import FootWay
from solver.contact.kernels.chain import EDGE_BLEND_WIDTH, feet_on_chain
from solver.contact.plane_target import FacetCarrier
from solver.contact.projection import ContactKinematics, Projection
from solver.types import Array, Indices, Mask

CAME_ROUND = 0.05
"""Part of the face's length: a point farther behind the face came there round its edge."""

FOOT_SETTLED = 1e-12
"""Part of a facet: Newton's method for a foot ends when it moves the foot by less; what is left is
the square of that."""

FOOT_ITERATIONS = 4
"""Corrections of Newton's method for a foot, at most."""

FACETS_TRIED = 4
"""Facets around a point, the nearest ones first, among which its foot is looked for."""


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
        self.points, self.facets, self.reference_frame = points, facets, frame
        self.degree = degree
        self.frame = frame
        kind = getattr(basix.CellType, cell)
        variant = basix.LagrangeVariant.gll_warped
        self._element = basix.create_element(basix.ElementFamily.P, kind, degree, variant)
        self._straight = cell == "interval" and degree == 1
        self._interval = cell == "interval"
        self._corners = basix.geometry(kind)
        self._chain = np.append(facets[:, 0], facets[-1, 1])
        self._along = points.reference @ frame[1:].T
        self._reference = self._along[self._chain, 0]
        chains = self._along[facets[:, : len(self._corners)]]
        table = self._element.tabulate(1, self._element.points)[1:, :, :, 0]
        self._gradient = np.ascontiguousarray(table)
        self._undeformed = np.linalg.inv(self._nodal_gradient(self._along))
        self._meeting = np.bincount(self.facets.ravel(), minlength=points.count)
        self.length = float(np.max(np.ptp(chains.reshape(-1, chains.shape[-1]), axis=0)))
        self.facet = float(np.min(np.max(np.ptp(chains, axis=1), axis=1)))

    def rotate_frame(self, rotation: Array) -> None:
        """Let the frame of the coming step be that of the turned body."""
        self.frame = self.reference_frame @ rotation.T

    def kinematics(self, position: Array, carrier: SurfaceState | None) -> ContactKinematics:
        """Gaps and tangential positions of points in space."""
        assert carrier is not None
        foot = self._foot(position @ self.frame[1:].T, carrier.position @ self.frame.T)
        gap = (position - foot.carried(carrier.position)) @ self.frame[0]
        return ContactKinematics(np.column_stack([gap, foot.along]), self.frame, carrier, foot)

    def _foot(self, along: Array, nodes: Array) -> Projection:
        """Feet of points with tangential positions (m, d-1) for nodes in the frame, (n, d)."""
        if self._straight:
            return self._foot_on_chain(along[:, 0], nodes)
        facet, where = self._nearest(along, nodes[:, 1:])
        where = self._inverted(facet, where, along, nodes[:, 1:])
        if not self._interval:
            lost = np.flatnonzero(self._outside(where))
            if len(lost):
                facet[lost], where[lost] = self._best_around(along[lost], nodes[:, 1:])
        at = self.facets[facet]
        shape, derivative = self._shapes(where)
        own = np.einsum("mk,mkd->md", shape, self._along[at])
        gradient = np.einsum("jmk,mkd->mdj", derivative, nodes[at])
        before = np.linalg.inv(np.einsum("jmk,mkd->mdj", derivative, self._along[at]))
        slope = (gradient[:, :1] @ np.linalg.inv(gradient[:, 1:]))[:, 0]
        stretch = gradient[:, 1:] @ before
        seam = np.clip(1 + self._miss(where) / EDGE_BLEND_WIDTH, 0.0, 1.0)
        near = np.flatnonzero(seam)
        if len(near):
            share, at_near, shape_near = seam[near], at[near], shape[near]
            for local, nodal in zip((slope, stretch), self._averages(nodes), strict=True):
                common = np.einsum("mk,mk...->m...", shape_near, nodal[at_near])
                local[near] += (share * (common - local[near]).T).T
        return Projection(at, shape, own, slope, stretch, self._outside(where))

    def _nodal_gradient(self, values: Array) -> Array:
        """Derivatives along facets' coordinates at their nodes, (facets, k, components, d-1)."""
        gradient: Array = np.einsum("jpk,fkd->fpdj", self._gradient, values[self.facets])
        return gradient

    def _averages(self, nodes: Array) -> tuple[Array, Array]:
        """Slope and stretch at the nodes, averaged over the facets that meet there."""
        gradient = self._nodal_gradient(nodes)
        current = gradient[:, :, 1:]
        slopes = (gradient[:, :, :1] @ np.linalg.inv(current))[:, :, 0]
        stretches = current @ self._undeformed
        averages = []
        for values in (slopes, stretches):
            total = np.zeros((self.points.count, *values.shape[2:]))
            np.add.at(total, self.facets, values)
            averages.append((total.T / np.maximum(self._meeting, 1)).T)
        return averages[0], averages[1]

    def _inverted(self, facet: Indices, where: Array, along: Array, nodes: Array) -> Array:
        """Coordinates of points on given facets, from a first guess (Newton's method)."""
        tangential = nodes[self.facets[facet]]
        for _ in range(FOOT_ITERATIONS):
            shape, derivative = self._shapes(where)
            miss = along - np.einsum("mk,mkd->md", shape, tangential)
            jacobian = np.einsum("jmk,mkd->mdj", derivative, tangential)
            change = np.linalg.solve(jacobian, miss[:, :, None])[:, :, 0]
            where = where + change
            if np.abs(change).max(initial=0.0) < FOOT_SETTLED:
                break
        return where

    def _best_around(self, along: Array, nodes: Array) -> tuple[Indices, Array]:
        """The best of the facets around points that are outside of the one that seemed nearest.

        Nearness is judged on facets taken as parallelograms; bent ones end elsewhere.
        """
        guess = self._as_parallelograms(along, nodes)
        rows = np.arange(len(along))
        nearest = np.argsort(self._miss(guess), axis=1)[:, :FACETS_TRIED]
        start = np.take_along_axis(guess, nearest[:, :, None], axis=1).reshape(nearest.size, -1)
        points = np.repeat(along, nearest.shape[1], axis=0)
        places = self._inverted(nearest.ravel(), start, points, nodes)
        places = places.reshape(*nearest.shape, -1)
        best = np.argmin(self._miss(places), axis=1)
        return nearest[rows, best], places[rows, best]

    def _foot_on_chain(self, along: Array, nodes: Array) -> Projection:
        """Feet on straight facets in the plane, in closed form."""
        feet = feet_on_chain(along, nodes[self._chain], self._reference, self.margin)
        at = self.facets[feet.facet]
        return Projection(at, feet.weights, feet.along, feet.slope, feet.stretch, feet.outside)

    def _shapes(self, where: Array) -> tuple[Array, Array]:
        """Shape functions (m, k) and their derivatives (d-1, m, k)."""
        table = self._element.tabulate(1, where)[:, :, :, 0]
        return table[0], table[1:]

    def _nearest(self, along: Array, nodes: Array) -> tuple[Indices, Array]:
        """The facet nearest to each point, and the point in the facet's own coordinates."""
        if self._interval:
            ends = nodes[:, 0][np.append(self.facets[:, 0], self.facets[-1, 1])]
            last = len(self.facets) - 1
            facet = np.clip(np.searchsorted(ends, along[:, 0], side="right") - 1, 0, last)
            start, end = ends[facet], ends[facet + 1]
            return facet, ((along[:, 0] - start) / (end - start))[:, None]
        where = self._as_parallelograms(along, nodes)
        facet = np.argmin(self._miss(where), axis=1)
        return facet, where[np.arange(len(along)), facet]

    def _as_parallelograms(self, along: Array, nodes: Array) -> Array:
        """Coordinates of all points on all facets, each taken as spanned by two of its edges."""
        origin = nodes[self.facets[:, 0]]
        edges = np.stack([nodes[self.facets[:, k]] - origin for k in (1, 2)], axis=2)
        inverse = np.linalg.inv(edges)
        coordinates: Array = np.einsum("fij,mfj->mfi", inverse, along[:, None, :] - origin[None])
        return coordinates

    def _miss(self, where: Array) -> Array:
        """How far points are outside of their facet, in its own coordinates."""
        low = np.max(-where, axis=-1)
        triangle = len(self._corners) == 3
        high = where.sum(axis=-1) - 1 if triangle else np.max(where - 1, axis=-1)
        return np.maximum(low, high)

    def _outside(self, where: Array) -> Mask:
        """Whether points are beyond the edge of the whole face: of the facet nearest to them."""
        return self._miss(where) > self.margin

    def vectors(self, old: ContactKinematics, new: ContactKinematics, force: Array) -> Array:
        """Point forces as vectors in space such that their work on increments is exact."""
        if not force.any():
            return np.zeros_like(force)
        return self._way(old, new).vectors(force) @ self.frame

    def _way(self, old: ContactKinematics, new: ContactKinematics) -> FootWay:
        """How the feet of points go over the mean surface of a step."""
        return FootWay.between(old, new, self.frame, self.facet)

    def work_defect(self, old: ContactKinematics, new: ContactKinematics, force: Array) -> float:
        """Work of the vectors of point forces less that of the forces on (g, s), J."""
        pressed = np.flatnonzero(force[:, 0] > 0)
        return self._way(old, new).work_defect(force, pressed) if len(pressed) else 0.0

    def came_round(self, kinematics: ContactKinematics) -> Mask:
        """Points so far behind the face that they can only have come there round its edge."""
        before: Mask = kinematics.place[:, 0] > -CAME_ROUND * self.length
        return ~before

    def beyond_edge(self, kinematics: ContactKinematics) -> Mask | None:
        """Points beyond the edge of the face."""
        assert isinstance(kinematics.foot, Projection)
        return kinematics.foot.beyond_edge
