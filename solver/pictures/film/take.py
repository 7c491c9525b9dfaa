"""What a film shows of one run: times, bodies, forces, the way of the ground, and the window."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from solver.fields.ground import floor_level
from solver.pictures.film.actors import Bodies, bodies_of
from solver.pictures.film.contact import BlockFrames, block_frames, interpolated
from solver.results.runs import Run
from solver.types import Array

AWAY = 1.5
"""What leaves its place is followed this far to a side, over the size of all at the start."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Take:
    """One run, frame by frame."""

    run: Run
    times: Array
    """Times of the frames, s, (n,)."""
    blocks: list[BlockFrames]
    bodies: Bodies
    ground: Array
    """Where the ground is, m, (n, d): 0 in its own frame."""
    floor: float
    """Height of the floor, m."""
    low: Array
    """Least place of the bodies in all frames, m, (d,)."""
    high: Array
    """Greatest place, m, (d,)."""

    @property
    def arrow(self) -> float:
        """Length of an arrow that stands for the weight, m."""
        return 0.3 * min(block.height for block in self.run.scene.blocks)


def take(run: Run, times: Array, *, fixed: bool) -> Take:
    """Make ready to film a run, seen from the ground, or `fixed`: from a place at rest."""
    scene, history = run.scene, run.history
    blocks = [block_frames(run, block, times) for block in scene.blocks]
    drift = np.zeros((len(times), scene.dimension))
    for axis, name in enumerate(("platform.drift_m", "platform.drift_second_m")):
        if name in history and axis < scene.dimension - 1:
            drift[:, axis] = np.interp(times, history["time_s"], history[name])
    bodies = bodies_of(run, blocks, drift, times)
    ground = ground_path(run, times) if fixed else np.zeros((len(times), scene.dimension))
    low, high = _window(blocks, bodies, ground)
    return Take(
        run=run,
        times=times,
        blocks=blocks,
        bodies=bodies,
        ground=ground,
        floor=floor_level(scene),
        low=low,
        high=high,
    )


def ground_path(run: Run, times: Array) -> Array:
    """Displacement of the ground, m, (n, d): its acceleration integrated twice from rest."""
    history, dimension = run.history, run.scene.dimension
    time = history["time_s"]
    path = np.zeros((len(time), dimension))
    axes = {"acceleration_m_s2": 0, "second_acceleration_m_s2": 1}
    axes["vertical_acceleration_m_s2"] = dimension - 1
    steps = np.diff(time)
    for name, axis in axes.items():
        if f"base.{name}" in history:
            rate = history[f"base.{name}"]
            for _ in range(2):
                rate = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * steps)])
            path[:, axis] = rate
    return interpolated(time, path, times)


def _window(blocks: Sequence[BlockFrames], bodies: Bodies, ground: Array) -> tuple[Array, Array]:
    """Least and greatest place of all that is shown, m."""
    start = np.concatenate([np.asarray(surface.points) for surface in bodies.at(0)])
    start = start[:, : ground.shape[1]]
    first, last = start.min(axis=0), start.max(axis=0)
    away = AWAY * float((last - first).max())
    low, high = first + ground.min(axis=0), last + ground.max(axis=0)
    for block in blocks:
        reach = np.einsum("nij,j->ni", np.abs(block.frames), block.half)
        low = np.minimum(low, (block.centres - reach + ground).min(axis=0))
        high = np.maximum(high, (block.centres + reach + ground).max(axis=0))
    return np.maximum(low, first - away), np.minimum(high, last + away)
