"""Flat landings on a bed of springs and dashpots: a bar in one dimension, and the paper's block.

    ./in-env python3 benchmarks/landing_on_bed.py

Writes `benchmarks/landing_on_bed.csv`, a row for each landing: speed after over speed before. The
bar is stepped by central differences; the block falls from 10 cm, with steps chosen by their error,
with those of a tenth of the tolerance and with fixed ones, on two meshes.
"""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import numpy as np

from benchmarks.rows import DEMO, Row, side_by_side, write_table
from rockslip import Result, Scene, load_scene, simulate

TABLE = Path(__file__).with_suffix(".csv")

SPEED = 1.4007
"""Of a fall from 10 cm, m/s: the block is thrown up with it, and lands with it."""
RATIOS = (0.0, 0.02, 0.1, 0.3, 0.5, 1.0)
BEDS = (0.01, 0.1, 0.3, 1.0, 10.0, 100.0)
"""Stiffness of a bed over that of the bar."""
STEPS = {"default": (), "tenth": ("time.tolerance=1e-4",), "1e-4 s": ("time.step=1e-4",)}
CELLS = ("[6,16]", "[12,32]")


def bar(bed: float, ratio: float, cells: int = 100) -> float:
    """Rebound of a bar of length, modulus and density 1 on a bed, by central differences.

    Args:
        bed: Stiffness of the bed.
        ratio: Of its dashpot over the critical one of the bar's mass.
        cells: Of the bar.
    """
    h, dashpot = 1 / cells, 2 * ratio * math.sqrt(bed)
    mass = np.full(cells + 1, h)
    mass[[0, -1]] = h / 2
    dt = 0.1 * h / max(1.0, math.sqrt(bed * h), dashpot)
    relaxed = math.exp(-dt * bed / dashpot) if dashpot else 0.0
    u, v, pressed, parted = np.zeros(cells + 1), np.full(cells + 1, -1.0), 0.0, 0.0
    while parted < 4.0:
        force = np.zeros(cells + 1)
        stress = np.diff(u) / h
        force[:-1] += stress
        force[1:] -= stress
        push = -bed * u[0] - dashpot * v[0] if -u[0] >= pressed * relaxed else 0.0
        pressed = -u[0] if push > 0 else pressed * relaxed
        parted = 0.0 if push > 0 else parted + dt
        force[0] += max(push, 0.0)
        v += dt * force / mass
        u += dt * v
    return float(v @ mass)


def landing(*overrides: str) -> Scene:
    """The demo's block, thrown up without damping; it lands flat."""
    thrown = ["block.tilt_deg=0", f"block.velocity=[0,{SPEED}]", "damping.stiffness=0"]
    return load_scene(DEMO, [*thrown, 'output.fields="none"', *overrides])


def rebound(result: Result, speed: float = SPEED) -> float:
    """Speed of the centre after the landing over that before it, of its free flight."""
    time, height = result.history["time_s"], result.history["block.centre_y_m"]
    closed = np.flatnonzero((result.history["block.normal_force_N"] > 0) & (time > 0.1))
    last = closed[-1]
    fall = 9.81 * (time[-1] - time[last]) / 2
    return float(((height[-1] - height[last]) / (time[-1] - time[last]) + fall) / speed)


def row(body: str, bed: float, ratio: float, steps: str, kept: float) -> Row:
    """One landing."""
    number = f"{kept:.4f}"
    return {"body": body, "bed": bed, "ratio": ratio, "steps": steps, "rebound": number}


def run(case: tuple[float, str, str]) -> Row:
    """One row of the block; a ratio of 0 has no bed."""
    ratio, steps, cells = case
    overrides = (f"contact.damping={ratio}", f"block.cells={cells}", "time.end=0.2915")
    result = simulate(landing(*overrides, *STEPS[steps]))
    return row(f"block {cells}", 0.1 if ratio else math.inf, ratio, steps, rebound(result))


def main() -> None:
    """Run all landings and write the table."""
    bars = [row("bar", *case, "", bar(*case)) for case in itertools.product(BEDS, RATIOS)]
    cases = list(itertools.product(RATIOS, STEPS, CELLS))
    write_table(TABLE, itertools.chain(bars, side_by_side(run, cases, __doc__)))


if __name__ == "__main__":
    main()
