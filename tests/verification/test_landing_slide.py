"""A block that lands flat while it slides: friction takes mu times the normal impulse, at once.

It is thrown up from the ground with V_n and sideways with V_t, and lands after 2 V_n/g. While it
slides on, its normal impulses up to t are m (g t - V_n), however long the landing takes, and

    v_t = V_t - mu (g t - V_n).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from rockslip import parse_scene, simulate

G = 9.81
MASS = 500.0
MU = 0.1
UP = 0.3
END = 0.1

PLATE = {"kind": "elastic", "width": 4.0, "height": 0.2, "density": 2400.0}
"""The ground of the meshed engine, fully restrained: as rigid as that of the others."""

MESH = {"young": 1e11, "poisson": 0.2, "cells": [2, 1]}

AZIMUTH = 0.3
"""Of the velocity in space, rad: along no edge."""


def landing(engine: str, speed: float, step: float) -> dict[str, Any]:
    """The scene; the block is too flat for friction to lift an edge."""
    size = {"width": 1.0, "height": 0.02, "thickness": 0.8, "mass": MASS, "model": "rigid"}
    velocity, tables = [speed, UP], {}
    if engine == "space":
        velocity = [speed * math.cos(AZIMUTH), speed * math.sin(AZIMUTH), UP]
        tables["dimension"] = 3
    elif engine == "meshed":
        tables["foundation"] = PLATE | MESH
    return tables | {
        "block": [size | {"velocity": velocity}],
        "contact": {"friction": MU},
        "damping": {"stiffness": 0.0},
        "time": {"end": END, "step": step},
        "output": {"fields": "none"},
    }


@pytest.mark.parametrize("engine", ["plane", "space", "meshed"])
@pytest.mark.parametrize("step", [1e-3, 4e-4])
@pytest.mark.parametrize("speed", [0.5, 2.0, 20.0])
def test_friction_of_a_landing_slide(engine: str, step: float, speed: float) -> None:
    """Velocity, path, and what friction and the impact take; no step gives friction back."""
    result = simulate(parse_scene(landing(engine, speed, step)))
    assert result.status == "completed"
    history = result.history
    across = history["block.slip_second_m"] if engine == "space" else 0.0
    path = np.hypot(history["block.slip_m"], across)
    after = speed - MU * (G * END - UP)
    assert np.diff(path)[-1] / step == pytest.approx(after + MU * G * step / 2, rel=1e-9)
    took = np.diff(history["energy.friction_J"])
    assert took.min() > -1e-9 * MASS * UP**2
    assert history["energy.kinetic_J"][-1] == pytest.approx(MASS * after**2 / 2, rel=1e-9)
    lost = MASS * (speed**2 - after**2) / 2
    assert took.sum() == pytest.approx(lost, rel=1e-9)
    assert history["energy.contact_J"][-1] == pytest.approx(MASS * UP**2 / 2, rel=1e-9)
    assert result.summary["energy"]["largest_gain_fraction"] < 1e-9
    assert result.summary["energy"]["ledger_error_fraction"] < 1e-10
