"""Times and accuracy of rigid bodies that meet each other, beside MuJoCo.

    ./in-env python3 -m benchmarks.rigid_world.beside [--mujoco PYTHON] [NAME ...]

`--mujoco` names a Python that has mujoco, in an environment of its own (`python3 -m venv DIR &&
DIR/bin/pip install mujoco`); without it this program runs alone. Writes
`benchmarks/rigid_world.csv`, a row for each scene and program: processor time a step with the rows
of the history, deepest overlap, largest way of a centre. Run it on a machine that does nothing
else.
"""

from __future__ import annotations

import argparse
import json
import math
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.rigid_world import scenes
from benchmarks.rows import Row, write_table
from rockslip import Scene, parse_scene
from solver.rigid.system import RigidSystem, centre_of
from solver.run.rigid import STEPS_AT_ONCE

TABLE = Path(__file__).resolve().parents[1] / "rigid_world.csv"
PEER = Path(__file__).with_name("peer.py")


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """A scene, how long it runs, and how its ground moves."""

    tables: Callable[[], dict[str, Any]]
    steps: int
    dt: float = 1e-3
    amplitude: float = 0.0
    """Of a sine of the ground, m/s2."""
    frequency: float = 1.0
    """1/s."""
    past: float = 0.0
    """Angle, rad, whose passing is noted for each block; 0: none."""


def one(d: int) -> dict[str, Any]:
    """The paper's block, tilted by three degrees; in space towards a corner."""
    tables = scenes.apart(1, d)
    if d == 3:
        tables["block"][0]["tilt_direction_deg"] = 30.0
    return tables


SHAKEN = {"amplitude": 0.3 * scenes.G, "frequency": 2.0}
CASES = {
    "rocking block, plane": Case(tables=lambda: one(2), steps=30000, dt=1e-4),
    "rocking block, space": Case(tables=lambda: one(3), steps=10000, dt=1e-4),
    "dominoes, plane": Case(tables=scenes.dominoes, steps=1800, past=math.radians(20)),
    "dominoes, space": Case(tables=lambda: scenes.dominoes(3), steps=1800),
    "wall of 100, rest": Case(tables=lambda: scenes.wall(10, 10), steps=5000),
    "wall of 100, 0.3 g": Case(tables=lambda: scenes.wall(10, 10), steps=2000, **SHAKEN),
    "wall of 1000, rest": Case(tables=lambda: scenes.wall(40, 25), steps=300),
    "wall of 1000, 0.3 g": Case(tables=lambda: scenes.wall(40, 25), steps=300, **SHAKEN),
    "yard of 36, 0.6 g": Case(tables=scenes.yard, steps=5000, amplitude=0.6 * scenes.G),
    **{
        f"{count} blocks far apart": Case(tables=lambda count=count: scenes.apart(count), steps=300)
        for count in (10, 30, 100, 300, 1000)
    },
}


def ours(case: Case, scene: Scene) -> Row:
    """What this program takes, rows included, and finds."""
    system, dt, left = RigidSystem(scene), case.dt, case.steps
    places = [system.centre(k) for k in range(len(system.names))]
    sinks = [k for k, name in enumerate(system.columns) if name.endswith(".penetration_m")]
    deepest, taken, kept = 0.0, 0.0, []
    while left:
        count = min(left, STEPS_AT_ONCE)
        ground = np.zeros((count + 1, scene.dimension))
        times = system.time + dt * np.arange(count + 1)
        ground[:, 0] = case.amplitude * np.sin(2 * math.pi * case.frequency * times)
        began = time.process_time()
        done = system.advance(count, dt, ground)
        taken += time.process_time() - began
        if done.failure:
            raise RuntimeError(done.failure)
        deepest, left = max(deepest, float(done.rows[:, sinks].max())), left - count
        kept += [done.rows] if case.past else []
    row: Row = {
        "ms_a_step": taken / case.steps * 1e3,
        "penetration_m": deepest,
        "moved_m": max(
            float(np.abs(system.centre(k) - place).max()) for k, place in enumerate(places)
        ),
        "program": "rockslip",
    }
    if kept:
        rows = dict(zip(system.columns, np.concatenate(kept).T, strict=True))
        row["past_s"] = [
            float(rows["time_s"][np.argmax(rows[f"{name}.angle_rad"] > case.past)])
            for name in system.names
        ]
    return row


def peer(case: Case, scene: Scene, python: str) -> Row:
    """What MuJoCo takes and finds."""
    flat, blocks = scene.dimension == 2, []
    placed = scene.poses()
    for spec in scene.blocks:
        pose = placed[spec.name]
        turn, keep = np.eye(3), [0, 2] if flat else [0, 1, 2]
        turn[np.ix_(keep, keep)] = pose.rotation
        place = np.zeros(3)
        place[keep] = centre_of(spec.shape, pose)
        blocks.append(
            {
                "size": [spec.width, spec.thickness, spec.height],
                "mass": spec.shape.mass,
                "place": place.tolist(),
                "axes": turn[:, :2].T.ravel().tolist(),
                "tilt": spec.tilt,
            }
        )
    given = {
        "dimension": scene.dimension,
        "gravity": scenes.G,
        "friction": scene.friction_of(scene.blocks[0]).static,
        "blocks": blocks,
        **{name: getattr(case, name) for name in ("dt", "steps", "amplitude", "frequency", "past")},
    }
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "scene.json")
        file.write_text(json.dumps(given), encoding="utf-8")
        command = [python, str(PEER), str(file)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        return {"program": f"MuJoCo: {done.stderr.strip().splitlines()[-1]}"}
    return dict(json.loads(done.stdout))


def rows(names: list[str], python: str | None) -> Iterator[Row]:
    """A row for each scene and program."""
    for name in names or CASES:
        case = CASES[name]
        scene = parse_scene(case.tables())
        found = [ours(case, scene)] + ([peer(case, scene, python)] if python else [])
        for each in found:
            row: Row = {"scene": name, "blocks": len(scene.blocks), "dt_s": case.dt}
            row |= {"steps": case.steps, "program": each["program"]}
            for key in ("ms_a_step", "penetration_m", "moved_m"):
                row[key] = f"{each[key]:.3g}" if key in each else ""
            row["past_20_degrees_s"] = " ".join(f"{t:.4f}" for t in each.get("past_s", []))
            print(*row.values(), sep=" | ", flush=True)
            yield row


def main() -> int:
    """Run all and write the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("names", nargs="*", metavar="NAME", help="scenes; default: all")
    parser.add_argument("--mujoco", metavar="PYTHON", help="a Python that has mujoco")
    options = parser.parse_args()
    if unknown := [name for name in options.names if name not in CASES]:
        parser.error(f"{unknown[0]}: allowed {', '.join(CASES)}")
    found = rows(options.names, options.mujoco)
    if options.names:
        list(found)
    else:
        write_table(TABLE, found)
    return 0


if __name__ == "__main__":
    sys.exit(main())
