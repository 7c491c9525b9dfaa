"""Rigid blocks over ground that also heaves: the engine beside Housner's equation with g + a_v."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from rockslip import Scene, parse_scene, simulate
from solver.reference.answer import ROCKING, SLIDING, reference_history, reference_name

SIZE = {"width": 0.25, "height": 1.0, "thickness": 0.75, "mass": 503.0, "model": "rigid"}
HEAVE = {"vertical": {"kind": "sine", "amplitude_g": 0.3, "period": 0.23, "cycles": 6}}
PUSH = {"kind": "sine", "amplitude_g": 0.3, "period": 0.6, "cycles": 2}


def scene(motion: dict[str, Any], friction: float = 0.7, **block: Any) -> Scene:
    """The paper's block over the ground."""
    return parse_scene(
        {
            "block": [SIZE | block],
            "contact": {"friction": friction},
            "motion": motion,
            "time": {"end": 1.2, "step": 2e-4},
        }
    )


@pytest.mark.parametrize(
    ("asked", "name"),
    [
        (scene({"kind": "none"} | HEAVE, tilt_deg=3.0), ROCKING),
        (scene({"kind": "none"} | HEAVE, tilt_deg=3.0, restitution=0.936), ROCKING),
        (scene(PUSH | HEAVE), ROCKING),
        (scene(PUSH | HEAVE, friction=0.2), SLIDING),
    ],
    ids=["free", "restitution", "pushed", "sliding"],
)
def test_the_rigid_engine_follows_the_equation(asked: Scene, name: str) -> None:
    """Angle, place and every energy; the ground's work is that of both its directions."""
    assert reference_name(asked) == name
    result, exact = simulate(asked), reference_history(asked)
    history = result.history
    assert result.summary["energy"]["largest_gain_fraction"] < 1e-9
    assert result.summary["energy"]["ledger_error_fraction"] < 1e-10
    angle, slip = exact["block.angle_rad"], exact["block.slip_m"]
    assert np.abs(angle).max() > 0.01 if name == ROCKING else np.abs(slip).max() > 0.01
    for column in ("angle_rad", "centre_x_m", "centre_y_m", "slip_m"):
        own = f"block.{column}"
        np.testing.assert_allclose(history[own], exact[own], atol=3e-6, err_msg=column)
    scale = max(np.abs(exact[f"energy.{part}_J"]).max() for part in ("kinetic", "input"))
    for part in ("kinetic", "gravity", "input", "friction", "total"):
        column = f"energy.{part}_J"
        np.testing.assert_allclose(history[column], exact[column], atol=2e-3 * scale)


def test_a_heave_changes_when_it_lands() -> None:
    """Downwards the ground gives way: the block falls more slowly, and lands later."""
    down = {"kind": "rectangular", "amplitude_g": -0.3, "duration": 1.0}
    asked = scene({"kind": "none", "vertical": down}, tilt_deg=3.0)
    first = simulate(asked).summary["blocks"]["block"]["impacts"][0]["time_s"]
    assert first == pytest.approx(0.1916 / math.sqrt(0.7), rel=1e-3)
