"""In which order the faces of bodies in space are drawn, so that nearer ones hide those behind."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from solver.types import Array, Indices

TOUCHING = 0.05
"""Part of the size of the smaller of two bodies by which they may reach into each other and still
count as side by side."""

EDGE_ON = 1e-3
"""Part of a unit normal that points to the eye, below which a plane is seen from its side."""


class _Body(NamedTuple):
    """A body as it is seen: to the right, up, and towards the eye, m."""

    corners: Array
    """Corners of its faces, (n, 3)."""
    normals: Array
    """Unit normals of its faces, each once, (m, 3)."""
    size: float
    """Its longest side."""


def drawing_order(faces: Sequence[Array], bodies: Indices) -> Indices:
    """Numbers of the faces, those that hide others later.

    The depth of their centres decides within a body, whose faces are much alike. It does not
    between bodies: a wide face may hide small ones whose centres are nearer to the eye. There a
    plane that has both bodies on its two sides tells which one is behind.

    Args:
        faces: Corners of each as they are seen, (k, 3): to the right, up, towards the eye, m.
        bodies: Number of the body that each belongs to.
    """
    depth = np.array([float(face[:, 2].mean()) for face in faces])
    own = [np.flatnonzero(bodies == number) for number in np.unique(bodies)]
    own.sort(key=lambda chosen: float(depth[chosen].mean()))
    parts = [_body([faces[k] for k in chosen]) for chosen in own]
    order: list[Indices] = []
    waiting = list(range(len(parts)))
    while waiting:
        last = [
            k for k in waiting if not any(_hides(parts[k], parts[j]) for j in waiting if j != k)
        ]
        chosen = own[(last or waiting)[0]]
        waiting.remove((last or waiting)[0])
        order.append(chosen[np.argsort(depth[chosen], kind="stable")])
    return np.concatenate(order)


def _body(faces: Sequence[Array]) -> _Body:
    """A body of some faces."""
    corners = np.concatenate(faces)
    area = np.array([np.cross(face, np.roll(face, -1, axis=0)).sum(axis=0) for face in faces])
    length = np.linalg.norm(area, axis=1, keepdims=True)
    normals = area[length[:, 0] > 0] / length[length[:, 0] > 0]
    _, first = np.unique(normals.round(2), axis=0, return_index=True)
    return _Body(corners, normals[first], float(np.ptp(corners, axis=0).max()))


def _hides(one: _Body, other: _Body) -> bool:
    """Whether a body may hide another one."""
    normals = np.concatenate([one.normals, other.normals])
    ours, theirs = one.corners @ normals.T, other.corners @ normals.T
    beyond = ours.min(axis=0) - theirs.max(axis=0)  # we are on the side that the normal points to
    before = theirs.min(axis=0) - ours.max(axis=0)
    best = int(np.argmax(np.maximum(beyond, before)))
    if max(beyond[best], before[best]) < -TOUCHING * min(one.size, other.size):
        return bool(one.corners[:, 2].mean() > other.corners[:, 2].mean())
    towards = normals[best, 2] if beyond[best] > before[best] else -normals[best, 2]
    return bool(towards > EDGE_ON)
