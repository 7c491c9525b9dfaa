"""Impacts of a block on another one that moves: read from the velocities of both."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from solver.history.history import History
from solver.results.motion import block_motion, is_spatial
from solver.results.rocking import SMALLEST_SWING, Impact
from solver.scene import BlockSpec, Scene
from solver.types import Array

HELD = 1e-4
"""Slip of a block, over its width, up to which it counts as ground for the block on it."""

BESIDE = 3
"""Rows on either side of an impact whose angular velocities are taken, without the nearest one."""


def rated_against_carrier(
    scene: Scene, history: History, block: BlockSpec, impacts: list[Impact]
) -> list[Impact]:
    """The impacts of a block with the restitution that angular velocities against its carrier give.

    Where what carries it holds, they stay as they are: it is ground, or a base like the ground's.
    Else energies between peaks mean nothing. Of rigid blocks in the plane the columns tell how fast
    both turn beside an impact; vibration hides it in others, and they have no restitution.
    """
    carrier = scene.carrier_of(block)
    if carrier is None or _holds(scene, history, carrier):
        return impacts
    if is_spatial(history, block.name) or "elastic" in (block.model, carrier.model):
        return [replace(impact, restitution=None) for impact in impacts]
    names = [f"{each.name}.angular_velocity_rad_s" for each in (block, carrier)]
    rate, time = history[names[0]] - history[names[1]], history["time_s"]
    times = [impact.time_s for impact in impacts]
    return [replace(i, restitution=_ratio(time, rate, i.time_s, times)) for i in impacts]


def _holds(scene: Scene, history: History, block: BlockSpec | None) -> bool:
    """Whether a block, and all below it, stand where they stood."""
    if block is None:
        return True
    motion = block_motion(scene, history, block)
    still = np.ptp(motion.slip, axis=0).max() <= HELD * block.width
    upright = np.abs(motion.angle).max() <= SMALLEST_SWING * block.shape.slenderness
    return bool(still and upright) and _holds(scene, history, scene.carrier_of(block))


def _ratio(time: Array, rate: Array, at: float, impacts: Sequence[float]) -> float | None:
    """Ratio of the angular velocities after and before one of some impacts, all by their times, s.

    Both change evenly beside it; None where another impact is as near.
    """
    row = int(np.searchsorted(time, at, side="right"))  # the first one after it
    before = np.arange(row - 1 - BESIDE, row - 1)
    after = np.arange(row + 1, row + 1 + BESIDE)
    if before[0] < 0 or after[-1] >= len(time):
        return None
    if any(other != at and time[before[0]] <= other <= time[after[-1]] for other in impacts):
        return None
    if not all(np.ptp(time[rows]) > 0 for rows in (before, after)):
        return None
    ends = [
        float(np.polynomial.Polynomial.fit(time[rows], rate[rows], 1)(at))
        for rows in (before, after)
    ]
    return abs(ends[1] / ends[0]) if ends[0] else None
