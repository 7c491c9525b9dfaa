"""Which points of a block touch what carries it, among meshed bodies."""

from __future__ import annotations

import numpy as np

from solver.run.block_observer import touching


def test_closed_points_touch_or_else_the_lowest_that_may() -> None:
    everyone, some = np.ones(4, dtype=bool), np.array([False, True, True, True])
    force, place = np.zeros((2, 4, 2))
    force[:, 0], place[:, 0] = [0.0, 2.0, 0.0, 1.0], [-1.0, 0.0, 0.0, 0.0]
    assert list(touching(force, place, everyone, 1e-9)) == [1, 3]
    place[:, 0] = [0.1, 0.3, 0.2, 0.2 + 1e-10]
    assert list(touching(0.0 * force, place, some, 1e-9)) == [2, 3]
    assert len(touching(0.0 * force, place, ~everyone, 1e-9)) == len(place)
