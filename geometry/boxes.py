"""Boxes in the plane and in space: how deep two of them are in one another."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from solver.types import Array, Indices

PARALLEL = 1e-6
"""Sine of the angle between two edges below which their normal is one of a face already."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Boxes:
    """A box as it stands at several instants."""

    half: Array
    """Half its edges, (d,), m."""
    centres: Array
    """Its centre, (n, d), m."""
    frames: Array
    """Its axes as the columns of rotation matrices, (n, d, d)."""

    def reach(self, axes: Array) -> Array:
        """Half its extent along unit vectors (n, axes, d), (n, axes), m."""
        return np.asarray(np.abs(axes @ self.frames) @ self.half)

    def at(self, chosen: Indices) -> Boxes:
        """The box at some of the instants."""
        return Boxes(half=self.half, centres=self.centres[chosen], frames=self.frames[chosen])


def overlap_depth(first: Boxes, second: Boxes) -> Array:
    """Distance by which two boxes overlap, (n,), m; negative or 0 where they are apart.

    By the separating axis theorem: the least overlap along the normals of the faces of both and, in
    space, of all pairs of an edge of the one and an edge of the other (Gottschalk et al. 1996).
    """
    axes = np.concatenate([np.swapaxes(box.frames, 1, 2) for box in (first, second)], axis=1)
    if len(first.half) == 3:
        axes = np.concatenate([axes, _edge_normals(first.frames, second.frames)], axis=1)
    between = np.abs(np.einsum("nad,nd->na", axes, second.centres - first.centres))
    overlap = first.reach(axes) + second.reach(axes) - between
    return np.asarray(overlap.min(axis=1))


def _edge_normals(first: Array, second: Array) -> Array:
    """Unit normals of all pairs of edges, (n, 9, 3); of parallel ones an axis of the first box."""
    edges = np.swapaxes(first, 1, 2)[:, :, None], np.swapaxes(second, 1, 2)[:, None]
    normals = np.cross(*edges).reshape(-1, 9, 3)
    length = np.linalg.norm(normals, axis=2, keepdims=True)
    parallel = length < PARALLEL
    return np.where(parallel, first[:, None, :, 0], normals / np.where(parallel, 1.0, length))
