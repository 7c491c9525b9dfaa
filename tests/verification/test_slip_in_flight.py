"""Slip of a block that is thrown up off a platform: what it moves along it, in the air as well."""

from __future__ import annotations

import numpy as np
import pytest

from rockslip import parse_scene, simulate

SCENE = """
{dimension}
[[block]]
width = 2.0
height = 0.5
mass = 1000.0
{block}
[foundation]
kind = "oscillator"
mass_ratio = 2.0
period = 0.5
damping_ratio = 0.05
[contact]
friction = 0.3
[motion]
kind = "sine"
amplitude_g = 0.3
period = 0.6
[motion.vertical]
kind = "sine"
amplitude_g = 1.6
period = 0.4
[time]
end = {end}
"""

RIGID = 'model = "rigid"'
MESHED = "young = 1e9\npoisson = 0.2\ncells = [4, 1]"


@pytest.mark.parametrize(
    ("dimension", "block", "end", "accuracy"),
    [
        pytest.param("", RIGID, 1.0, 1e-12, id="rigid, plane"),
        pytest.param("dimension = 3", RIGID + "\nthickness = 1.5", 1.0, 1e-12, id="rigid, space"),
        # vibration: the points that touch are not the centre
        pytest.param("", MESHED, 0.5, 2e-3, id="meshed", marks=pytest.mark.slow),
    ],
)
def test_slip_is_the_way_along_the_platform(
    dimension: str, block: str, end: float, accuracy: float
) -> None:
    """Slip is the way of the middle of the bottom, less the drift: the block hardly turns."""
    scene = parse_scene(SCENE.format(dimension=dimension, block=block, end=end))
    history = simulate(scene).history
    flies = history["contact_points_closed"][1:] == 0
    assert 0.2 < flies.mean() < 0.8
    bottom = history["block.centre_x_m"] - 0.25 * history["block.angle_rad"]
    way = bottom - bottom[0] - history["platform.drift_m"]
    slip = history["block.slip_m"]
    np.testing.assert_allclose(slip, way, rtol=0, atol=accuracy * np.abs(slip).max())
    assert np.abs(np.diff(slip)[flies]).sum() > 0.2 * np.abs(np.diff(slip)).sum()
