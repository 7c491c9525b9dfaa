"""Contact of a block with its carrier, frame by frame: force, point of application, state."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from solver.history.pairs import force_on_first
from solver.results.motion import boxes, lost_carrier, platform_drift, top_axes
from solver.results.runs import Run
from solver.scene import BlockSpec
from solver.types import Array

TOUCHING = 2e-3
"""Corners whose gaps differ by less than this over the width share the force."""

AT_REST = 1e-3
"""Slip is slower than this over sqrt(g H) where a block sticks."""

LEAST_FORCE = 1e-3
"""A mean force over a frame that is smaller than this over the weight is none."""


class State(Enum):
    """State of the contact between a block and its carrier."""

    STICKS = "sticks"
    SLIPS = "slips"
    OPEN = "in the air"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Push:
    """The force of a contact over the frames of a film."""

    force: Array
    """Over the weight, the mean since the frame before, (n, d)."""
    weight: float
    """The weight that forces are over, N; 1 without gravity."""
    place: Array
    """Point of application of that force, m, (n, d)."""
    states: list[State]
    """States of the contact, (n,)."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BlockFrames:
    """A block over the frames of a film."""

    centres: Array
    """Its middle, m, (n, d)."""
    frames: Array
    """Its axes as columns, (n, d, d)."""
    corners: Array
    """Its corners in its own axes, from its middle, m, (k, d)."""
    push: Push
    """The force from its carrier, over the weight that stands there."""


def block_frames(run: Run, block: BlockSpec, times: Array) -> BlockFrames:
    """A block at the times of the frames, s, which are evenly spaced."""
    carrier = run.scene.carrier_of(block)
    centres, frames = block_poses(run, block, times)
    shape, d = block.shape, run.scene.dimension
    middle = np.array(shape.middle(d))
    corners = np.unique(np.array(shape.corners(d)), axis=0) - middle
    up = np.broadcast_to(np.eye(d)[-1], centres.shape)
    if carrier is not None:
        time = run.history["time_s"]
        up = _turned(time, top_axes(run.history, carrier), times)[:, :, -1]
    heavy = np.array(shape.centre_of_mass(d)) - middle
    weight = run.scene.stacked_mass(block) * run.scene.gravity or 1.0
    push = Push(
        force=_force(run, block, weight, times),
        weight=weight,
        place=_foot(centres, frames, corners, up, heavy),
        states=_states(run, block, weight, times),
    )
    return BlockFrames(centres=centres, frames=frames, corners=corners, push=push)


def pair_frames(run: Run, times: Array) -> list[Push]:
    """Forces on the first of two neighbours that have touched, over the smaller of their weights.

    Where the run has told what pairs do, at times, s.
    """
    blocks = {block.name: block for block in run.scene.blocks}
    found = []
    for names, known in run.neighbours().items():
        both = [blocks[name].shape for name in names]
        weight = min(shape.mass for shape in both) * run.scene.gravity or 1.0
        time = np.concatenate([[known["time_s"][0] - 1e-9], known["time_s"]])
        force = np.concatenate([np.zeros((1, run.scene.dimension)), force_on_first(known)])
        means = [_means(time, part, times) / weight for part in force.T]
        before = times < known["time_s"][0]
        mean = np.where(before[:, None], 0.0, np.stack(means, axis=1))
        axes = "xyz"[: run.scene.dimension]
        place = np.stack([np.interp(times, known["time_s"], known[f"{a}_m"]) for a in axes], axis=1)
        slips = [known[key] for key in ("slip_m", "slip_second_m") if key in known]
        least = _least_way(run, min(shape.height for shape in both), times)
        states = [
            State.SLIPS if way > least else State.STICKS
            for way in _ways(known["time_s"], slips, times)
        ]
        found.append(Push(force=mean, weight=weight, place=place, states=states))
    return found


def block_poses(run: Run, block: BlockSpec, times: Array) -> tuple[Array, Array]:
    """Middle, m, (n, d), and axes as columns, (n, d, d), of a block at some times, s."""
    time, box = run.history["time_s"], boxes(run.history, block)
    return interpolated(time, box.centres, times), _turned(time, box.frames, times)


def drift_at(run: Run, times: Array) -> Array:
    """Displacement of the foundation at some times (s), m, (n, d)."""
    drift = platform_drift(run.history, run.scene.dimension)
    return interpolated(run.history["time_s"], drift, times)


def interpolated(time: Array, values: Array, times: Array) -> Array:
    """Columns of a table between its rows, (n, ...)."""
    flat = values.reshape(len(time), -1)
    found: Array = np.empty((len(times), flat.shape[1]))
    for number, column in enumerate(flat.T):
        found[:, number] = np.interp(times, time, column)
    return found.reshape(len(times), *values.shape[1:])


def _turned(time: Array, frames: Array, times: Array) -> Array:
    """Rotations between the rows of a table: the nearest ones to what lies straight between."""
    left, _, right = np.linalg.svd(interpolated(time, frames, times))
    return np.asarray(left @ right)


def _force(run: Run, block: BlockSpec, weight: float, times: Array) -> Array:
    """The force from the carrier over the weight, so that an impact counts by its impulse."""
    history, name = run.history, block.name
    carrier = run.scene.carrier_of(block)
    count = len(history)
    up = np.zeros((count, run.scene.dimension))
    up[:, -1] = 1.0
    axes = np.broadcast_to(np.eye(run.scene.dimension), (count, up.shape[1], up.shape[1]))
    if carrier is not None:
        lost = lost_carrier(history, block, carrier)
        axes = np.where(lost[:, None, None], axes, top_axes(history, carrier))
    along = [history[f"{name}.friction_force_N"]]
    if f"{name}.friction_force_second_N" in history:
        along.append(history[f"{name}.friction_force_second_N"])
    own = np.stack([*along, history[f"{name}.normal_force_N"]], axis=1)
    force = np.nan_to_num(np.einsum("nij,nj->ni", axes, own))
    means = [_means(history["time_s"], part, times) / weight for part in force.T]
    return np.asarray(np.stack(means, axis=1), dtype=np.float64)


def _means(time: Array, values: Array, times: Array) -> Array:
    """Means of what is constant over each step, from each frame to the next."""
    integral = np.concatenate([[0.0], np.cumsum(values[1:] * np.diff(time))])
    later, before = np.minimum(times, time[-1]), np.maximum(times - _spacing(times), time[0])
    known = later > before
    gained = np.interp(later, time, integral) - np.interp(before, time, integral)
    at_start = np.full_like(times, values[1] if len(values) > 1 else values[0])
    return np.divide(gained, later - before, out=at_start, where=known)


def _foot(centres: Array, frames: Array, corners: Array, up: Array, heavy: Array) -> Array:
    """The place nearest to below the centre of mass, `heavy`, between the lowest corners.

    These are all that are as low over the carrier as the lowest one, but for a part of the width.
    """
    near = TOUCHING * float(np.ptp(corners[:, 0]))
    found = []
    for k, (centre, frame) in enumerate(zip(centres, frames, strict=True)):
        upwards = up[k]
        placed = centre + corners @ frame.T
        height = placed @ upwards
        lowest = placed[height <= height.min() + near]
        below = centre + frame @ heavy
        below = below - upwards * (below @ upwards - height.min())
        found.append(_nearest_between(lowest, below, upwards))
    return np.array(found)


def _nearest_between(places: Array, target: Array, normal: Array) -> Array:
    """The place of the convex hull of places near a plane that is nearest to a target on it."""
    if len(places) == 1:
        return places[0]
    flat = places - target
    flat = flat - np.outer(flat @ normal, normal)
    if places.shape[1] == 3:
        across = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
        across /= np.linalg.norm(across)
        turns = np.sort(np.arctan2(flat @ np.cross(normal, across), flat @ across))
        gaps = np.diff(turns, append=turns[0] + 2 * np.pi)
        if gaps.max() < np.pi:
            return target
    first, second = (flat[k] for k in np.triu_indices(len(flat), 1))
    along = second - first
    length = np.einsum("ni,ni->n", along, along)
    part = np.divide(-np.einsum("ni,ni->n", first, along), length, out=0 * length, where=length > 0)
    nearest = first + np.clip(part, 0, 1)[:, None] * along
    return np.asarray(target + nearest[np.argmin(np.einsum("ni,ni->n", nearest, nearest))])


def _states(run: Run, block: BlockSpec, weight: float, times: Array) -> list[State]:
    """State of a block from the frame before to each frame: it sticks, slips or is in the air."""
    history, name, time = run.history, block.name, run.history["time_s"]
    normal = _means(time, np.nan_to_num(history[f"{name}.normal_force_N"]), times)
    columns = (f"{name}.slip_m", f"{name}.slip_second_m")
    slips = [history[column] for column in columns if column in history]
    least = _least_way(run, block.shape.height, times)
    return [
        State.OPEN if force < LEAST_FORCE * weight else State.SLIPS if way > least else State.STICKS
        for force, way in zip(normal, _ways(time, slips, times), strict=True)
    ]


def _spacing(times: Array) -> float:
    """Time from frame to frame, s."""
    return float(times[1] - times[0]) if len(times) > 1 else 1.0


def _ways(time: Array, slips: Sequence[Array], times: Array) -> Array:
    """How far something slips from the frame before to each frame, by its slips at times, m."""
    before = times - _spacing(times)
    gained = [np.interp(times, time, slip) - np.interp(before, time, slip) for slip in slips]
    return np.asarray(np.linalg.norm(gained, axis=0))


def _least_way(run: Run, height: float, times: Array) -> float:
    """The way from frame to frame beyond which a block of a height slips, m."""
    return AT_REST * math.sqrt(run.scene.gravity * height) * _spacing(times)
