"""What the image compiles beforehand."""

from __future__ import annotations

import pytest

from rockslip import parse_scene
from solver.law.switch import SHORT
from solver.run.warming import scenes


@pytest.mark.parametrize("dimension", [2, 3])
def test_scenes_of_each_kind_are_good_ones(dimension: int) -> None:
    """All foundations, rigid and elastic blocks, motions and laws; none would be interpreted."""
    found = {name: parse_scene(content) for name, content in scenes(dimension)}
    assert {type(scene.foundation).__name__ for scene in found.values()} >= {
        *("RigidSpec", "OscillatorSpec", "PlateSpec", "FrameSpec")
    }
    assert {scene.dimension for scene in found.values()} == {dimension}
    rigid = [scene for scene in found.values() if scene.is_rigid]
    assert rigid and all(scene.time.end / scene.time.step > SHORT for scene in rigid)
