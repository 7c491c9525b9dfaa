"""Assemblies of rigid bodies at rest: nothing creeps, nothing sinks in, forces balance.

`benchmarks/rigid_world/rest.py` has longer runs, and a wall of 1000 bricks.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.rigid_world import scenes
from benchmarks.rigid_world.rest import Rest, rest
from rockslip import load_scene, parse_scene, read_run, simulate
from solver.history.pairs import force_on_first

pytestmark = pytest.mark.serial

CASK = Path(__file__).parents[2] / "demos" / "gallery" / "cask.toml"


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
    assert found.creep < 1e-10 / 16  # of half a second; 1e-10 m in 8 s
    assert found.penetration < 1e-9


@pytest.mark.parametrize("name", ASSEMBLIES)
def test_forces_balance(name: str) -> None:
    """Each course gets the weight of itself and of all above it from below, and nothing else."""
    assert ASSEMBLIES[name]().unbalanced < 1e-10


@pytest.mark.parametrize(
    "tables",
    [scenes.wall(10, 10), scenes.wall(10, 10, joint=0.0), scenes.cubes(1), scenes.yard(3, 1)],
    ids=["wall, joints of 2 mm", "wall, closed joints", "cubes", "nine containers"],
)
def test_forces_and_moments_on_each_body_balance(tables: dict[str, Any], tmp_path: Path) -> None:
    """What its neighbours do to each, and its weight; moments over that of the least weight."""
    output = {"pairs": True, "fields": "none", "history_every": 20}
    scene = parse_scene(tables | {"output": output, "time": {"end": 0.2, "step": 1e-3}})
    simulate(scene, folder=tmp_path)
    run, d = read_run(tmp_path), scene.dimension
    weights = {block["name"]: scenes.weight(block) for block in tables["block"]}
    axes = "xyz"[:d]
    places = {
        name: np.array([run.history[f"{name}.centre_{axis}_m"][-1] for axis in axes])
        for name in weights
    }
    forces = {name: -weight * np.eye(d)[-1] for name, weight in weights.items()}
    moments = {name: 0.0 for name in weights}
    for names, pair in run.pairs().items():
        place = np.array([pair[f"{axis}_m"][-1] for axis in axes])
        force = force_on_first(pair)[-1]
        for name, sign in zip(names, (1.0, -1.0), strict=True):
            if name in weights:
                arm = place - places[name]
                forces[name] = forces[name] + sign * force
                moments[name] += sign * (arm[0] * force[-1] - arm[-1] * force[0])
    least = min(weights.values())
    assert max(np.abs(force).max() for force in forces.values()) < 1e-10 * least
    assert max(map(abs, moments.values())) < 1e-10 * least


def test_a_cask_lifts_where_the_resultant_leaves_its_foot() -> None:
    """Until then the 48 corners of its foot, of which three would do, obey the law of contact."""
    scene = load_scene(CASK, ["time.end=0.848", "output.fields=none"])
    history = simulate(scene).history
    names = "base.acceleration_m_s2", "base.second_acceleration_m_s2"
    pushed = -np.stack([history[name] for name in names], axis=1)
    radius, corners = 0.22, 48
    sides = 2.0 * np.pi * (np.arange(corners) + 0.5) / corners
    outwards = pushed @ np.array([np.cos(sides), np.sin(sides)])
    beyond = history["cask.centre_z_m"][0] / 9.81 * outwards.max(axis=1)
    inside = beyond < radius * np.cos(np.pi / corners)
    moves = history["cask.angle_rad"] > 1e-13
    assert moves.any() and np.argmax(moves) == np.argmax(~inside)
