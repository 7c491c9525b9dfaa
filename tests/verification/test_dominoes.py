"""Five dominoes, each knocked over by the one before it."""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np
import pytest
from ledger import completed as run
from rigid import G
from scipy.integrate import solve_ivp

from benchmarks.rigid_world import scenes
from rockslip import History, parse_scene

pytestmark = pytest.mark.serial

#: Prototype at three steps; MuJoCo at 5e-5 s: .7275 1.1044 1.3365 1.5130 1.6526.
PAST = (0.72633, 1.10477, 1.33693, 1.51517, 1.65475)


@functools.cache
def fallen(d: int, step: float) -> History:
    """The history of the five."""
    return run(parse_scene(scenes.dominoes(d, step))).history


def past(history: History, block: int, degrees: float) -> float:
    """Time at which a domino first passes an angle, s, by a line between two rows."""
    d3 = f"n{block}.rotation_y_rad" in history
    angle = history[f"n{block}.rotation_y_rad" if d3 else f"n{block}.angle_rad"]
    k = int(np.argmax(angle > math.radians(degrees)))
    part = (math.radians(degrees) - angle[k - 1]) / (angle[k] - angle[k - 1])
    return float(
        history["time_s"][k - 1] + part * (history["time_s"][k] - history["time_s"][k - 1])
    )


@pytest.mark.parametrize(("d", "step"), [(2, 1e-3), (2, 5e-4), (2, 2e-4), (3, 1e-3)])
def test_dominoes_fall_in_time(d: int, step: float) -> None:
    """When each passes 20 degrees, the same for all steps and in space."""
    history = fallen(d, step)
    times = [past(history, k, 20.0) for k in range(1, 6)]
    assert times == pytest.approx(PAST, abs=1e-3)
    plane = [past(fallen(2, 2e-4), k, 20.0) for k in range(1, 6)]
    assert times == pytest.approx(plane, abs=1e-4)


def test_the_first_one_falls_as_housner_says() -> None:
    """Up to 15 degrees, before its blow: (4/3) R^2 theta'' = g R sin(theta - alpha)."""
    radius, alpha = math.hypot(0.1, 1.0) / 2, math.atan(0.1)

    def rate(time: float, y: Any) -> tuple[float, float]:
        return y[1], 0.75 * G / radius * math.sin(y[0] - alpha)

    def reached(time: float, y: Any) -> float:
        return float(y[0] - math.radians(15))

    found = solve_ivp(
        rate, (0, 1), [math.radians(8), 0.0], events=reached, rtol=1e-11, atol=1e-12
    ).t_events[0][0]
    assert found == pytest.approx(0.5433, abs=5e-5)
    for step in (1e-3, 2e-4):
        assert past(fallen(2, step), 1, 15.0) == pytest.approx(found, abs=3 * step**2 + 2e-7)
