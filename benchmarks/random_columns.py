"""Random columns of rigid drums in space, shaken until they rock, slide and fall: which ones fail?

    ./in-env python3 benchmarks/random_columns.py [--first SEED] [--count N]

Each seed makes a column of 2 to 6 rectangular drums with random sizes, offsets, turns, density,
friction, motion of the ground and step. Prints one line per column: status, ledger error and energy
gain over the energy scale, rejected steps; and at the end the failures. Exit code 1 if there are
any.
"""

from __future__ import annotations

import argparse
import math
import sys
from dataclasses import replace
from typing import Any

import numpy as np

from geometry.arrangement import Pose
from rockslip import Scene, parse_scene
from solver.excitation.motion import read_ground
from solver.rigid.system import RigidSystem

END = 3.0


def column(seed: int) -> dict[str, Any]:
    """The scene of a seed."""
    random = np.random.default_rng(seed)
    width = float(random.uniform(0.3, 1.0))
    height = float(width * random.uniform(0.3, 1.5))
    equal, centred = random.random() < 0.5, random.random() < 0.6
    thickness = width if random.random() < 0.5 else float(width * random.uniform(0.6, 1.4))
    drums: list[dict[str, Any]] = []
    for k in range(int(random.integers(2, 7))):
        drum = {"name": f"drum{k}", "model": "rigid", "width": width, "thickness": thickness}
        drum |= {"height": height, "density": float(random.uniform(1800.0, 2800.0))}
        if not equal:
            drum["width"] = width * float(random.uniform(0.7, 1.0))
            drum["height"] = height * float(random.uniform(0.5, 1.5))
        if k:
            drum["on"] = f"drum{k - 1}"
        if k and not centred:
            drum["offset"] = width * float(random.uniform(-0.1, 0.1))
            drum["offset_second"] = thickness * float(random.uniform(-0.1, 0.1))
        drums.append(drum)
    motion = pulse(random)
    if random.random() < 0.5:
        motion["second"] = pulse(random)
    return {
        "dimension": 3,
        "block": drums,
        "contact": {"friction": float(random.uniform(0.3, 0.9))},
        "motion": motion,
        "time": {"end": END, "step": float(random.choice([5e-4, 1e-3, 2e-3, 5e-3]))},
    }


def pulse(random: np.random.Generator) -> dict[str, Any]:
    """A random motion of the ground in one direction."""
    amplitude, frequency = float(random.uniform(0.2, 0.9)), float(random.uniform(0.8, 3.0))
    if random.random() < 0.5:
        return {"kind": "ricker", "amplitude_g": amplitude, "frequency": frequency}
    return {"kind": "half_sine", "amplitude_g": amplitude, "duration": 0.5 / frequency}


def turned(poses: dict[str, Pose], seed: int) -> dict[str, Pose]:
    """The drums, of every third seed each turned about the vertical by up to 45 degrees."""
    random = np.random.default_rng(seed)
    if seed % 3:
        return poses
    found = {}
    for name, pose in poses.items():
        angle = random.uniform(-math.pi / 4, math.pi / 4)
        c, s = math.cos(angle), math.sin(angle)
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        found[name] = replace(pose, rotation=turn)
    return found


def run(scene: Scene, seed: int) -> dict[str, Any]:
    """Run a column; returns its results."""
    step = scene.time.step
    system = RigidSystem(scene, turned(scene.poses(), seed))
    count, motion = round(scene.time.end / step), read_ground(scene)
    times = np.arange(count + 1) * step
    ground, mean = motion.accelerations(times), motion.means(times)
    outcome = system.advance(count, step, ground, mean=mean)
    table = dict(zip(system.columns, outcome.rows.T, strict=True))
    total, work = table["energy.total_J"], table["energy.input_J"]
    scale = np.abs(np.diff(work)).sum() + 1e-3 * table["energy.gravity_J"].max()
    return {
        "failure": outcome.failure,
        "rejected": outcome.rejected,
        "ledger": np.abs(table["energy.ledger_error_J"]).max() / scale,
        "gain": np.max(total - work - np.minimum.accumulate(total - work)) / scale,
        "friction": np.min(np.diff(table["energy.friction_J"])) / scale,
    }


def main() -> int:
    """Run the columns."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--count", type=int, default=100, help="number of columns")
    given, failed = parser.parse_args(), []
    for seed in range(given.first, given.first + given.count):
        scene = column(seed)
        found = run(parse_scene(scene), seed)
        sizes = f"{len(scene['block'])} drums, dt {scene['time']['step']:g}"
        numbers = f"ledger {found['ledger']:.1e} gain {found['gain']:.1e}"
        numbers += f" friction {found['friction']:.1e} rejected {found['rejected']}"
        print(f"{seed}: {sizes}: {found['failure'] or 'completed'}; {numbers}", flush=True)
        if found["failure"]:
            failed.append(seed)
    print(f"{len(failed)} of {given.count} failed: {failed}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
