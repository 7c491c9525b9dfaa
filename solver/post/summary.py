"""The summary of a run: what is worth knowing without opening its history."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from solver.post import energy, rocking
from solver.post.history import History
from solver.scene import BlockSpec, Scene

#: Version of the layout of summary.json.
SCHEMA = 1


def summarise(
    scene: Scene,
    history: History,
    *,
    status: str,
    cost: Mapping[str, Any],
    versions: Mapping[str, str],
    reason: str = "",
    model: str = "finite elements",
) -> dict[str, Any]:
    """The content of summary.json.

    Args:
        scene: What was run.
        history: What came of it.
        status: "completed", "not converged" or "interrupted".
        cost: Seconds, steps, iterations, unknowns and ranks, by name.
        versions: Versions of the programs that were used, by name.
        reason: Why the run stopped early, in words.
        model: What the history comes from, as pictures name it.
    """
    blocks = {b.name: _block(b, scene, history) for b in scene.blocks} if len(history) else {}
    return {
        "schema": SCHEMA,
        "title": scene.title,
        "model": model,
        "status": status,
        "reason": reason,
        "end_s": float(history["time_s"][-1]) if len(history) else 0.0,
        "versions": dict(versions),
        "blocks": blocks,
        "energy": _energy(scene, history) if len(history) else {},
        "cost": dict(cost),
    }


def _block(block: BlockSpec, scene: Scene, history: History) -> dict[str, Any]:
    """What one block did."""
    time, angle = history["time_s"], history[f"{block.name}.angle_rad"]
    slip = history[f"{block.name}.slip_m"]
    lift = np.maximum(history[f"{block.name}.gap_left_m"], history[f"{block.name}.gap_right_m"])
    impacts = rocking.impacts(time, angle, block.shape, scene.gravity)
    peaks = rocking.peaks(time, angle, block.shape.slenderness)
    return {
        "mode": rocking.mode(angle, slip, lift, block.shape),
        "peak_angle_rad": float(np.max(np.abs(angle))),
        "peak_slip_m": float(np.max(np.abs(slip))),
        "residual_angle_rad": float(angle[-1]),
        "residual_slip_m": float(slip[-1]),
        "impacts": [{"time_s": i.time_s, "restitution": i.restitution} for i in impacts],
        "peaks": [{"time_s": at, "angle_rad": abs(value)} for at, value in peaks],
    }


def _energy(scene: Scene, history: History) -> dict[str, Any]:
    """How well energy was kept, and where it went."""
    total, work = history["energy.total_J"], history["energy.input_J"]
    tilt = math.radians(scene.gravity_tilt_deg)
    # The datum of gravity is the surface of the foundation at x = 0; a tilt turns it towards +x.
    upright = sum(
        b.shape.weight(scene.gravity) * (b.height / 2 * math.cos(tilt) - b.offset * math.sin(tilt))
        for b in scene.blocks
    )
    weight_height = sum(b.shape.weight(scene.gravity) * b.height for b in scene.blocks)
    scale = energy.scale(total, work, upright=upright, weight_height=weight_height)
    return {
        "scale_J": scale,
        "largest_gain_fraction": energy.largest_gain_fraction(total, work, scale),
        "ledger_error_fraction": energy.ledger_error_fraction(
            history["energy.ledger_error_J"], scale
        ),
        "loss": energy.losses(history),
    }


def write_json(file: Path, summary: Mapping[str, Any]) -> None:
    """Write a summary; numbers that are not known become null, since JSON has no nan."""
    text = json.dumps(_plain(summary), indent=2, allow_nan=False)
    file.write_text(text + "\n", encoding="utf-8")


def _plain(value: Any) -> Any:
    """The same in the types of JSON."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
