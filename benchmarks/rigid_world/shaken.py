"""A wall of 100 bricks under shaking: does each run go to its end, and where do bricks end?

    ./in-env python3 -m benchmarks.rigid_world.shaken [--record FILE --scale 2]

The wall has joints of 2 mm. It is shaken at 0.8 g and 4 Hz, at 0.3 g and 2 Hz with friction 0.25,
and by a record where one is given, each with steps of 1 ms and of 0.5 ms, and with steps of 1 ms
once more while the ground moves 1e-9 more: what that changes no step can settle. Prints a line for
each run, and how far places at its end differ between them. Takes three quarters of an hour.
"""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np

from benchmarks.rigid_world import scenes
from rockslip import parse_scene, simulate
from solver.types import Array


def shaken(tables: dict[str, Any], step: float, more: float = 0.0) -> tuple[Array, Array]:
    """Run a scene with a step and its ground moving more, by a fraction, and print how it went.

    Returns places at its end and ways, m, (n, 2).
    """
    name = "scale" if tables["motion"]["kind"] == "record" else "amplitude_g"
    motion = tables["motion"] | {name: tables["motion"].get(name, 1.0) * (1 + more)}
    tables = tables | {"motion": motion}
    run = simulate(parse_scene(tables | {"time": tables["time"] | {"step": step}}))
    summary, history = run.summary, run.history
    cost, energy = summary["cost"], summary["energy"]
    print(
        f"  step {step:g}: {summary['status']} at {summary['end_s']:g} s,",
        f"{1e3 * cost['wall_s'] / cost['steps']:.1f} ms a step,",
        f"gain {energy['largest_gain_fraction']:.1e},",
        f"ledger {energy['ledger_error_fraction']:.1e},",
        f"deepest {summary['deepest_penetration_m']:.1e} m, unsettled {summary['unsettled']}",
        flush=True,
    )
    names = [block["name"] for block in tables["block"]]
    places = np.array([[history[f"{name}.centre_{axis}_m"] for axis in "xy"] for name in names])
    return places[..., -1], np.abs(np.diff(places)).sum(axis=2)


def main() -> None:
    """Run all and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--record", help="a file of recorded motion")
    parser.add_argument("--scale", type=float, default=1.0, help="of the record")
    parser.add_argument("--end", type=float, default=20.0, help="s")
    options = parser.parse_args()
    time = {"end": options.end}
    sine = {"kind": "sine", "amplitude_g": 0.8, "period": 0.25, "cycles": 80}
    weak = sine | {"amplitude_g": 0.3, "period": 0.5, "cycles": 40}
    walls = {
        "0.8 g at 4 Hz": scenes.wall(10, 10, motion=sine, time=time),
        "0.3 g at 2 Hz, friction 0.25": scenes.wall(10, 10, friction=0.25, motion=weak, time=time),
    }
    if options.record:
        record = {"kind": "record", "file": options.record, "scale": options.scale}
        walls[options.record] = scenes.wall(10, 10, motion=record, time=time)
    for name, tables in walls.items():
        print(name, flush=True)
        (coarse, _), (fine, way), (nudged, _) = (
            shaken(tables, step, more) for step, more in ((1e-3, 0.0), (5e-4, 0.0), (1e-3, 1e-9))
        )
        for what, size in {
            "places differ between the steps": coarse - fine,
            "places differ if the ground moves 1e-9 more": coarse - nudged,
            "bricks go to and fro": way,
        }.items():
            size = np.linalg.norm(size, axis=1)
            print(f"  {what} by {size.max():.2g} m, {np.median(size):.2g} m in the middle")


if __name__ == "__main__":
    main()
