"""Gaps, forces and arrows of a block that has fallen off another one: those over level ground."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rockslip import parse_scene, read_run, simulate


def both(dimension: int, **up: Any) -> dict[str, Any]:
    """A tower of two blocks."""
    low = {"name": "low", "width": 0.3, "height": 0.9, "mass": 200.0}
    top = {"name": "up", "on": "low", "width": 0.3, "height": 0.6, "mass": 100.0} | up
    same = {"model": "rigid", "thickness": 0.5}
    return {
        "dimension": dimension,
        "block": [low | same, top | same],
        "contact": {"friction": 0.5},
        "time": {"end": 3.0, "step": 1e-3},
    }


@pytest.mark.parametrize("dimension", [2, 3])
def test_beside_a_carrier_that_lies(dimension: int) -> None:
    """Both have toppled and lie on the floor, which carries 100 kg without friction."""
    tables = both(dimension)
    tables["motion"] = {"kind": "half_sine", "amplitude_g": 0.9, "duration": 0.5}
    history = simulate(parse_scene(tables)).history
    assert abs(history["low.angle_rad" if dimension == 2 else "low.angle_y_rad"][-1]) > 1.5
    last = history["time_s"] > 2.8
    normal = history["up.normal_force_N"][last]
    np.testing.assert_allclose(normal.mean(), 981.0, rtol=1e-3)
    assert np.abs(history["up.friction_force_N"][last]).max() < 5.0
    corners = ("left", "right") if dimension == 2 else ("1", "2", "3", "4")
    gaps = np.array([history[f"up.gap_{corner}_m"][-1] for corner in corners])
    assert gaps.min() == pytest.approx(0.0, abs=1e-3)


def test_arrows_of_films_stand_upright(tmp_path: Path) -> None:
    """On the floor, whatever way the carrier leans by then."""
    from solver.pictures.contact import block_frames

    tables = both(2, height=0.2, velocity=[2.5, 0.0], friction=0.0)
    tables["block"][0] |= {"tilt_deg": -17.0, "friction": 2.0}
    simulate(parse_scene(tables), folder=tmp_path / "out")
    run = read_run(tmp_path / "out")
    up = run.scene.blocks[1]
    times = np.linspace(2.5, 3.0, 6)
    arrows = block_frames(run, up, times).push.force
    assert abs(run.history["low.angle_rad"][-1]) > 0.01
    np.testing.assert_allclose(arrows, np.tile([0.0, 1.0], (6, 1)), atol=1e-3)
