"""Contact of a block with its carrier, frame by frame: force, point of application, state."""

from __future__ import annotations

import math
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
class BlockFrames:
    """A block over the frames of a film."""

    centres: Array
    """Its middle, m, (n, d)."""
    frames: Array
    """Its axes as columns, (n, d, d)."""
    corners: Array
    """Its corners in its own axes, from its middle, m, (k, d)."""
    force: Array
    """Force from its carrier over the weight there, the mean since the frame before, (n, d)."""
    weight: float
    """That weight, N; 1 without gravity."""
    foot: Array
    """Point of application of that force, m, (n, d)."""
    states: list[State]
    """States of the contact, (n,)."""


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
    if shape.solid is None:
        half = np.array(shape.half_lengths(d))
        foot = _foot(centres, frames, half, up, _off(block, half))
    else:
        heavy = np.array(shape.centre_of_mass(d)) - middle
        foot = _foot_of_shape(centres, frames, corners, up, heavy)
    return BlockFrames(
        centres=centres,
        frames=frames,
        corners=corners,
        force=_force(run, block, times),
        weight=run.scene.stacked_mass(block) * run.scene.gravity or 1.0,
        foot=foot,
        states=_states(run, block, times),
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PairFrames:
    """The force between two neighbours over the frames of a film."""

    force: Array
    """On the first, over the smaller of their weights, the mean since the frame before, (n, d)."""
    weight: float
    """The smaller of their weights, N; 1 without gravity."""
    place: Array
    """Where they press, m, (n, d)."""
    states: list[State]
    """States of the contact, (n,)."""


def pair_frames(run: Run, times: Array) -> list[PairFrames]:
    """Neighbours that have touched, where the run has told what pairs do, at times, s."""
    masses = {block.name: block.shape.mass for block in run.scene.blocks}
    found = []
    for (one, other), known in run.neighbours().items():
        weight = min(masses[one], masses[other]) * run.scene.gravity or 1.0
        time = np.concatenate([[known["time_s"][0] - 1e-9], known["time_s"]])
        force = np.concatenate([np.zeros((1, run.scene.dimension)), force_on_first(known)])
        means = [_means(time, part, times) / weight for part in force.T]
        before = times < known["time_s"][0]
        mean = np.where(before[:, None], 0.0, np.stack(means, axis=1))
        axes = "xyz"[: run.scene.dimension]
        place = np.stack([np.interp(times, known["time_s"], known[f"{a}_m"]) for a in axes], axis=1)
        slips = [known[key] for key in ("slip_m", "slip_second_m") if key in known]
        moved = np.diff([np.interp(times, known["time_s"], slip) for slip in slips], prepend=0.0)
        moved = np.linalg.norm(moved, axis=0)
        spacing = times[1] - times[0] if len(times) > 1 else 1.0
        height = min(b.shape.height for b in run.scene.blocks if b.name in (one, other))
        fast = AT_REST * math.sqrt(run.scene.gravity * height) * spacing
        states = [State.SLIPS if way > fast else State.STICKS for way in moved]
        found.append(PairFrames(force=mean, weight=weight, place=place, states=states))
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


def _force(run: Run, block: BlockSpec, times: Array) -> Array:
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
    weight = run.scene.stacked_mass(block) * run.scene.gravity or 1.0
    means = [_means(history["time_s"], part, times) / weight for part in force.T]
    return np.asarray(np.stack(means, axis=1), dtype=np.float64)


def _means(time: Array, values: Array, times: Array) -> Array:
    """Means of what is constant over each step, from each frame to the next."""
    spacing = times[1] - times[0] if len(times) > 1 else 1.0
    integral = np.concatenate([[0.0], np.cumsum(values[1:] * np.diff(time))])
    later, before = np.minimum(times, time[-1]), np.maximum(times - spacing, time[0])
    known = later > before
    gained = np.interp(later, time, integral) - np.interp(before, time, integral)
    at_start = np.full_like(times, values[1] if len(values) > 1 else values[0])
    return np.divide(gained, later - before, out=at_start, where=known)


def _off(block: BlockSpec, half: Array) -> Array:
    """The centre of mass off the middle, over half the edges, (d,)."""
    d, shape = len(half), block.shape
    return np.asarray((np.array(shape.centre_of_mass(d)) - shape.middle(d)) / half)


def _foot(centres: Array, frames: Array, half: Array, up: Array, off: Array) -> Array:
    """Lowest point over the carrier: a corner, or between those that share, also of a side.

    Where all share, it is below the centre of mass, `off` the middle over half the edges.
    """
    dimension = len(half)
    signs = np.array(np.meshgrid(*[[-1.0, 1.0]] * dimension)).reshape(dimension, -1).T
    corners = signs * half
    placed = centres[:, None] + np.einsum("nij,kj->nki", frames, corners)
    height = np.einsum("nki,ni->nk", placed, up)
    height -= height.min(axis=1, keepdims=True)
    share = np.exp(-height / (TOUCHING * 2 * half[0])) * np.prod(1 + signs * off, axis=1)
    share /= share.sum(axis=1, keepdims=True)
    return np.asarray(np.einsum("nk,nki->ni", share, placed))


def _foot_of_shape(centres: Array, frames: Array, corners: Array, up: Array, heavy: Array) -> Array:
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


def _states(run: Run, block: BlockSpec, times: Array) -> list[State]:
    """State of a block from the frame before to each frame: it sticks, slips or is in the air."""
    history, name, time = run.history, block.name, run.history["time_s"]
    normal = _means(time, np.nan_to_num(history[f"{name}.normal_force_N"]), times)
    weight = run.scene.stacked_mass(block) * run.scene.gravity or 1.0
    spacing = times[1] - times[0] if len(times) > 1 else 1.0
    moved: Array = np.zeros(len(times))
    for column in (f"{name}.slip_m", f"{name}.slip_second_m"):
        if column in history:
            slip = history[column]
            gained = np.interp(times, time, slip) - np.interp(times - spacing, time, slip)
            moved = np.hypot(moved, gained)
    fast = AT_REST * math.sqrt(run.scene.gravity * block.shape.height) * spacing
    return [
        State.OPEN if force < LEAST_FORCE * weight else State.SLIPS if way > fast else State.STICKS
        for force, way in zip(normal, moved, strict=True)
    ]
