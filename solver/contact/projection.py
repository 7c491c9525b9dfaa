"""Where contact points stand on what carries them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from solver.contact.body_points import SurfaceState
from solver.types import Array, Indices, Mask


@dataclass(frozen=True, slots=True)
class Interpolation:
    """Places between the nodes of a surface."""

    nodes: Indices
    """Nodes around each place, (m, k)."""
    weights: Array
    """Shape functions N there, (m, k)."""

    def carried(self, values: Array) -> Array:
        """N x: what nodal values x, (n, d), are at the places, (m, d)."""
        return (self.weights[:, None, :] @ values[self.nodes])[:, 0]


@dataclass(frozen=True, slots=True)
class Projection(Interpolation):
    """Where points stand on the facets of a face: their feet."""

    along: Array
    """Tangential position s in the undeformed face, (m, d-1), m."""
    slope: Array
    """Rise of the face along the tangents of the frame, (m, d-1); blended with that of the next
    facet where facets meet, so that it is continuous."""
    stretch: Array
    """Current over undeformed tangential lengths, likewise, (m, d-1, d-1)."""
    beyond_edge: Mask
    """Feet beyond the edge of the face, (m,)."""


@dataclass(frozen=True, slots=True)
class EdgeInterpolation(Interpolation):
    """Places on the edges of a face."""

    segment: Indices
    """Number of the segment, (m,)."""
    where: Array
    """Place on it, 0 to 1, (m,)."""
    position: Array
    """Where the nodes are, (n, 3), m."""


class ContactKinematics(NamedTuple):
    """Gaps and tangential positions of points over a carrier at one instant."""

    place: Array
    """(g, s), (m, d), m."""
    frame: Array
    """Rows normal and tangents that they are given in: one for all points, (d, d), or one for each
    of them, (m, d, d)."""
    carrier: SurfaceState | None = None
    """Where the carrier's own points are; None for the ground."""
    foot: Projection | EdgeInterpolation | None = None
    """Where the points stand; None on a plane."""
    own_projection: EdgeInterpolation | None = None
    """Where they are among the nodes of their own body; None where they are those nodes."""


def spread(first: Interpolation, last: Interpolation, vectors: Array, count: int) -> Array:
    """Forces at places as forces on the nodes (count, d): half at each of two instants."""
    target = np.zeros((count, vectors.shape[1]))
    pressed = np.flatnonzero(vectors.any(axis=1))
    for places in (first, last):
        share = 0.5 * places.weights[pressed, :, None] * vectors[pressed, None, :]
        np.add.at(target, places.nodes[pressed], share)
    return target


def in_frames(vectors: Array, frames: Array) -> Array:
    """Components of vectors in space (m, d) in one frame (d, d), or in one for each, (m, d, d)."""
    if frames.ndim == 2:
        return vectors @ frames.T
    return (frames @ vectors[:, :, None])[:, :, 0]


def in_space(components: Array, frames: Array) -> Array:
    """Vectors in space of components (m, d) in one frame (d, d), or in one for each, (m, d, d)."""
    if frames.ndim == 2:
        return components @ frames
    return (components[:, None, :] @ frames)[:, 0]
