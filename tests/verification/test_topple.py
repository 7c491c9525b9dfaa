"""Elastic blocks that overturn land on their side and stay there, whatever the step."""

from __future__ import annotations

import numpy as np
import pytest

from rockslip import Result, parse_scene, simulate

MATERIALS = {
    "marble": {"young": 5e10, "poisson": 0.25, "density": 2700.0},
    "timber": {"young": 1e10, "poisson": 0.3, "density": 600.0},
}

pytestmark = pytest.mark.serial


def topple(material: str, *, tolerance: float) -> Result:
    """A slender block with the default damping that begins next to its point of balance."""
    block = {"width": 0.25, "height": 1.0, "thickness": 0.75, "cells": [3, 8]}
    block |= {**MATERIALS[material], "tilt_deg": 13.0, "angular_velocity": 0.5}
    tables = {
        "block": [block],
        "contact": {"friction": 0.5},
        "time": {"end": 1.6, "tolerance": tolerance},
        "output": {"fields": "none"},
    }
    return simulate(parse_scene(tables))


@pytest.mark.slow
@pytest.mark.parametrize("material", MATERIALS)
def test_a_toppled_block_lands_and_stays_down(material: str) -> None:
    landings = []
    for tolerance in (1e-3, 2.5e-4):
        result = topple(material, tolerance=tolerance)
        time, angle = result.history["time_s"], np.degrees(result.history["block.angle_rad"])
        landing = int(np.flatnonzero(angle > 89)[0])
        landings.append(time[landing])
        assert angle[landing:].min() > 85, "it does not stand up again"
        assert angle[-1] == pytest.approx(90, abs=0.05)
        block, energy = result.summary["blocks"]["block"], result.summary["energy"]
        assert block["mode"] == "overturned"
        assert energy["largest_gain_fraction"] < 1e-6
        assert energy["ledger_error_fraction"] < 1e-8
    assert landings[0] == pytest.approx(landings[1], rel=2e-3)
