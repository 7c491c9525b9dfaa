"""Kinematics of contact points over their carrier, at one instant and over a step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from solver.contact.body_points import SurfaceState
from solver.kernels import meshed
from solver.types import Array, Indices, Mask


@dataclass(slots=True, eq=False)
class Interpolation:
    """Places between the nodes of a surface.

    Attributes:
        nodes: Nodes around each place, (m, k).
        weights: Shape functions N there, (m, k).
    """

    nodes: Indices
    weights: Array

    def carried(self, values: Array) -> Array:
        """N x: what nodal values x, (n, d), are at the places, (m, d)."""
        found = np.empty((len(self.nodes), values.shape[1]))
        meshed.interpolated(self.nodes, self.weights, values, found)
        return found


@dataclass(slots=True, eq=False)
class ClosestPoints(Interpolation):
    """Closest points of m points on the facets of a face, by the nodes of these; t = d - 1.

    Attributes:
        slope: Rise of the face along the tangents of the frame, (m, t); blended with that of the
            next facet where facets meet, so that it is continuous.
        stretch: Current over undeformed tangential lengths, likewise, (m, t, t).
        beyond_edge: Points beyond the edge of the face by more than its margin, (m,).
    """

    slope: Array
    stretch: Array
    beyond_edge: Mask


@dataclass(slots=True, eq=False)
class EdgeInterpolation(Interpolation):
    """Places on the edges of a face.

    Attributes:
        segment: Number of the segment, (m,).
        where: Place on it, 0 to 1, (m,).
        position: Where the nodes are, (n, 3), m.
    """

    segment: Indices
    where: Array
    position: Array

    def at(self, position: Array) -> EdgeInterpolation:
        """These places between nodes that are elsewhere, (n, 3), m."""
        return EdgeInterpolation(self.nodes, self.weights, self.segment, self.where, position)


class ContactKinematics(NamedTuple):
    """Gaps and tangential positions of points over a carrier at one instant.

    A carrier has no tractions: it gives augmented positions without them, and the interface
    takes those off.
    """

    place: Array
    """(g, s), (m, d), m."""
    augmented: Array
    """y = (g, s) - T/gamma_h, (m, d), m; (g, s) itself where points have no tractions."""
    frame: Array
    """Rows normal and tangents that they are given in: one for all points, (d, d), or one for each
    of them, (m, d, d)."""
    carrier: SurfaceState | None = None
    """Positions of the carrier's own points; None for the ground."""
    projection: ClosestPoints | EdgeInterpolation | None = None
    """Closest points on the carrier; None on a plane."""
    own_projection: EdgeInterpolation | None = None
    """Places between nodes of their own body; None where they are those nodes."""


def spread(first: Interpolation, last: Interpolation, vectors: Array, count: int) -> Array:
    """Forces at places as forces on the nodes (count, d): half at each of two instants."""
    target = np.zeros((count, vectors.shape[1]))
    for places in (first, last):
        meshed.add_spread(places.nodes, places.weights, 0.5, vectors, target)
    return target


def in_frames(vectors: Array, frames: Array) -> Array:
    """Components of vectors in space (m, d) in one frame (d, d), or in one for each, (m, d, d)."""
    if frames.ndim == 2:
        return vectors.dot(frames.T)  # `@` takes three times as long for so few numbers
    return (frames @ vectors[:, :, None])[:, :, 0]


def in_space(components: Array, frames: Array) -> Array:
    """Vectors in space of components (m, d) in one frame (d, d), or in one for each, (m, d, d)."""
    if frames.ndim == 2:
        return components.dot(frames)
    return (components[:, None, :] @ frames)[:, 0]


Observed = tuple[SurfaceState, ContactKinematics]
"""An interface at one instant: its points, and where they are over their carrier."""

Parts = tuple[Array | None, Array | None]
"""Owned unknowns of the body of the points and of its carrier, or forces on them; None for the
ground."""


class ContactIncrement(NamedTuple):
    """An interface over a step, or over an iteration of it.

    Attributes:
        before: The interface at t_n, in the frame of the step.
        after: At t_{n+1}.
        force: Point forces f at t_{n+1}, (points, d), N.
    """

    before: Observed
    after: Observed
    force: Array


class ForceWeights(NamedTuple):
    """Weights of the forces of an interface, with their sign.

    Attributes:
        points: Point forces: w_c.
        old: Tractions at t_n, in the theta term of Nitsche's method, int (theta/gamma_h) T.DT[v]:
            alpha_f, or 0 to leave the term out.
        new: Those at t_{n+1}: 1 - alpha_f, or 0.
    """

    points: float
    old: float
    new: float

    @classmethod
    def of(cls, contact: float, traction: float, sign: float) -> ForceWeights:
        """Weights by w_c and 1 - alpha_f, which is 0 to leave the theta term out.

        The sign is 1, or -1 to subtract all forces.
        """
        old = sign * (1.0 - traction) if traction else 0.0
        return cls(sign * contact, old, sign * traction)
