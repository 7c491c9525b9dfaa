"""Random scenes of shapes, feet, uneven mass, links and forces: none fails, none gains energy."""

import numpy as np
import pytest

from benchmarks.shapes import LIMIT, case, random_scene
from benchmarks.stability.verdict import judge
from rockslip import parse_scene, simulate


@pytest.mark.parametrize("seed", range(1, 25))
def test_random_scenes_of_shapes_hold(seed: int) -> None:
    """`./in-env python3 -m benchmarks.shapes` runs 300 of them."""
    found = judge(case(seed), LIMIT)
    assert (found.verdict, found.reason) == ("holds", "") or found.verdict == "refused"
    assert not found.energy_gain >= 1e-9 and not found.ledger_error >= 1e-8


def test_what_is_symmetric_stays_so() -> None:
    """Two profiles of twelve sides that slide over each other in the plane of symmetry.

    Six corners bear where three do: friction turns the upper one unless they share alike.
    """
    scene = random_scene(9023)
    history = simulate(parse_scene(scene | {"time": scene["time"] | {"end": 1.0}})).history
    for block in ("b0", "b1", "b2"):
        for column in ("centre_y_m", "angle_x_rad", "angle_z_rad"):
            assert np.abs(history[f"{block}.{column}"]).max() < 1e-11
