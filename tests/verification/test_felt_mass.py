"""The mass that a platform feels of a block does not depend on the steps, nor on its neighbours."""

from __future__ import annotations

from typing import Any

import pytest

from rockslip import parse_scene, simulate

SLIDES = {"name": "slides", "model": "rigid", "width": 2.4, "height": 2.6, "mass": 20000.0}
ROCKS = {"name": "rocks", "model": "rigid", "width": 1.0, "height": 4.0, "mass": 5000.0}
PLATE = {
    **{"kind": "elastic", "support": "rollers", "width": 10.0, "height": 0.5, "period": 0.7},
    **{"density": 2500.0, "young": 3e10, "poisson": 0.2, "damping_ratio": 0.05},
    "cells": [6, 1],
}


def felt(time: dict[str, Any]) -> dict[str, float]:
    """Friction over mass ratios on a plate that is shaken until blocks slide and rock."""
    slides = SLIDES | {"thickness": 6.0, "friction": 0.25, "offset": -2.0}
    rocks = ROCKS | {"thickness": 6.0, "friction": 0.6, "offset": 2.0}
    tables = {
        "block": [slides, rocks],
        "foundation": PLATE,
        "motion": {"kind": "sine", "amplitude_g": 0.25, "period": 0.7, "cycles": 3},
        "time": {"end": 1.6, **time},
    }
    blocks = simulate(parse_scene(tables)).summary["blocks"]
    assert len(blocks["rocks"]["impacts"]) >= 2
    assert blocks["slides"]["mode"] == "slide"
    return {name: own["friction_mass_ratio"] for name, own in blocks.items()}


@pytest.mark.slow
def test_beside_a_block_that_rocks() -> None:
    """Rows beside its impacts are as large as steps are short: they once gave 0.004 for 0.19."""
    coarse, fine = felt({"step": 4e-3}), felt({"step": 2e-3})
    adaptive = felt({"tolerance": 1e-2, "adaptive": True, "step": 2e-3})
    for each in (coarse, adaptive):
        assert each["slides"] == pytest.approx(fine["slides"], rel=0.02)
    assert 0.1 < fine["slides"] < 0.9
