"""The elastic block as it grows stiffer: against the rigid one with the same steps.

    ./in-env python3 benchmarks/stiffness_limit.py [--processes 2]

The paper's block from three degrees, 1 s. First E from 1e8 to 1e14 Pa with dt 1e-3 s: the history
tends to that of a rigid block in the same steps, a body of three unknowns in the engine of meshed
ones (`angle_against_same_steps`). The engine of rigid blocks cuts its steps at impacts; what uncut
ones lose there is of first order in dt (`angle_against_rigid`): E = 1e13 Pa with smaller dt.
Then E = 5e10 Pa with dt from 5e-4 to 5e-5 s: the two limits do not commute. A step that does not
resolve the waves (2H/c = 0.46 ms here) loses at an impact what a rigid block loses; smaller ones
keep part of it as vibration, and the block rebounds otherwise however stiff it is. Writes
`benchmarks/stiffness_limit.csv`.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.rows import DEMO, Row, side_by_side, write_table
from rockslip import Scene, load_scene, parse_scene, simulate
from solver.reference.housner import housner
from solver.run.meshed import MeshedRun

TABLE = Path(__file__).with_suffix(".csv")

END = 1.0

MODULI = (1e8, 1e9, 1e10, 5e10, 1e11, 1e12, 1e13, 1e14)
STEPS = (5e-4, 2e-4, 1e-4, 5e-5)
POINTS = [(young, 1e-3) for young in MODULI]
POINTS += [(1e13, 5e-4), (1e13, 2e-4)]
POINTS += [(5e10, step) for step in STEPS]


def elastic(young: float, step: float) -> Scene:
    """The block of the demo."""
    changes = ["damping.stiffness=0", f"time.step={step!r}", f"time.end={END}"]
    changes.append(f"block.young={young!r}")
    return load_scene(DEMO, changes)


def rigid(step: float) -> Scene:
    """Rigid run, without a mesh."""
    tables = elastic(5e10, step).to_dict()
    for key in ("young", "poisson", "cells", "cell", "degree", "refinement"):
        tables["block"][0].pop(key, None)
    tables["block"][0]["model"] = "rigid"
    return parse_scene(tables)


def in_whole_steps(scene: Scene) -> NDArray[np.float64]:
    """Angles of a block in the engine of meshed bodies, whose steps no impact cuts, rad."""
    engine = MeshedRun(scene, lambda line: None)
    stepper, state = engine.assembly.stepper, engine.state
    angles = [scene.blocks[0].tilt]
    for number in range(round(END / scene.time.step)):
        state, _ = stepper.advance(state, scene.time.step)
        state = state._replace(time=(number + 1) * scene.time.step)
        rotation = state.rigid_motion(stepper.system, 0).rotation
        angles.append(float(np.arctan2(rotation[0, 1], rotation[0, 0])))
    return np.array(angles)


def run(point: tuple[float, float]) -> Row:
    """One row of the table."""
    young, step = point
    scene = elastic(young, step)
    result, stiff = simulate(scene), simulate(rigid(step))
    time, angle = result.history["time_s"], result.history["block.angle_rad"]
    other = np.interp(time, stiff.history["time_s"], stiff.history["block.angle_rad"])
    block = scene.blocks[0]
    exact = housner(block.shape, gravity=scene.gravity, tilt=block.tilt, end=END, step=step)
    housners = np.interp(time, exact.time, exact.angle)
    impacts = [impact["time_s"] for impact in result.summary["blocks"]["block"]["impacts"]]
    second = (time > impacts[0]) & (time < impacts[1])
    return {
        "young_Pa": f"{young:g}",
        "step_s": f"{step:g}",
        **{f"impact_{k + 1}_s": f"{impacts[k]:.4f}" for k in range(3)},
        "second_peak_deg": f"{np.rad2deg(np.abs(angle[second]).max()):.4f}",
        "angle_against_same_steps": f"{distance(angle, in_whole_steps(rigid(step))):.2e}",
        "angle_against_rigid": f"{distance(angle, other):.2e}",
        "angle_against_housner": f"{distance(angle, housners):.2e}",
        "rigid_against_housner": f"{distance(other, housners):.2e}",
    }


def distance(angle: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    """Relative difference of two histories in L2."""
    return float(np.linalg.norm(angle - other) / np.linalg.norm(other))


if __name__ == "__main__":
    write_table(TABLE, side_by_side(run, POINTS, __doc__))
