"""Cohesion holds c times the area in which two faces touch, in every engine."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rockslip import parse_scene, simulate

pytestmark = pytest.mark.serial

G, COHESION = 9.81, 2000.0
SIZE = {"width": 0.8, "height": 0.1, "thickness": 0.5, "density": 2000.0}
HOLD = COHESION / (SIZE["density"] * SIZE["height"] * G)
"""Acceleration over gravity that cohesion under the whole bottom holds: 1.02."""


def slips(engine: str, pull: float, share: float) -> bool:
    """True if a smooth block slides, pulled by a part of its weight.

    Args:
        engine: "plane", "space" or "meshed" (beside a held meshed plate, rigid and elastic blocks).
        pull: Acceleration of the ground over gravity.
        share: Of its bottom that is on what carries it; less than 1: it stands out over a block.
    """
    block: dict[str, Any] = {"name": "top", "model": "rigid"} | SIZE
    block["friction"] = {"static": 0.0, "cohesion": COHESION}
    blocks = [block]
    if share < 1.0:
        base = {"name": "below", "model": "rigid", "density": 8000.0, "friction": 9.0}
        base |= {"width": 0.8, "height": 0.1, "thickness": 0.5}
        blocks = [base, block | {"on": "below", "offset": (share - 1.0) * SIZE["width"]}]
    table: dict[str, Any] = {
        "dimension": 3 if engine == "space" else 2,
        "block": blocks,
        "motion": {"kind": "rectangular", "amplitude_g": pull, "duration": 1.0},
        "damping": {"stiffness": 0.0},
        "time": {"end": 0.03, "step": 1e-3},
        "output": {"fields": "none"},
    }
    if engine == "meshed":
        table["foundation"] = {"kind": "elastic", "width": 4.0, "height": 0.2, "density": 2400.0}
        table["foundation"] |= {"young": 1e11, "poisson": 0.2, "cells": [2, 1]}
    if engine == "elastic":
        block |= {"model": "elastic", "young": 1e10, "poisson": 0.2, "cells": [8, 2]}
    result = simulate(parse_scene(table))
    assert result.status == "completed"
    return bool(np.abs(result.history["top.slip_m"][-1]) > 1e-6)


@pytest.mark.parametrize("engine", ["plane", "space", "meshed", "elastic"])
def test_cohesion_lets_go_at_the_same_force(engine: str) -> None:
    assert not slips(engine, 0.98 * HOLD, 1.0)
    assert slips(engine, 1.02 * HOLD, 1.0)


@pytest.mark.parametrize("engine", ["plane", "space"])
def test_a_block_that_stands_out_holds_by_what_is_on_its_carrier(engine: str) -> None:
    """At 0.6 the pulled block, whose centre is over its carrier, neither tips nor lifts."""
    assert not slips(engine, 0.98 * 0.6 * HOLD, 0.6)
    assert slips(engine, 1.02 * 0.6 * HOLD, 0.6)
