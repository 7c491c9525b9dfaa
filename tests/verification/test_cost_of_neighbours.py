"""What blocks cost that do not meet: as much as each alone."""

from __future__ import annotations

import time

import pytest

from benchmarks.rigid_world import scenes
from rockslip import parse_scene
from solver.rigid.system import RigidSystem

pytestmark = pytest.mark.serial


def seconds(count: int, d: int) -> float:
    """Least processor time of a block and a step, s, of so many far apart."""
    found = []
    for _ in range(3):
        system = RigidSystem(parse_scene(scenes.apart(count, d)))
        began = time.process_time()
        assert system.advance(300, 1e-3).failure is None
        found.append((time.process_time() - began) / (300 * count))
    return min(found)


@pytest.mark.parametrize("d", [2, 3])
def test_the_cost_of_blocks_far_apart_is_linear(d: int) -> None:
    """Loosely, as others may use the machine: `benchmarks/rigid_world/beside.py` measures it."""
    few = seconds(10, d)
    assert seconds(100, d) < 1.3 * few
    # One block has the rows of the ground and the energies for itself alone.
    assert seconds(1, d) < 3 * few
