"""Flutter of blocks in a run: their normal force swings at a mode of vibration as they slide."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from solver.history.history import History
from solver.results.motion import BlockMotion
from solver.scene import BlockSpec, Scene
from solver.types import Array

SLIDING = 1e-3
"""Speed above which a block slides, m/s."""

SWINGS = 10
"""Swings one after another that are flutter, and not what an impact leaves."""

SLOWEST = 0.5
"""Frequency of a swing that is vibration, over that of the first bending mode."""


def cautions_of_flutter(scene: Scene, history: History) -> Iterator[str]:
    """Cautions about elastic blocks whose normal force swings by more than its mean in a slide."""
    for block in scene.blocks:
        if block.model == "elastic" and (seen := flutter(scene, history, block)) is not None:
            began, frequency = seen
            default = scene.default_damping(block).stiffness
            yield (
                f"{block.name} flutters as it slides, from {began:.4g} s at {frequency:.3g} Hz: "
                "its normal force swings by more than its mean, and damping decides how far it "
                f"slides; by default damping.stiffness is {default:.2g} s, and rockslip check "
                "tells which one holds it"
            )


def flutter(scene: Scene, history: History, block: BlockSpec) -> tuple[float, float] | None:
    """Time at which a block begins to flutter, s, and the frequency, Hz; None if it never does."""
    motion = BlockMotion(scene, history, block)
    slowest = SLOWEST * scene.bending_frequency(block) / (2 * np.pi)
    force = history[f"{block.name}.normal_force_N"]
    for rows in slides(motion.time, motion.slip):
        time, normal = motion.time[rows], force[rows]
        mean = float(normal.mean())
        rising = np.flatnonzero((normal[:-1] < mean) & (normal[1:] >= mean)) + 1
        if len(rising) <= SWINGS:
            continue
        high, low = (each.reduceat(normal, rising)[:-1] for each in (np.maximum, np.minimum))
        period = np.diff(time[rising])
        swings = (high - low > mean) & (period * slowest < 1)
        run = np.convolve(swings, np.ones(SWINGS, dtype=int), "valid") == SWINGS
        if run.any():
            first = int(run.argmax())
            return float(time[rising[first]]), float(1 / np.median(period[swings]))
    return None


def slides(time: Array, slip: Array) -> list[Array]:
    """Rows of each slide, in which a block goes on sliding; slip is (rows, directions), m."""
    lengths = np.diff(time)
    way = np.linalg.norm(np.diff(slip, axis=0), axis=1)
    sliding = np.flatnonzero(way > SLIDING * lengths) + 1
    return np.split(sliding, np.flatnonzero(np.diff(sliding) > 1) + 1) if len(sliding) else []
