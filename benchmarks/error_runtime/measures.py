"""Measures that runs of a scene are judged by: the numbers whose errors are computed."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from solver.errors import SceneError
from solver.history.history import History
from solver.reference.housner import housner
from solver.scene import BlockSpec, Scene
from solver.scene.checking import nearest, shown
from solver.types import Array

#: Angles are compared up to this time, s: later a rocking block amplifies round-off.
COMPARED_TIME = 1.0

#: Before the first impact means before this part of the time up to it.
SHARE_BEFORE_IMPACT = 0.9

#: What the measures are called; NAME is that of a block.
WORDS = {
    "platform.peak_drift_m": "peak drift of the platform",
    "NAME.first_impact_s": "time of the first impact",
    "NAME.third_impact_s": "time of the third impact",
    "NAME.first_peak_rad": "first peak after the release",
    "NAME.angle_before_impact_rad": "angle before the first impact, L2",
    "NAME.angle_rad": "angle up to 1 s, L2",
    "NAME.residual_slip_m": "residual slip",
    "NAME.peak_slip_m": "peak slip",
    "energy.lost_fraction": "energy lost by the end",
}


def words(measure: str, names: tuple[str, ...] = ()) -> str:
    """Name of a measure in words; blocks are named where there are several."""
    owner, _, column = measure.partition(".")
    text = WORDS.get(measure) or WORDS.get(f"NAME.{column}", measure)
    return f"{text} of {owner}" if len(names) > 1 and owner in names else text


def measures(
    scene: Scene, history: History, summary: Mapping[str, Any], every: float
) -> dict[str, Array]:
    """The measures of a run, by name; a time or a peak is one value, an angle many samples.

    Args:
        scene: What was run.
        history: Its history.
        summary: Its summary.
        every: Between two samples of an angle, s: a multiple of the step, so that none falls
            between two rows.
    """
    found: dict[str, Array] = {}
    if "platform" in summary:
        found["platform.peak_drift_m"] = _one(summary["platform"]["peak_drift_m"])
    for block in scene.blocks:
        known = summary["blocks"][block.name]
        modes = known["mode"].split("-")
        if "rock" in modes or "overturned" in modes:
            found |= _rocking(scene, block, history, known, every)
        if "slide" in modes:
            found[f"{block.name}.residual_slip_m"] = _one(known["residual_slip_m"])
            found[f"{block.name}.peak_slip_m"] = _one(known["peak_slip_m"])
    scale = summary["energy"]["scale_J"]
    if found and scale > 0:
        total, work = history["energy.total_J"], history["energy.input_J"]
        found["energy.lost_fraction"] = _one((total[0] + work[-1] - total[-1]) / scale)
    return found


def scale_of(measure: str, value: Array) -> float:
    """Scale that errors of a measure are divided by: its size; lost energy is a fraction."""
    return 1.0 if measure == "energy.lost_fraction" else float(np.linalg.norm(value))


def fits(measure: str, pattern: str) -> bool:
    """True if a pattern names a measure; it may leave out its owner and its unit."""
    column = measure.partition(".")[2]
    return pattern in (measure, column, re.sub(r"_(m|s|rad|fraction)$", "", column))


def check_patterns(patterns: Sequence[str]) -> None:
    """Refuse names that are those of no measure of any scene."""
    columns = [measure.partition(".")[2] for measure in WORDS]
    for pattern in patterns:
        column = pattern.rpartition(".")[2]
        if not any(fits(measure, column) for measure in WORDS):
            meant = nearest(column, columns)
            raise SceneError("--measures", shown(pattern), ", ".join(columns), meant)


def chosen(there: Sequence[str], patterns: Sequence[str]) -> tuple[list[str], list[str]]:
    """The measures that are asked for, in that order, and the names for which there is none.

    All of them where nothing is asked for, or nothing of it is there.
    """
    meant = [measure for pattern in patterns for measure in there if fits(measure, pattern)]
    missing = [p for p in patterns if not any(fits(measure, p) for measure in there)]
    return meant or list(there), missing


def before_impact(scene: Scene, block: BlockSpec) -> float:
    """Time up to which a block that is let go from a tilt rocks about one corner, s; 0 if unknown.

    Nine tenths of the rigid block's way to its first impact (Housner 1963), for a block alone on
    firm ground that does not move.
    """
    firm = not scene.carrier_moves and not scene.foundation.needs_mesh_engine
    alone = len(scene.blocks) == 1 and firm
    still = scene.motion is None and scene.gravity_tilt_deg == 0 and scene.gravity > 0
    if not (alone and still and 0 < abs(block.tilt) < block.shape.slenderness()):
        return 0.0
    end = scene.time.end
    found = housner(block.shape, gravity=scene.gravity, tilt=block.tilt, end=end, step=end)
    return SHARE_BEFORE_IMPACT * float(found.impacts[0]) if len(found.impacts) else 0.0


def _rocking(
    scene: Scene, block: BlockSpec, history: History, known: Mapping[str, Any], every: float
) -> dict[str, Array]:
    """Impacts, peaks and the angle of a block that rocks."""
    found = {}
    times = [impact["time_s"] for impact in known["impacts"]]
    angles = [peak["angle_rad"] for peak in known["peaks"]]
    for number, name in ((1, "first"), (3, "third")):
        if len(times) >= number:
            found[f"{block.name}.{name}_impact_s"] = _one(times[number - 1])
    first = 1 if block.tilt else 0  # the release counts as a peak
    if len(angles) > first:
        found[f"{block.name}.first_peak_rad"] = _one(angles[first])
    smooth = before_impact(scene, block)
    if smooth > 2 * every:
        found[f"{block.name}.angle_before_impact_rad"] = _sampled(history, block, smooth, every)
    end = min(COMPARED_TIME, scene.time.end)
    found[f"{block.name}.angle_rad"] = _sampled(history, block, end, every)
    return found


def _sampled(history: History, block: BlockSpec, end: float, every: float) -> Array:
    """The angle of a block at equal times up to `end`, rad."""
    count = int(end / every * (1 + 1e-12))
    at = every * np.arange(1, count + 1)
    return np.interp(at, history["time_s"], history[f"{block.name}.angle_rad"])


def _one(value: float) -> Array:
    return np.array([float(value)])
