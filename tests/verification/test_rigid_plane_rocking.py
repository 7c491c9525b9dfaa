"""Rigid blocks that rock, tip over and fly, against Housner (1963) and closed forms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from rockslip import Result, Scene, parse_scene, simulate


def scene(step: float, end: float, **block: Any) -> Scene:
    """The paper's block on a rigid floor, with changes."""
    size = {"width": 0.25, "height": 1.0, "thickness": 0.75, "mass": 503.0, "model": "rigid"}
    return parse_scene(
        {
            "block": [size | block],
            "contact": {"friction": 0.7},
            "time": {"end": end, "step": step},
        }
    )


def nothing_from_nothing(result: Result, energy: float = 1e-9) -> None:
    """The run completed, gained no energy, and its ledger closes."""
    assert result.status == "completed"
    assert result.summary["energy"]["largest_gain_fraction"] < energy
    assert result.summary["energy"]["ledger_error_fraction"] < 1e-10


def test_reactions_do_not_alternate() -> None:
    """Between two impacts the normal force is that of a block that turns about its corner."""
    result = simulate(scene(1e-3, 0.5, tilt_deg=3.0))
    history = result.history
    swing = (history["time_s"] > 0.25) & (history["time_s"] < 0.45)
    height, weight = history["block.centre_y_m"], 503.0 * 9.81
    lifted = np.gradient(np.gradient(height, 1e-3), 1e-3)[swing]
    force = history["block.normal_force_N"][swing]
    assert np.abs(force - weight - 503.0 * lifted).max() < 1e-3 * weight


def test_tipping_over_it_comes_to_lie_on_its_side() -> None:
    """From 16 degrees, beyond the slenderness of 14.04: at 90 degrees, at rest, on its side."""
    result = simulate(scene(1e-3, 3.0, tilt_deg=16.0))
    history = result.history
    assert result.summary["blocks"]["block"]["mode"] == "overturned"
    assert math.degrees(history["block.angle_rad"][-1]) == pytest.approx(90.0, abs=1e-6)
    assert history["block.centre_y_m"][-1] == pytest.approx(0.125, abs=1e-9)
    assert history["block.normal_force_N"][-1] == pytest.approx(503.0 * 9.81, rel=1e-9)
    nothing_from_nothing(result)


def test_a_vertical_pulse_above_1_g_throws_it_up() -> None:
    """Half a sine of 3 g downwards: the block is left behind, flies, and lands where it stood."""
    tables = scene(1e-3, 1.0).to_dict()
    pulse = {"kind": "half_sine", "amplitude_g": -3.0, "duration": 0.1}
    tables["motion"] = {"kind": "none", "vertical": pulse}
    result = simulate(parse_scene(tables))
    history, g = result.history, 9.81
    # Free from where 3 g sin(pi t/T) = g on: twice integrated over the ground's motion.
    rate = math.pi / 0.1
    start = math.asin(1 / 3) / rate

    def gap(time: float) -> float:
        """Height over the ground while both move freely and the pulse lasts, m."""
        since = time - start
        ground = 3 * g * (math.sin(rate * time) - math.sin(rate * start)) / rate**2
        return 3 * g * math.cos(rate * start) / rate * since - ground - g * since**2 / 2

    top = history["block.gap_left_m"]
    assert np.interp(0.08, history["time_s"], top) == pytest.approx(gap(0.08), rel=2e-3)
    assert top.max() > 0.09
    assert abs(top[-1]) < 1e-9 and abs(history["block.slip_m"][-1]) < 1e-9
    assert history["block.normal_force_N"][-1] == pytest.approx(503.0 * g, rel=1e-9)
    nothing_from_nothing(result, energy=1e-5)
