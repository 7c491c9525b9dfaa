"""Interval of a run in which something moves: pictures and films are cut to it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from solver.history.history import History
from solver.results.motion import total_lean
from solver.scene import Scene
from solver.types import Array

QUIET = 5e-3
"""A quantity rests once it stays this close to where it ends, over its range."""

MARGIN = 0.05
"""Part of the time in which something moves that is shown before and after it."""


def moving_span(scene: Scene, history: History) -> tuple[float, float]:
    """From when to when something moves, with a margin, s; all of a run in which nothing does."""
    time = history["time_s"]
    first, last = float(time[0]), float(time[-1])
    spans = [
        span for values, least in _quantities(scene, history) if (span := _span(values, least))
    ]
    if not spans:
        return first, last
    begin = float(time[min(rows[0] for rows in spans)])
    end = float(time[max(rows[1] for rows in spans)])
    margin = MARGIN * (end - begin)
    return max(first, begin - margin), min(last, end + margin)


def _quantities(scene: Scene, history: History) -> Iterator[tuple[Array, float]]:
    """Quantities that may move, each with the least change that counts."""
    for name in history.columns:
        base = name.startswith("base.") and name.endswith("acceleration_m_s2")
        if base or name.startswith("platform.drift"):
            yield history[name], 0.0
    for block in scene.blocks:
        # A thousandth of alpha, and of the width: less is the wobble of an elastic block at rest.
        yield total_lean(history, block.name), 1e-3 * block.shape.slenderness()
        for column in (f"{block.name}.slip_m", f"{block.name}.slip_second_m"):
            if column in history:
                yield history[column], 1e-3 * block.width


def _span(values: Array, least: float) -> tuple[int, int] | None:
    """The last row before a quantity leaves where it began, and the first at which it rests."""
    known = np.nan_to_num(values)
    bound = max(QUIET * float(np.ptp(known)), least)
    left = np.flatnonzero(np.abs(known - known[0]) > bound)
    away = np.flatnonzero(np.abs(known - known[-1]) > bound)
    if not len(left) or not len(away):
        return None
    return max(int(left[0]) - 1, 0), min(int(away[-1]) + 1, len(known) - 1)
