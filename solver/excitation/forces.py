"""Forces on blocks: where they act, and what they are at which time."""

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
    own = place_of(spec, shape, len(centre))
    return np.asarray(pose.rotation.T @ (pose(own[None])[0] - centre))


def place_of(spec: ForceSpec, shape: Block, d: int) -> Array:
    """Place at which a force acts, in the block's own frame, (d,), m."""
    if spec.pressure is not None:
        low, high = face_corners(spec, shape, d)
        return np.asarray((low + high) / 2)
    return np.array(shape.centre_of_mass(d) if spec.at is None else spec.at)


def whole_force(spec: ForceSpec, pose: Pose, shape: Block) -> Array:
    """The force at factor 1, N, (d,); arguments as for `arm_of`."""
    if spec.pressure is None:
        return np.array(spec.force)
    d = len(pose.place)
    axis, sense = normal_of(spec, d)
    low, high = face_corners(spec, shape, d)
    area = float(np.prod(np.delete(high - low, axis))) * (shape.thickness if d == 2 else 1.0)
    return np.asarray(spec.pressure * area * sense * pose.rotation[:, axis])


def face_corners(spec: ForceSpec, shape: Block, d: int) -> tuple[Array, Array]:
    """Lowest and highest corner of the face of a pressure, in the block's own frame, (d,), m.

    Of a block on feet it is a face of the box on them.
    """
    half = np.array(shape.half_lengths(d)[:-1])
    bottom, top = shape.walls or (0.0, shape.height)
    low, high = np.append(-half, bottom), np.append(half, top)
    axis, sense = normal_of(spec, d)
    low[axis] = high[axis] = low[axis] if sense > 0 else high[axis]
    return low, high


def normal_of(spec: ForceSpec, d: int) -> tuple[int, float]:
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
        rows = _course(spec)
        if rows:
            ends = np.interp(times, *np.transpose(rows))
            shift = mean_factors(spec, times) - (ends[1:] + ends[:-1]) / 2
            found[:, :, number] = np.stack([ends[:-1] + shift, ends[1:] + shift], axis=1)
    return found


def mean_factors(spec: ForceSpec, times: Array) -> Array:
    """The mean factors on a force over the steps between times (s), (steps,)."""
    rows = _course(spec)
    if not rows:
        return np.ones(len(times) - 1)
    bends, values = np.transpose(rows)
    at = np.union1d(times, bends[(bends > times[0]) & (bends < times[-1])])
    course, step = np.interp(at, bends, values), np.searchsorted(times, at[:-1], "right") - 1
    gained = np.diff(at) * (course[1:] + course[:-1]) / 2
    return np.asarray(np.bincount(step, gained) / np.diff(times))


def mean_factor(spec: ForceSpec, time: float, step: float) -> float:
    """The mean factor on a force over a step from a time, s; at the time where the step is 0."""
    if step:
        return float(mean_factors(spec, np.array([time, time + step]))[0])
    rows = _course(spec)
    return float(np.interp(time, *np.transpose(rows))) if rows else 1.0


def _course(spec: ForceSpec) -> Sequence[tuple[float, float]]:
    """Times, s, and factors at them, linear between; none of a force that is constant."""
    return spec.table or (((spec.ramp[0], 0.0), (spec.ramp[1], 1.0)) if spec.ramp else ())
