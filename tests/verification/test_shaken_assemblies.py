"""Walls and a yard of rigid bodies under shaking: as one body, rattling, and whatever the step.

`benchmarks/rigid_world/shaken.py` shakes the walls for 20 s, and by a record.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from ledger import completed
from rigid import G
from scipy.optimize import brentq

from benchmarks.rigid_world import scenes
from rockslip import Result, parse_scene
from solver.types import Array

pytestmark = pytest.mark.serial


def shaken(
    tables: dict[str, Any], amplitude: float, period: float, end: float, dt: float
) -> Result:
    """Run a scene under a sine (amplitude in g); nothing fails, is gained or sinks in."""
    motion = {"kind": "sine", "amplitude_g": amplitude, "period": period, "cycles": 80}
    time = {"end": end, "step": dt}
    result = completed(
        parse_scene(tables | {"motion": motion, "time": time}), gain=1e-10, ledger=1e-10
    )
    assert result.summary["unsettled"] is None
    size = max(block["width"] for block in tables["block"])
    assert result.summary["deepest_penetration_m"] < 1e-9 * size
    return result


def moved(result: Result, row: int = -1) -> Array:
    """How far centres have moved sideways by a row, m."""
    names = [name for name in result.history.columns if name.endswith(".centre_x_m")]
    return np.array([result.history[name][row] - result.history[name][0] for name in names])


def first_slide(friction: float, amplitude: float, period: float, time: float) -> float:
    """Where a block on shaken ground has slipped to by a time in its first slide, m (Newmark)."""
    a, limit, w = amplitude * G, friction * G, 2 * math.pi / period
    begun = math.asin(limit / a) / w

    def velocity(t: float) -> float:
        return limit * (t - begun) + a / w * (math.cos(w * t) - math.cos(w * begun))

    last = min(time, float(brentq(velocity, begun + 0.05 * period, begun + 0.5 * period)))
    since = last - begun
    way = limit * since**2 / 2 + a / w**2 * (math.sin(w * last) - math.sin(w * begun))
    return way - a / w * math.cos(w * begun) * since


@pytest.mark.slow
def test_a_wall_slides_as_one_body() -> None:
    """100 bricks with joints of 2 mm, 0.3 g and 2 Hz, friction 0.25."""
    result = shaken(scenes.wall(10, 10, friction=0.25), 0.3, 0.5, 0.25, 1e-3)
    for row, known in ((125, -0.26380e-3), (250, -2.41249e-3)):
        exact = first_slide(0.25, 0.3, 0.5, 1e-3 * row)
        assert exact == pytest.approx(known, abs=1e-8)
        assert moved(result, row) == pytest.approx(exact, abs=1e-6)
        assert np.ptp(moved(result, row)) < 1e-10


@pytest.mark.slow
def test_a_wall_that_rattles() -> None:
    """100 bricks with joints of 2 mm, 0.8 g and 4 Hz: bricks part and strike each other."""
    result = shaken(scenes.wall(10, 10), 0.8, 0.25, 0.25, 1e-3)
    assert np.ptp(moved(result)) > 1e-4


@pytest.mark.slow
def test_a_yard_ends_at_one_place_whatever_the_step() -> None:
    """36 containers in stacks of three, 0.6 g and 1 Hz, far below 1 mm."""
    coarse, fine = (moved(shaken(scenes.yard(), 0.6, 1.0, 2.0, dt)) for dt in (1e-3, 5e-4))
    assert np.abs(fine).max() > 0.02
    assert coarse == pytest.approx(fine, abs=1e-5)
