"""Random scenes of shapes, feet, uneven mass, links and forces: none fails, none gains energy."""

import pytest

from benchmarks.shapes import judge


@pytest.mark.parametrize("seed", range(1, 25))
def test_random_scenes_of_shapes_hold(seed: int) -> None:
    """`./in-env python3 -m benchmarks.shapes` runs 300 of them."""
    assert judge(seed).holds
