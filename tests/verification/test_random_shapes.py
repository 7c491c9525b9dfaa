"""Random scenes of shapes, feet, uneven mass, links and forces: none fails, none gains energy."""

import pytest

from benchmarks.shapes import LIMIT, case
from benchmarks.stability.verdict import judge


@pytest.mark.parametrize("seed", range(1, 25))
def test_random_scenes_of_shapes_hold(seed: int) -> None:
    """`./in-env python3 -m benchmarks.shapes` runs 300 of them."""
    found = judge(case(seed), LIMIT)
    assert (found.verdict, found.reason) == ("holds", "") or found.verdict == "refused"
    assert not found.energy_gain >= 1e-9 and not found.ledger_error >= 1e-8
