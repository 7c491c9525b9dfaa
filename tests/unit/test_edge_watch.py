"""Points that go to and fro over an edge in the corrections of a step."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from solver.stepping.active_set import MOST_CROSSED, EdgeWatch

pytestmark = pytest.mark.serial

INSIDE = None
FIRST, BOTH = np.array([True, False]), np.array([True, True])


def watch_of_two() -> EdgeWatch:
    """Two points on carriers without edges."""
    points: Any = SimpleNamespace(carriers=(), own=(), count=2)
    return EdgeWatch(points, ())


def test_what_stays_is_given_back_as_it_is():
    watch = watch_of_two()
    assert watch.settled(INSIDE) is None
    assert watch.settled(FIRST) is FIRST
    assert watch.settled(FIRST.copy()) is FIRST
    assert watch.settled(BOTH) is BOTH
    assert watch.settled(INSIDE) is None


def test_a_point_that_goes_to_and_fro_stays_beyond_and_others_come_back():
    watch = watch_of_two()
    for number in range(MOST_CROSSED):
        seen = watch.settled(BOTH if number % 2 == 0 else FIRST)
    assert not seen[1]  # eight crossings, the first of them from within
    assert watch.settled(BOTH)[1]
    assert (watch.settled(np.array([False, False])) == [False, True]).all()
    assert (watch.settled(INSIDE) == [False, True]).all()
