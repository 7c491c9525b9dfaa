"""Effect of damped steps after changes of contact on reactions and impacts of the paper's block.

    ./in-env python3 benchmarks/damped_steps.py

Writes `benchmarks/damped_steps.csv`, a row for each time step and number of damped steps: the
standard deviation of (N - N_rigid)/(m g) over .4 to .9 of each of the first five swings, N_rigid
being the reaction of a rigid block that turns about its corner with the angle and speed of the run,
and the fifth impact against Housner's.
"""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.rows import DEMO, Row, side_by_side, write_table
from rockslip import Result, Scene, load_scene, simulate
from solver.reference.housner import housner

TABLE = Path(__file__).with_suffix(".csv")

SWINGS = 5
CASES = [(1e-3, 0), (1e-3, 2), (1e-3, 4), (1e-3, 8), (2e-3, 8), (5e-4, 0), (5e-4, 8), (2e-4, 8)]


def reaction_noise(scene: Scene, result: Result) -> NDArray[np.float64]:
    """(N - N_rigid)/(m g), row by row; N_rigid while the block turns about one corner."""
    shape, history, gravity = scene.blocks[0].shape, result.history, scene.gravity
    left = shape.slenderness() - np.abs(history["block.angle_rad"])
    spin = history["block.angular_velocity_rad_s"]
    rigid = 1 - 0.75 * np.sin(left) ** 2
    rigid -= shape.half_diagonal * np.cos(left) * spin**2 / gravity
    return history["block.normal_force_N"] / shape.weight(gravity) - rigid


def scatter(scene: Scene, result: Result) -> list[float]:
    """Standard deviation of the noise over .4 to .9 of each of the first swings."""
    times, noise = result.history["time_s"], reaction_noise(scene, result)
    found = []
    for begin, end in itertools.pairwise([0.0, *impact_times(result)]):
        place = (times - begin) / (end - begin)
        found.append(float(noise[(place > 0.4) & (place < 0.9)].std()))
    return found


def impact_times(result: Result) -> list[float]:
    """Times of the first impacts, s."""
    impacts = result.summary["blocks"]["block"]["impacts"][:SWINGS]
    return [impact["time_s"] for impact in impacts]


def run(case: tuple[float, int]) -> Row:
    """One row."""
    step, damped = case
    chosen = ["damping.stiffness=0", f"time.step={step}", f"time.damped_steps={damped}"]
    chosen.append("time.end=1.6")
    scene = load_scene(DEMO, chosen)
    shape, result = scene.blocks[0].shape, simulate(scene)
    row: Row = {"step": step, "damped_steps": damped}
    for number, noise in enumerate(scatter(scene, result), start=1):
        row[f"swing_{number}"] = f"{noise:.3f}"
    exact = housner(shape, gravity=scene.gravity, tilt=math.radians(3.0), end=1.6, step=1e-3)
    row["fifth_impact_error"] = f"{impact_times(result)[-1] / exact.impacts[SWINGS - 1] - 1:.2%}"
    row["iterations"] = result.summary["cost"]["newton_iterations"]
    return row


if __name__ == "__main__":
    write_table(TABLE, side_by_side(run, CASES, __doc__))
