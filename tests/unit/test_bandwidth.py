"""The highest frequency of a motion: what its power says."""

from __future__ import annotations

import math
from typing import Any

from rockslip import parse_scene
from solver.excitation.motion import read_ground
from solver.excitation.spectrum import highest_frequency


def highest(motion: dict[str, Any], end: float) -> float:
    """Highest frequency of the motion of a scene, Hz."""
    block = {"width": 0.5, "height": 1.0, "mass": 100.0, "model": "rigid"}
    scene = parse_scene({"block": [block], "motion": motion, "time": {"end": end}})
    return highest_frequency(read_ground(scene), end) / (2 * math.pi)


def test_a_sine_has_its_own_frequency() -> None:
    """And, since it begins and ends, a little beside it, whether after whole periods or not."""
    sine = {"kind": "sine", "amplitude_g": 0.3, "period": 0.25}
    for end in (10.0, 10.07):
        assert 4.0 <= highest(sine, end) < 6.0


def test_a_motion_that_goes_on_is_no_faster_for_it() -> None:
    """A run that ends in the middle of a record: less than twice the frequency of all of it."""
    record = {"kind": "synthetic", "magnitude": 6.5, "distance_km": 10.0, "seed": 3}
    whole, part = (highest(record, end) for end in (40.0, 3.0))
    assert 5.0 < part < 2 * whole
    assert whole < 100.0


def test_ground_at_rest_has_none() -> None:
    """0, in Hz."""
    assert highest({"kind": "none"}, 1.0) == 0.0
