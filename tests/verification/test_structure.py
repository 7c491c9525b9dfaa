"""Frames as structures: damping by ratio, base shear, drift of storeys, feet on springs."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from rockslip import Result, Scene, parse_scene, simulate
from solver.build.foundation import natural_period
from solver.errors import SceneError
from solver.run.describe import describe

G = 9.81

FRAME: dict[str, Any] = {
    "kind": "frame",
    "deck": {"width": 4.0, "height": 0.6},
    "column": {"width": 0.1},
    "storey": 3.0,
    "young": 3e10,
    "poisson": 0.2,
    "density": 2500.0,
    "cells": {"bay": 4, "column": 1, "deck": 1, "storey": 6},
}

PEBBLE: dict[str, Any] = {
    "width": 0.2,
    "height": 0.1,
    "mass": 1e-3,
    "model": "rigid",
}
"""A frame with this block on it is as good as empty."""

PULSE: dict[str, Any] = {"kind": "half_sine", "amplitude_g": 0.02, "duration": 0.2}


def scene(foundation: dict[str, Any], end: float, step: float, **more: Any) -> Scene:
    """The pebble, or another block, on a foundation."""
    tables = {
        "block": [PEBBLE | more.pop("block", {})],
        "plane": "stress",
        "foundation": foundation,
        "contact": {"friction": more.pop("friction", 1.0)},
        "time": {"end": end, "step": step},
    }
    return parse_scene(tables | more)


def run(scene: Scene) -> Result:
    """A run that completes and keeps its ledger."""
    result = simulate(scene)
    energy = result.summary["energy"]
    assert result.status == "completed"
    assert energy["ledger_error_fraction"] < 1e-8
    return result


def decrement(drift: Any, after: int) -> float:
    """Mean logarithmic decrement of a decaying vibration, from its turning points after a row."""
    free = drift[after:]
    inner = np.abs(free[1:-1])
    at = 1 + np.flatnonzero((inner > np.abs(free[:-2])) & (inner >= np.abs(free[2:])))
    peaks = np.log(np.abs(free[at]))
    return float(-2 * np.polyfit(np.arange(len(peaks)), peaks, 1)[0])


@pytest.mark.parametrize("ratio", [0.02, 0.05])
def test_free_vibration_of_a_frame_decays_by_its_damping_ratio(ratio: float) -> None:
    """The logarithmic decrement of the empty frame after a pulse, within 1 %.

    A light one: under its own weight it sways 0.6 % slower, and loses as much more in a cycle.
    """
    time = {"end": 1.6, "step": 2e-3, "rho_inf": 1.0}
    tables = FRAME | {"damping_ratio": ratio}
    damped = scene(tables, 1.6, 2e-3, motion=PULSE, gravity=1.0, time=time)
    assert natural_period(damped) > 100 * damped.time.step
    drift = run(damped).history["platform.drift_m"]
    exact = 2 * math.pi * ratio / math.sqrt(1 - ratio**2)
    assert decrement(drift, 150) == pytest.approx(exact, rel=0.01)
    assert f"{100 * ratio:g} % of critical at first sway" in describe(damped)


def test_damping_by_ratio_is_that_of_the_structure_alone() -> None:
    """`[damping]` goes on for blocks; a frame with both says so in one line."""
    table = {"stiffness": 1e-4}
    ratio = scene(FRAME | {"damping_ratio": 0.05}, 1.0, 1e-3, damping=table)
    assert ratio.foundation.sway_damping_ratio == 0.05
    with pytest.raises(SceneError, match=r"foundation\.damping_ratio: got both damping_ratio and"):
        scene(FRAME | {"damping_ratio": 0.05, "damping": table}, 1.0, 1e-3)
    with pytest.raises(SceneError, match=r"damping_ratio: got 1.0, allowed 0 <= damping_ratio < 1"):
        scene(FRAME | {"damping_ratio": 1.0}, 1.0, 1e-3)


def test_a_block_on_a_rigid_frame_does_not_feel_its_damping() -> None:
    """With or without, to 1e-12."""
    block = {"width": 0.25, "height": 1.0, "mass": 500.0}
    motion = {"kind": "half_sine", "amplitude_g": 0.4, "duration": 0.5}
    found = []
    for ratio in (0.0, 0.1):
        stiff = FRAME | {"young": 1e19, "damping_ratio": ratio}
        case = scene(stiff, 0.6, 2e-3, block=block, motion=motion, friction=0.2)
        found.append(run(case).history["block.slip_m"])
    assert np.abs(found[0]).max() > 1e-3
    np.testing.assert_allclose(found[1], found[0], atol=1e-12)
