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
        low, high = _box(shape, d)
        own: Array = (low + high) / 2
        axis, sense = _normal(spec, d)
        own[axis] = low[axis] if sense > 0 else high[axis]
        return own
    return np.array(shape.centre_of_mass(d) if spec.at is None else spec.at)


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
    """The factors on forces at times (s), (times, forces)."""
    found = np.ones((len(times), len(specs)))
    for number, spec in enumerate(specs):
        rows = _course(spec)
        if rows:
            found[:, number] = np.interp(times, *np.transpose(rows))
    return found


def _course(spec: ForceSpec) -> Sequence[tuple[float, float]]:
    """Times, s, and factors at them, linear between; none of a force that is constant."""
    return spec.table or (((spec.ramp[0], 0.0), (spec.ramp[1], 1.0)) if spec.ramp else ())


def mean_factor(spec: ForceSpec, time: float, step: float) -> float:
    """The mean factor on a force over a step from a time, s; at the time where the step is 0."""
    rows = _course(spec)
    if not rows:
        return 1.0
    known, values = np.transpose(rows)
    if not step:
        return float(np.interp(time, known, values))
    inside = known[(known > time) & (known < time + step)]
    times = np.concatenate([[time], inside, [time + step]])
    return float(np.trapezoid(np.interp(times, known, values), times) / step)
