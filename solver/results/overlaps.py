"""Blocks that come to overlap in a run, although neither carries the other: a check of contact.

All bodies meet, and none should overlap. Where two do, contact between them was lost, and what
follows is not to be trusted. They are compared as rigid boxes, at the times at which snapshots of
the fields are due; where the boxes around other shapes overlap, the shapes are.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from geometry.boxes import Boxes, overlap_depth
from geometry.convex import Convex
from geometry.overlap import common_depth
from geometry.shapes import hull
from solver.results.motion import Columns, boxes
from solver.scene import BlockSpec, Scene
from solver.types import Array, Indices, Mask

SMALLEST_OVERLAP = 1e-3
"""Smallest depth that counts, as a part of the smallest edge: less is deformation."""


MOST = 50
"""Instants at which two shapes are compared at most, evenly among those of their boxes."""


def overlaps(scene: Scene, history: Columns) -> list[dict[str, Any]]:
    """Blocks that came to overlap: two names, the time (s) of the first, the largest depth (m)."""
    pairs = list(scene.non_adjacent())
    if not pairs:
        return []
    time, found = history["time_s"], []
    rows = _rows(time, scene.output.snapshot_time(scene.time.end))
    there = {block.name: boxes(history, block).at(rows) for block in scene.blocks}
    for first, second in pairs:
        one, other = there[first.name], there[second.name]
        near = np.flatnonzero(_may_overlap(one, other))
        if not len(near):
            continue
        depth = overlap_depth(one.at(near), other.at(near))
        least = SMALLEST_OVERLAP * 2 * min(*one.half, *other.half)
        deep = np.flatnonzero(depth > least)
        if len(deep) and (first.shape.solid is not None or second.shape.solid is not None):
            deep = deep[np.linspace(0, len(deep) - 1, min(len(deep), MOST)).astype(int)]
            depth = np.zeros(len(near))
            for k in deep:
                row = near[[k]]
                depth[k] = common_depth(_parts(first, one.at(row)), _parts(second, other.at(row)))
            deep = deep[depth[deep] > least]
        if len(deep):
            entry = {
                "blocks": [first.name, second.name],
                "time_s": float(time[rows[near[deep[0]]]]),
                "depth_m": float(depth.max()),
            }
            found.append(entry)
    return sorted(found, key=lambda entry: float(entry["time_s"]))


def _parts(block: BlockSpec, box: Boxes) -> tuple[Convex, ...]:
    """The convex parts of a block as it stands at one instant."""
    shape, d = block.shape, len(box.half)
    if shape.solid is None:
        corners = box.centres[0] + (np.array(shape.corners(d)) - shape.middle(d)) @ box.frames[0].T
        return hull(corners).parts
    return (
        shape.solid.moved(-np.array(shape.middle(d)))
        .rotated(box.frames[0])
        .moved(box.centres[0])
        .parts
    )


def _rows(time: Array, every: float) -> Indices:
    """The first row at or after each time at which a snapshot is due, and the last row."""
    due = np.floor(time / every + 1e-9)
    return np.unique(np.append(np.flatnonzero(np.diff(due, prepend=-1.0) > 0), len(time) - 1))


def _may_overlap(one: Boxes, other: Boxes) -> Mask:
    """True at instants at which the spheres around two boxes overlap."""
    apart = np.linalg.norm(one.centres - other.centres, axis=1)
    return np.asarray(apart < np.linalg.norm(one.half) + np.linalg.norm(other.half))
