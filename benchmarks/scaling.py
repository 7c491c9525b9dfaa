"""Cost against size: unknowns, contact points and ranks; time and memory of each part of a run.

    ./in-env python3 benchmarks/scaling.py [--long]

Writes `benchmarks/scaling.csv`, a row for each case: a block that rocks through an impact, stands
on all points of its bottom and is shaken, or is shaken until they slip, one after another. CPU
seconds of factorizations and of W (all together), milliseconds and CPU milliseconds a step (medians
of those after the first three, or of those in which points begin to slip; on a busy machine only
the second mean anything, and with ranks only the first) and the largest memory. Without `--long` up
to 2e4 unknowns and 169 points, in two minutes; with it up to 3e5 unknowns and 4096 points, which
takes 14 GB and a quarter of an hour. Each case is a process of its own: this file, started with a
case.
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from benchmarks.rows import Row, on_ranks, write_table

TABLE = Path(__file__).with_suffix(".csv")
STEPS = {"rocks": (3, 15), "stands": (3, 15), "slips": (31, 46)}
"""The first step that counts, and the end of them, of each motion."""
STONE = {"young": 5e9, "poisson": 0.2, "density": 2000.0}

#: Cells of each case, how it moves, ranks, and whether it belongs to the short form.
CASES: tuple[tuple[tuple[int, ...], str, int, bool], ...] = (
    ((8, 14), "rocks", 1, True),
    ((36, 70), "rocks", 1, True),
    ((68, 138), "rocks", 1, True),
    ((68, 138), "rocks", 2, True),
    ((114, 228), "rocks", 1, False),
    ((114, 228), "rocks", 2, False),
    ((4, 4, 10), "rocks", 1, True),
    ((8, 8, 24), "rocks", 1, True),
    ((12, 12, 34), "stands", 1, True),
    ((16, 16, 47), "rocks", 1, False),
    ((16, 16, 47), "rocks", 2, False),
    ((22, 22, 62), "rocks", 1, False),
    ((32, 32, 91), "rocks", 1, False),
    ((9, 9, 8), "stands", 1, True),
    ((31, 31, 8), "stands", 1, False),
    ((31, 31, 2), "stands", 1, False),
    ((63, 63, 2), "stands", 1, False),
    ((15, 15, 2), "slips", 1, True),
    ((23, 23, 2), "slips", 1, False),
    ((31, 31, 2), "slips", 1, False),
)


def scene_of(cells: tuple[int, ...], motion: str) -> dict[str, Any]:
    """The scene of a case: about to land, or shaken by less or more than friction holds."""
    d = len(cells)
    height = cells[-1] / cells[0]
    block: dict[str, Any] = {"width": 1.0, "height": height, "cells": list(cells), **STONE}
    if d == 3:
        block["thickness"] = 1.0
    scene: dict[str, Any] = {"dimension": d, "contact": {"friction": 0.6}}
    if motion == "rocks":
        turning = -0.5 if d == 2 else [0.0, -0.5, 0.0]
        block |= {"tilt_deg": 0.15, "angular_velocity": turning}
    else:
        amplitude = 0.1 if motion == "stands" else 0.75
        scene["motion"] = {"kind": "sine", "amplitude_g": amplitude, "period": 0.3}
    return scene | {"block": [block], "time": {"end": 1.0, "step": 1e-3}}


def timed(spent: dict[str, float], name: str, of: type, method: str) -> None:
    """Let calls of a method add their CPU seconds to what is spent on a name."""
    original: Callable[..., Any] = getattr(of, method)

    def measured(*arguments: Any, **options: Any) -> Any:
        begin = time.process_time()
        try:
            return original(*arguments, **options)
        finally:
            spent[name] = spent.get(name, 0.0) + time.process_time() - begin

    setattr(of, method, measured)


def run_case(cells: tuple[int, ...], motion: str) -> Row:
    """Run a case on the ranks that there are; collective."""
    from rockslip import parse_scene
    from solver.bodies.factorization import Factorization
    from solver.build.assembly import build, initial_state
    from solver.stepping.compliance import Compliance

    spent: dict[str, float] = {}
    timed(spent, "factorizations_s", Factorization, "_factorize")
    timed(spent, "W_s", Compliance, "_compute")
    scene = parse_scene(scene_of(cells, motion))
    assembly = build(scene)
    stepper, seconds, busy, iterations = assembly.stepper, [], [], 0
    state, _ = initial_state(scene, assembly)
    first, end = STEPS[motion]
    for _ in range(end):
        begin, worked = time.perf_counter(), time.process_time()
        state, exchange = stepper.advance(state, 1e-3)
        seconds.append(time.perf_counter() - begin)
        busy.append(time.process_time() - worked)
        iterations += exchange.iterations
    memory = int(Path("/proc/self/status").read_text().split("VmHWM:")[1].split()[0])
    return {
        "unknowns": stepper.system.unknowns,
        "closed_points": sum(int((each.force[:, 0] > 0).sum()) for each in state.contacts),
        "factorizations_s": f"{spent.get('factorizations_s', 0.0):.3g}",
        "W_s": f"{spent.get('W_s', 0.0):.3g}",
        "milliseconds_a_step": f"{1e3 * statistics.median(seconds[first:]):.4g}",
        "cpu_milliseconds_a_step": f"{1e3 * statistics.median(busy[first:]):.4g}",
        "iterations_a_step": f"{iterations / end:.3g}",
        "memory_MB": round(memory / 1024),
    }


def rows(long: bool) -> Iterator[Row]:
    """A row for each case, from a process of its own."""
    for cells, motion, ranks, short in CASES:
        if not (short or long):
            continue
        done = on_ranks(ranks, __file__, "--case", json.dumps([cells, motion]))
        if done.returncode:
            sys.exit(done.stderr)
        found = json.loads(done.stdout.splitlines()[-1])
        row = {"cells": "x".join(map(str, cells)), "motion": motion, "ranks": ranks} | found
        print(*(f"{key} {value}" for key, value in row.items()), sep=", ", flush=True)
        yield row


def main() -> None:
    """Run all cases, or one of them on the ranks that there are."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--long", action="store_true", help="the large cases, too")
    parser.add_argument("--case", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if not options.case:
        write_table(TABLE, rows(options.long))
        return
    cells, motion = json.loads(options.case)
    row = run_case(tuple(cells), motion)
    from mpi4py import MPI

    if MPI.COMM_WORLD.rank == 0:
        print(json.dumps(row))


if __name__ == "__main__":
    main()
