"""Assemblies at rest: how far they creep, how well forces balance, how deep bodies sink in.

    ./in-env python3 -m benchmarks.rigid_world.rest

Eight seconds of walls of 100 and 1000 bricks, of ten cubes and of nine containers; the wall of 1000
takes minutes. Prints a line for each. `tests/verification/test_rest.py` has shorter runs.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.rigid_world import scenes
from rockslip import parse_scene
from solver.rigid.system import RigidSystem


@dataclass(frozen=True, slots=True, kw_only=True)
class Rest:
    """How well bodies in courses rest on level ground."""

    creep: float
    """Largest way of a centre, m, or turn, rad."""
    unbalanced: float
    """Largest force on a course and all above it, over the least weight."""
    penetration: float
    """Deepest overlap, over the least edge."""


def rest(tables: dict[str, Any], end: float, *, system: RigidSystem | None = None) -> Rest:
    """A scene at rest up to a time in steps of 1 ms; `system`: as it is set up otherwise."""
    dt, chunk = 1e-3, 200
    system = system or RigidSystem(parse_scene(tables))
    blocks = range(len(system.names))
    places = [(system.centre(k), system.rotation(k)) for k in blocks]
    sinks = [k for k, name in enumerate(system.columns) if name.endswith(".penetration_m")]
    deepest, left = 0.0, round(end / dt)
    while left:
        taken = min(left, chunk)
        done = system.advance(taken, dt)
        if done.failure:
            raise RuntimeError(done.failure)
        left -= taken
        deepest = max(deepest, float(done.rows[:, sinks].max()))
    creep = max(
        float(max(np.abs(system.centre(k) - place).max(), np.abs(system.rotation(k) - turn).max()))
        for k, (place, turn) in zip(blocks, places, strict=True)
    )
    last = dict(zip(system.columns, done.rows[-1], strict=True))
    return Rest(
        creep=creep,
        unbalanced=_unbalanced(tables, system, last),
        penetration=deepest
        / min(min(block["width"], block["height"]) for block in tables["block"]),
    )


def _unbalanced(tables: dict[str, Any], system: RigidSystem, last: dict[str, Any]) -> float:
    """The force that a course gets from below is the weight of all that is not below it."""
    kinds = ("normal_force", "friction_force", "friction_force_second")[: system.dimension]
    weight = np.array([scenes.weight(block) for block in tables["block"]])
    level = np.round([system.centre(k)[-1] for k in range(len(weight))], 6)
    force = np.array([[last[f"{name}.{kind}_N"] for kind in kinds] for name in system.names])
    off = []
    for course in np.unique(level):
        total = force[level == course].sum(axis=0)
        total[0] -= weight[level >= course].sum()
        off.append(np.abs(total).max())
    return float(max(off) / weight.min())


def main() -> None:
    """Run all and print."""
    cubes = scenes.cubes(1)
    for name, tables, system in (
        ("ten cubes", cubes, scenes.turned(parse_scene(cubes), 1)),
        ("nine containers", scenes.yard(3, 1), None),
        ("wall of 100, joints of 2 mm", scenes.wall(10, 10), None),
        ("wall of 100, closed joints", scenes.wall(10, 10, joint=0.0), None),
        ("wall of 1000, joints of 2 mm", scenes.wall(40, 25), None),
        ("wall of 1000, closed joints", scenes.wall(40, 25, joint=0.0), None),
    ):
        print(f"{name}: {rest(tables, 8.0, system=system)}", flush=True)


if __name__ == "__main__":
    main()
