"""The instants of a run that are worth a look."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from solver.results.endings import fell_at, overturned_at
from solver.results.motion import block_motion
from solver.results.moving import moving_span
from solver.results.rocking import swings
from solver.results.runs import Run


class Instant(NamedTuple):
    """An instant, and what happens then."""

    time_s: float
    """When, s."""
    name: str = ""
    """What, in a word or two; empty: nothing in particular."""


def instants(run: Run) -> list[Instant]:
    """Lift-off, largest angle, landing and end of the block that leans most over its slenderness.

    Of a block that is released: the release, its landing, the peak after that, the end.
    Where nothing rocks, four instants evenly spread over the time in which something moves.
    """
    first, last = moving_span(run.scene, run.history)
    end = Instant(last, "at rest" if last < run.history["time_s"][-1] else "end")
    entries = run.summary["blocks"]
    most = max(run.scene.blocks, key=lambda b: entries[b.name]["peak_angle_over_alpha"])
    motion = block_motion(run.scene, run.history, most)
    found = swings(motion.time, motion.angle, motion.shape.slenderness)
    if not found:
        return [Instant(float(t)) for t in np.linspace(first, last, 4)]
    if found[0].first == 0:
        return _after_release(run, most.name, last, end)
    largest = max(found, key=lambda swing: abs(swing.peak_rad))
    lift = Instant(float(motion.time[largest.first]), "lift-off")
    lost = {"overturned": overturned_at(run.history, most)}
    lost["off its carrier"] = fell_at(run.scene, run.history, most)
    fall, how = min(((t, how) for how, t in lost.items() if t is not None), default=(math.inf, ""))
    if fall < math.inf:
        middle = 0.5 * (lift.time_s + fall)
        return [lift, Instant(middle, "falling"), Instant(fall, how), Instant(last, "end")]
    top = Instant(largest.peak_s, "largest angle")
    if largest.last + 1 >= len(motion.time):
        return [lift, top, end]
    return [lift, top, Instant(float(motion.time[largest.last + 1]), "landing"), end]


def _after_release(run: Run, name: str, last: float, end: Instant) -> list[Instant]:
    """The instants of a block that leans at the start."""
    start = Instant(float(run.history["time_s"][0]), "release")
    block = run.summary["blocks"][name]
    impacts = [i["time_s"] for i in block["impacts"][:1]]
    after = [p["time_s"] for p in block["peaks"] if impacts and p["time_s"] > impacts[0]][:1]
    if not impacts or not after:
        return [start, *(Instant(float(t)) for t in np.linspace(start.time_s, last, 4)[1:3]), end]
    return [start, Instant(impacts[0], "landing"), Instant(after[0], "next peak"), end]
