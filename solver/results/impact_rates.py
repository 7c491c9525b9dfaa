"""Restitution by the angular velocities in the rows beside an impact.

Peaks, and the motion of a rigid block that rocks about a corner, tell nothing of an impact where
the block slides on ground that moves, or where what carries it is a block that moves.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from solver.history.history import History
from solver.results.angular_velocity import WINDOW
from solver.results.motion import (
    SMALLEST_WAY,
    angular_velocity,
    block_motion,
    is_spatial,
    leaning,
)
from solver.results.rocking import HOPS, NOT_TOLD, SMALLEST_SWING, Impact
from solver.scene import BlockSpec, Scene
from solver.types import Array

HELD = 1e-4
"""Slip of a block, over its width, up to which it holds: as ground for the block on it, and where
it rocks itself."""

CARRIER_MOVES = "what carries it moves, and vibration or space hides how fast both turn"
SLIDES = "it slides, and vibration hides how fast it turns"

BESIDE = 3
"""Rows on either side of an impact whose angular velocities are taken, without the nearest one."""


def rated_by_velocities(
    scene: Scene, history: History, block: BlockSpec, impacts: list[Impact]
) -> list[Impact]:
    """The impacts of a block, with the restitution that angular velocities give where needed.

    On what holds they stay as they are, but for those of a block that slides meanwhile on a base
    that moves, or down an incline. Of rigid blocks the columns tell how fast they turn beside an
    impact; vibration hides it in others, and on foundations that deform, where an impact takes
    more rows than those: they have no restitution. Neither have blocks in space on one that moves.
    """
    if not impacts:
        return impacts
    carrier = scene.carrier_of(block)
    if carrier is None or _holds(scene, history, carrier):
        return _rated_where_it_slides(scene, history, block, impacts)
    if is_spatial(history, block.name) or "elastic" in (block.model, carrier.model):
        return [Impact.of(impact.time_s, None, CARRIER_MOVES) for impact in impacts]
    names = [f"{each.name}.angular_velocity_rad_s" for each in (block, carrier)]
    rate, time = history[names[0]] - history[names[1]], history["time_s"]
    times = [impact.time_s for impact in impacts]
    rated = [Impact.of(at, _ratio(time, rate, at, times), NOT_TOLD) for at in times]
    return [i if i.reason == HOPS else new for i, new in zip(impacts, rated, strict=True)]


def _rated_where_it_slides(
    scene: Scene, history: History, block: BlockSpec, impacts: list[Impact]
) -> list[Impact]:
    """The impacts of a block on a base, on which it may slide."""
    motion = block_motion(scene, history, block)
    if motion.base is None or scene.gravity == 0:
        return impacts  # by peaks: friction counts as loss
    told = block.model == "rigid" and not scene.foundation.is_meshed
    least = (HELD if told else SMALLEST_WAY) * block.width
    window = WINDOW / motion.shape.frequency(scene.gravity)
    rate = angular_velocity(history, block.name, leaning(history, block).direction)
    times = [impact.time_s for impact in impacts]
    found = []
    for impact in impacts:
        near = np.abs(motion.time - impact.time_s) <= window
        slides = near.any() and np.ptp(motion.displacement[near], axis=0).max() > least
        if slides and impact.restitution is not None:
            known = _ratio(motion.time, rate, impact.time_s, times) if told else None
            impact = Impact.of(impact.time_s, known, NOT_TOLD if told else SLIDES)
        found.append(impact)
    return found


def _holds(scene: Scene, history: History, block: BlockSpec | None) -> bool:
    """Whether a block, and all below it, stand where they stood."""
    if block is None:
        return True
    motion = block_motion(scene, history, block)
    still = np.ptp(motion.displacement, axis=0).max() <= HELD * block.width
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
