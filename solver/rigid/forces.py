"""Forces on rigid blocks: where they act, and what they are at which time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geometry.arrangement import Pose
from geometry.block import Block
from solver.scene.force import NORMALS, ForceSpec
from solver.types import Array


def arm_of(spec: ForceSpec, pose: Pose, shape: Block, centre: Array) -> Array:
    """Place at which a force acts, about the centre of its block and in its frame, (d,), m.

    Args:
        spec: The force.
        pose: From the block's own frame to where it stands at the start.
        shape: The block.
        centre: Where its centre is then, m.
    """
    d = len(centre)
    if spec.pressure is not None:
        low, high = _box(shape, d)
        own: Array = (low + high) / 2
        axis, sense = _normal(spec, d)
        own[axis] = low[axis] if sense > 0 else high[axis]
    elif spec.at is not None:
        own = np.array(spec.at)
    else:
        return np.zeros(d)
    return np.asarray(pose.rotation.T @ (pose(own[None])[0] - centre))


def whole_force(spec: ForceSpec, pose: Pose, shape: Block) -> Array:
    """The force at factor 1, N, (d,); arguments as for `arm_of`."""
    if spec.pressure is None:
        return np.array(spec.force)
    d = len(pose.place)
    axis, sense = _normal(spec, d)
    low, high = _box(shape, d)
    area = float(np.prod(np.delete(high - low, axis))) * (shape.thickness if d == 2 else 1.0)
    return np.asarray(spec.pressure * area * sense * pose.rotation[:, axis])


def _box(shape: Block, d: int) -> tuple[Array, Array]:
    """Lowest and highest corner of a box, or of the one that stands on feet, m."""
    corners = np.array(shape.corners(d)) if shape.solid is None else shape.solid.parts[0].corners
    return corners.min(axis=0), corners.max(axis=0)


def _normal(spec: ForceSpec, d: int) -> tuple[int, float]:
    """Axis along which a pressure on a face pushes, and the sense."""
    assert spec.face is not None
    axis, sense = NORMALS[spec.face]
    return axis % d, sense


def factors(specs: Sequence[ForceSpec], times: Array) -> Array:
    """The factors on forces at both ends of the steps between times (s), (steps, 2, forces).

    In between they are linear. Where a ramp or a table bends within a step, both ends are shifted
    so that its mean is right and no impulse goes missing, however short a pulse is.
    """
    found = np.ones((len(times) - 1, 2, len(specs)))
    for number, spec in enumerate(specs):
        rows = spec.table or (((spec.ramp[0], 0.0), (spec.ramp[1], 1.0)) if spec.ramp else ())
        if not rows:
            continue
        bends, values = np.transpose(rows)
        ends = np.interp(times, bends, values)
        at = np.union1d(times, bends[(bends > times[0]) & (bends < times[-1])])
        course, step = np.interp(at, bends, values), np.searchsorted(times, at[:-1], "right") - 1
        gained = np.diff(at) * (course[1:] + course[:-1]) / 2
        mean = np.bincount(step, gained) / np.diff(times)
        bent = np.bincount(step) > 1
        shift = np.where(bent, mean - (ends[1:] + ends[:-1]) / 2, 0.0)
        found[:, :, number] = np.stack([ends[:-1] + shift, ends[1:] + shift], axis=1)
    return found
