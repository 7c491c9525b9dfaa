"""Bodies without stress, gravity and loads that touch for the first time.

All that their residual holds before is round-off, and so is what the tolerance is made of.
"""

from __future__ import annotations

import numpy as np
import pytest

from solver.build.assembly import build
from solver.scene import parse_scene

SPEED, STEP, FLIGHT = 1.0, 1e-4, 20


@pytest.mark.parametrize("young", [5e7, 5e10])
@pytest.mark.parametrize(
    ("dimension", "cell", "degree"),
    [
        (2, "quadrilateral", 1),
        (2, "triangle", 2),
        (3, "hexahedron", 2),
        (3, "tetrahedron", 1),
        (3, "tetrahedron", 2),
    ],
)
@pytest.mark.parametrize("part", [1.0, 0.999995, 0.975], ids=["just", "grazing", "within"])
def test_a_body_that_touches_without_loads(
    dimension: int, cell: str, degree: int, young: float, part: float
) -> None:
    """It touches at the very end of a step, a little before, or within it; no step fails."""
    size = {"width": 0.3, "height": 0.4, "thickness": 0.3, "density": 2600.0, "poisson": 0.2}
    mesh = {"cell": cell, "degree": degree, "cells": [2] * dimension, "young": young}
    assembly = build(
        parse_scene(
            {
                "dimension": dimension,
                "gravity": 0.0,
                "block": [size | mesh],
                "contact": {"friction": 0.5, "points": "gauss"},
                "damping": {"stiffness": 0.0},
                "time": {"end": 1.0, "step": STEP},
            }
        )
    )
    stepper = assembly.stepper
    u = np.zeros((stepper.system.size // dimension, dimension))
    v = np.zeros_like(u)
    u[:, -1], v[:, -1] = part * FLIGHT * SPEED * STEP, -SPEED
    state = stepper.start(u.ravel(), v.ravel())
    energy = state.kinetic
    pressed = 0.0
    for _ in range(FLIGHT + 5):
        state, exchange = stepper.advance(state, STEP)
        pressed = max(pressed, float(state.contacts[0].force[:, 0].sum()))
        assert exchange.iterations < 10
    assert pressed > 0.0
    assert state.kinetic + state.strain < energy * (1 + 1e-9)
