"""Assemblies of rigid bodies at rest: nothing creeps, nothing sinks in, forces balance.

`benchmarks/rigid_world/rest.py` has longer runs, and a wall of 1000 bricks.
"""

from __future__ import annotations

from collections.abc import Callable

import pytest

from benchmarks.rigid_world import scenes
from benchmarks.rigid_world.rest import Rest, rest
from rockslip import parse_scene

pytestmark = pytest.mark.serial


def cubes(seed: int) -> Rest:
    """Ten cubes on each other with random offsets and turns."""
    tables = scenes.cubes(seed)
    return rest(tables, 1.0, system=scenes.turned(parse_scene(tables), seed))


ASSEMBLIES: dict[str, Callable[[], Rest]] = {
    "wall, joints of 2 mm": lambda: rest(scenes.wall(10, 10), 0.5),
    "wall, closed joints": lambda: rest(scenes.wall(10, 10, joint=0.0), 0.5),
    "cubes 1": lambda: cubes(1),
    "cubes 2": lambda: cubes(2),
    "nine containers": lambda: rest(scenes.yard(3, 1), 1.0),
}


@pytest.mark.parametrize("name", ASSEMBLIES)
def test_nothing_creeps_or_sinks_in(name: str) -> None:
    found = ASSEMBLIES[name]()
    assert found.creep < 1e-10 / 8
    assert found.penetration < 1e-9


@pytest.mark.parametrize("name", ASSEMBLIES)
def test_forces_balance(name: str) -> None:
    """Each course gets the weight of itself and of all above it from below, and nothing else."""
    assert ASSEMBLIES[name]().unbalanced < 1e-10
