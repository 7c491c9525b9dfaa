"""Rigid blocks: time and error of free rocking against the step, compiled and interpreted.

    ./in-env python3 benchmarks/rigid_rocking.py [--interpreted]

The paper's block, released at 3 degrees, 3 s (T1 of the verification). Writes
`benchmarks/rigid_rocking.csv`, one row a run: processor seconds of the loop without compiling,
microseconds a step, and the largest errors of the first seven impacts and of the six peaks between
them against Housner (1963), integrated to 11 digits. On the same case PyBullet takes 0.7 s and
MuJoCo 0.3 s at 1e-4 s, with errors of 1 % and 0.2 %.
"""

from __future__ import annotations

import argparse
import math
import os
import time
from pathlib import Path

import numpy as np

from benchmarks.rows import write_table

TABLE = Path(__file__).with_suffix(".csv")

STEPS = (2e-3, 1e-3, 5e-4, 2e-4, 1e-4)
END = 3.0


def main() -> None:
    """Run all steps and write the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--interpreted", action="store_true", help="without numba")
    if parser.parse_args().interpreted:
        os.environ["ROCKSLIP_NO_NUMBA"] = "1"
    write_table(TABLE, map(run, STEPS))


def run(step: float) -> dict[str, str]:
    """One row of the table."""
    # Imported here: whether numba is used is decided at the import.
    from rockslip import parse_scene
    from solver.law.compiled import NUMBA
    from solver.reference.housner import housner
    from solver.results.rocking import impacts, peaks
    from solver.rigid.plane.system import PlaneSystem

    block = {"width": 0.25, "height": 1.0, "mass": 503.0, "model": "rigid", "tilt_deg": 3.0}
    scene = parse_scene(
        {"block": [block], "contact": {"friction": 0.7}, "time": {"end": END, "step": step}}
    )
    system, count = PlaneSystem.from_scene(scene), round(END / step)
    PlaneSystem.from_scene(scene).advance(1, step)  # compiles, or reads what was compiled
    began = time.process_time()
    rows = system.advance(count, step).rows
    spent = time.process_time() - began
    shape, angle = scene.blocks[0].shape, rows[:, system.columns.index("block.angle_rad")]
    exact = housner(shape, gravity=9.81, tilt=math.radians(3.0), end=END, step=1e-3)
    found = np.array([impact.time_s for impact in impacts(rows[:, 0], angle, shape, 9.81)])
    turned = np.array([abs(peak) for _, peak in peaks(rows[:, 0], angle, shape.slenderness)])
    row = {
        "step_s": f"{step:g}",
        "compiled": str(NUMBA is not None),
        "loop_s": f"{spent:.3f}",
        "us_per_step": f"{1e6 * spent / count:.1f}",
        "impact_error": f"{np.abs(found[:7] / exact.impacts[:7] - 1).max():.1e}",
        "peak_error": f"{np.abs(turned[1:7] / np.abs(exact.peaks[1:7]) - 1).max():.1e}",
    }
    print(row)
    return row


if __name__ == "__main__":
    main()
