"""Cost of each feature of a scene: time per step, in relation to the plain scene.

    ./in-env python3 benchmarks/feature_cost.py [--repeat 3]

Writes `benchmarks/feature_cost.csv`, one row a scene: milliseconds per step in the loop (the best
of some repetitions) and for output, and the ratio to the plain scene of its dimension; then the
command `rockslip run` from its start to its end, with no progress bar: seconds before the loop
(imports, meshes, compiled forms read back), seconds altogether, and the largest memory. A feature
that is not there costs nothing: "in the air" is what is left without contact. One process, one
thread: run it on a machine that is otherwise idle.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")

from tqdm import tqdm

from benchmarks.rows import write_table
from rockslip import parse_scene, simulate
from solver.scene import scene_to_toml

TABLE = Path(__file__).with_suffix(".csv")
STEPS = 300
COMPILED = 15_000
"""Steps of rigid blocks: so many that they run as machine code."""

#: `rockslip`, which then prints its largest memory, kB. (That which the parent of a process gets
#: includes the parent's own.)
PROCESS = """
import sys
from pathlib import Path
from solver.cli import main
code = main()
print(Path("/proc/self/status").read_text().split("VmHWM:")[1].split()[0])
sys.exit(code)
"""

STONE = {"young": 5e10, "poisson": 0.2}
SQUAT = {"width": 1.0, "height": 0.5, "thickness": 0.8, "mass": 1000.0, **STONE}
TOP = {"name": "top", "on": "block", "width": 0.7, "height": 0.3, "mass": 400.0}
OSCILLATOR = {"kind": "oscillator", "mass_ratio": 2.0, "period": 0.5, "damping_ratio": 0.05}
PLATE = {"kind": "elastic", "width": 2.4, "height": 0.3, "mass_ratio": 2.0, **STONE}
ROLLERS = {"support": "rollers", "period": 0.5, "damping_ratio": 0.05}
FRAME = {
    "kind": "frame",
    "deck": {"width": 2.4, "height": 0.3},
    "column": {"width": 0.2},
    "storey": 2.5,
    "density": 2500.0,
    "degree": 1,
    "cells": {"bay": 6, "column": 2, "deck": 2, "storey": 8},
    **STONE,
}
LAW = {"static": 0.3, "dynamic": 0.2, "decay": 10.0}
SINE = {"kind": "sine", "amplitude_g": 0.5, "period": 0.3}

#: What is special about each dimension: block, plate, frame, second block.
SIZES: dict[int, tuple[dict[str, Any], ...]] = {
    2: ({"cells": [6, 4]}, {"cells": [16, 2]}, {}, {"cells": [4, 3]}),
    3: (
        {"cells": [4, 3, 2]},
        {"cells": [6, 5, 1], "thickness": 2.0},
        {
            "deck": {"width": 2.4, "height": 0.3, "thickness": 2.0},
            "cells": {"bay": 4, "column": 1, "deck": 1, "storey": 3},
        },
        {"cells": [3, 2, 2], "thickness": 0.6},
    ),
}


def scenes(dimension: int) -> dict[str, dict[str, Any]]:
    """The plain scene, an elastic block sliding on the shaken ground, and others by a feature."""
    own, plate, frame, second = SIZES[dimension]
    block = SQUAT | own
    up = [0.0] * (dimension - 1) + [1.0]
    sliding = {"friction": 0.2, "velocity_solve": False}
    plain = {
        "dimension": dimension,
        "block": [block],
        "contact": sliding,
        "motion": SINE,
        "damping": {"stiffness": 0.0},
        "time": {"end": STEPS * 1e-3, "step": 1e-3},
    }
    rigid = {"block": [block | {"model": "rigid"}], "time": {"end": COMPILED * 1e-3, "step": 1e-3}}
    without = {key: value for key, value in plain.items() if key != "motion"}
    listed = {
        "plain": plain,
        "at rest": without,
        "no friction": plain | {"contact": sliding | {"friction": 0.0}},
        "friction falling with speed": plain | {"contact": sliding | {"friction": LAW}},
        "velocity solve": plain | {"contact": sliding | {"velocity_solve": True}},
        "gauss points": plain | {"contact": sliding | {"points": "gauss"}},
        "mass damping": plain | {"damping": {"mass": 0.5}},
        "stiffness damping": plain | {"damping": {"stiffness": 1e-5}},
        "oscillator": plain | {"foundation": OSCILLATOR},
        "plate, fixed": plain | {"foundation": PLATE | plate | {"support": "fixed"}},
        "plate on its bottom": plain | {"foundation": PLATE | plate | {"support": "bottom"}},
        "plate on rollers": plain | {"foundation": PLATE | plate | ROLLERS},
        "frame": plain | {"foundation": FRAME | frame},
        "second block on it": plain | {"block": [block, block | TOP | second]},
        "in the air": without | {"gravity": 0.0, "block": [block | {"velocity": up}]},
        "history file": plain,
        "history and fields every 10 steps": plain | {"output": {"every": 0.01}},
        "rigid block": plain | rigid,
        "rigid block at rest": without | rigid,
    }
    if dimension == 3:
        listed["both directions"] = plain | {"motion": SINE | {"second": SINE | {"period": 0.25}}}
    return listed


def measure(name: str, scene: dict[str, Any]) -> dict[str, float]:
    """Milliseconds per step in the loop and for output, iterations per step, unknowns."""
    parsed = parse_scene(scene)
    with tempfile.TemporaryDirectory() as folder:
        written = Path(folder) / "run" if name.startswith("history") else None
        result = simulate(parsed, folder=written)
    cost = result.summary["cost"]
    if result.status != "completed":
        sys.exit(f"{name}: {result.summary['reason']}")
    return {
        "unknowns": cost["unknowns"],
        "iterations_a_step": cost["newton_iterations"] / cost["steps"],
        "loop_ms": 1e3 * cost["wall_s"] / cost["steps"],
        "output_ms": 1e3 * cost["output_s"] / cost["steps"],
    }


def command(scene: dict[str, Any]) -> dict[str, float]:
    """`rockslip run` as a process of its own: seconds without the loop and in all, megabytes."""
    with tempfile.TemporaryDirectory() as folder:
        file, output = Path(folder) / "scene.toml", Path(folder) / "out"
        file.write_text(scene_to_toml(parse_scene(scene)), encoding="utf-8")
        words = [sys.executable, "-c", PROCESS, "run", str(file), "-q", "-o", str(output)]
        began = time.perf_counter()
        done = subprocess.run(
            words, cwd=TABLE.parents[1], stdout=subprocess.PIPE, text=True, check=True
        )
        seconds = time.perf_counter() - began
        loop = json.loads((output / "summary.json").read_text(encoding="utf-8"))["cost"]["wall_s"]
    return {"outside_s": seconds - loop, "command_s": seconds, "memory": int(done.stdout) / 1024}


def best(name: str, scene: dict[str, Any], repeat: int) -> dict[str, float]:
    """The fastest of some runs."""
    runs = [measure(name, scene) for _ in range(repeat)]
    commands = [command(scene) for _ in range(repeat)]
    return {
        **min(runs, key=lambda run: run["loop_ms"] + run["output_ms"]),
        **min(commands, key=lambda run: run["command_s"]),
    }


def rows(dimension: int, repeat: int) -> list[dict[str, Any]]:
    """The table of one dimension."""
    listed = scenes(dimension)
    measure("warm-up", listed["plain"])
    found = {
        name: best(name, scene, repeat)
        for name, scene in tqdm(listed.items(), desc=f"{dimension}-D")
    }
    plain = found["plain"]["loop_ms"]
    return [
        {
            "dimension": dimension,
            "scene": name,
            "unknowns": int(run["unknowns"]),
            "iterations_a_step": f"{run['iterations_a_step']:.2f}",
            "loop_ms_a_step": f"{run['loop_ms']:.3f}",
            "output_ms_a_step": f"{run['output_ms']:.3f}",
            "ratio_to_plain": f"{(run['loop_ms'] + run['output_ms']) / plain:.2f}",
            "outside_the_loop_s": f"{run['outside_s']:.2f}",
            "start_to_end_s": f"{run['command_s']:.2f}",
            "memory_MB": f"{run['memory']:.0f}",
        }
        for name, run in found.items()
    ]


def main() -> None:
    """Measure and write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeat", type=int, default=3)
    repeat = parser.parse_args().repeat
    table = [row for dimension in (2, 3) for row in rows(dimension, repeat)]
    write_table(TABLE, table)
    sys.stdout.write(f"{TABLE.read_text(encoding='utf-8')}table in {TABLE}\n")


if __name__ == "__main__":
    main()
