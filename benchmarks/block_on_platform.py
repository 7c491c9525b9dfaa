"""A block that slides on a platform: rigid and elastic, on the oscillator and on the meshed plate.

    ./in-env python3 benchmarks/block_on_platform.py [--processes 2]

The case T2 of docs/error_runtime.md: xi 0.05, mass ratio 2, period 0.5 s,
0.4 g sin(2 pi t/0.6) for six cycles,
6 s in all, over time steps from 2e-3 to 1e-4 s. Writes `benchmarks/block_on_platform.csv`, one row
a run, against the event-driven reference. `alternation` is the largest second difference of the
platform's acceleration while the block sticks, in parts of its peak: 4 would be an acceleration
that alternates with its full size; an elastic block rings after each stop, which shows here too.
"""

from __future__ import annotations

import itertools
import math
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.rows import parallel_map, processes_wanted, write_table
from rockslip import Scene, parse_scene, simulate
from solver.reference.sliding import SlidingReference, sliding

TABLE = Path(__file__).with_suffix(".csv")

GRID = {
    "step": (2e-3, 1e-3, 5e-4, 2e-4, 1e-4),
    "model": ("rigid", "elastic"),
    "platform": ("oscillator", "plate"),
    "friction": (0.1, 0.3),
}

ELASTIC = {"young": 5e10, "poisson": 0.2, "cells": [4, 2]}
SPRING = {"mass_ratio": 2.0, "period": 0.5, "damping_ratio": 0.05}
PLATFORMS = {
    "oscillator": {"kind": "oscillator"} | SPRING,
    "plate": {
        "kind": "elastic",
        "support": "rollers",
        "width": 3.0,
        "height": 0.3,
        "young": 5e10,
        "poisson": 0.2,
        "cells": [16, 2],
    }
    | SPRING,
}


def scene_of(point: dict[str, Any]) -> Scene:
    """The scene of one point of the grid; a squat block that cannot rock."""
    block = {"width": 1.0, "height": 0.5, "thickness": 1.0, "mass": 1000.0}
    block |= {"model": "rigid"} if point["model"] == "rigid" else ELASTIC
    return parse_scene(
        {
            "block": [block],
            "foundation": PLATFORMS[point["platform"]],
            "contact": {"friction": point["friction"]},
            "motion": {"kind": "sine", "amplitude_g": 0.4, "period": 0.6, "cycles": 6},
            "damping": {"stiffness": 0.0},
            "time": {"end": 6.0, "step": point["step"]},
        }
    )


def reference_of(scene: Scene) -> SlidingReference:
    """Reference answer, event by event."""
    law, gravity = scene.friction_of(scene.blocks[0]), scene.gravity

    def ground(time: float) -> float:
        return 0.4 * gravity * math.sin(2 * math.pi * time / 0.6) if time <= 3.6 else 0.0

    return sliding(
        platform=scene.platform(),
        mass=scene.blocks[0].shape.mass,
        friction=law.static,
        gravity=gravity,
        acceleration=ground,
        end=scene.time.end,
        step=1e-3,
    )


def alternation(time: Any, acceleration: Any, reference: SlidingReference) -> float:
    """Largest second difference of the acceleration while the block sticks, over its peak.

    Two hundredths of a second at either end of sticking are left out: kinks belong there.
    """
    still = np.interp(time, reference.time, np.abs(reference.slip_velocity)) == 0.0
    margin = max(2, round(0.02 / (time[1] - time[0])))
    inside = np.convolve(still, np.ones(2 * margin + 1), "same") > 2 * margin + 0.5
    second = np.abs(np.diff(acceleration, 2))[inside[1:-1]]
    return float(np.max(second, initial=0.0) / np.max(np.abs(acceleration)))


def run(point: dict[str, Any]) -> dict[str, Any]:
    """One row of the table."""
    scene = scene_of(point)
    reference, result = reference_of(scene), simulate(scene)
    history, cost = result.history, result.summary["cost"]
    drift = float(np.abs(history["platform.drift_m"]).max())
    slip = float(history["block.slip_m"][-1])
    exact = float(np.abs(reference.drift).max()), float(reference.slip[-1])
    rough = alternation(history["time_s"], history["platform.acceleration_m_s2"], reference)
    return {
        **point,
        "status": result.status,
        "peak_drift_m": f"{drift:.6f}",
        "peak_drift_error": f"{drift / exact[0] - 1:.2e}",
        "final_slip_m": f"{slip:.6f}",
        "final_slip_error": f"{slip / exact[1] - 1:.2e}",
        "alternation": f"{rough:.1e}",
        "ledger_error_fraction": f"{result.summary['energy']['ledger_error_fraction']:.1e}",
        "rejected_steps": cost["rejected_steps"],
        "milliseconds_a_step": f"{1e3 * cost['wall_s'] / cost['steps']:.2f}",
    }


def points() -> Iterator[dict[str, Any]]:
    """Every point of the grid, the cheap ones first."""
    for values in itertools.product(*GRID.values()):
        yield dict(zip(GRID, values, strict=True))


def main() -> int:
    """Run all; 0 where every run completed."""
    processes = processes_wanted(__doc__)
    rows = write_table(
        TABLE, parallel_map(run, list(points()), processes=processes, name="platform")
    )
    failed = [row for row in rows if row["status"] != "completed"]
    sys.stdout.write(f"{len(rows) - len(failed)} of {len(rows)} runs; table in {TABLE}\n")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
