"""Steady rocking under a sine: the elastic block beside Housner's equation.

    ./in-env python3 benchmarks/steady_rocking.py [--periods N] [--beta B,...]

The paper's block on ground that moves by a sine of omega/p = 4 and 2 g tan alpha. Writes
`benchmarks/steady_rocking.csv`, a row for each damping beta_R of the block: the restitution of its
impacts in the last ten periods (mean, least, largest), its largest |theta|/alpha in the last ten
periods of the run, and that of Housner's equation with the mean restitution, up to then and after
100 periods more. A run of 60 periods takes two minutes of processor time.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.rows import Row, write_table
from rockslip import Scene, parse_scene, simulate
from solver.reference.housner import RockingReference, housner
from solver.types import Array

TABLE = Path(__file__).with_suffix(".csv")

SIZE = {"width": 0.25, "height": 1.0, "thickness": 0.75, "mass": 503.0, "friction": 3.0}
STONE = {"young": 5e10, "poisson": 0.2, "cells": [6, 16]}
G, SLENDERNESS = 9.81, math.atan(0.25)
RADIUS = math.hypot(0.25, 1.0) / 2
P = math.sqrt(0.75 * G / RADIUS)
OMEGA = 4 * P
PERIOD = 2 * math.pi / OMEGA
LAST = 10
"""Periods at the end that count."""


def under_a_sine(cycles: float, times: float = 2.0, **keys: Any) -> Scene:
    """The paper's block under omega/p = 4 and so many times g tan alpha."""
    motion = {"kind": "sine", "amplitude_g": times * math.tan(SLENDERNESS), "period": PERIOD}
    time = {"end": cycles * PERIOD} | ({"step": PERIOD / 800} if "model" in keys else {})
    return parse_scene({"block": [SIZE | keys], "motion": motion, "time": time})


def equation(cycles: int, restitution: float) -> RockingReference:
    """Housner's equation under that motion, 200 times a period."""
    shape, amplitude = under_a_sine(1, **STONE).blocks[0].shape, 2 * math.tan(SLENDERNESS) * G
    return housner(
        shape,
        gravity=G,
        end=cycles * PERIOD,
        step=PERIOD / 200,
        restitution=restitution,
        acceleration=lambda time: amplitude * math.sin(OMEGA * time),
    )


def steady(time: Array, angle: Array, cycles: int, last: int = LAST) -> float:
    """Largest |theta|/alpha in the last periods."""
    return float(np.abs(angle[time > (cycles - last) * PERIOD]).max()) / SLENDERNESS


def run(cycles: int, beta: float) -> Row:
    """The row of an elastic block with this damping."""
    result = simulate(under_a_sine(cycles, **STONE, damping={"stiffness": beta}))
    history = result.history
    kept = [
        impact["restitution"]
        for impact in result.summary["blocks"]["block"]["impacts"]
        # The end of the run cuts the swing after the last one short.
        if cycles - LAST < impact["time_s"] / PERIOD < cycles - 0.5
    ]
    mean = float(np.mean(kept))
    short, long = equation(cycles, mean), equation(cycles + 100, mean)
    found = steady(history["time_s"], history["block.angle_rad"], cycles)
    beside = steady(short.time, short.angle, cycles)
    return {
        "beta_s": beta,
        "periods": cycles,
        "restitution": f"{mean:.4f}",
        "least": f"{min(kept):.4f}",
        "largest": f"{max(kept):.4f}",
        "elastic": f"{found:.5f}",
        "equation": f"{beside:.5f}",
        "equation_steady": f"{steady(long.time, long.angle, cycles + 100):.5f}",
        "difference": f"{found / beside - 1:+.4f}",
        "steps": result.summary["cost"]["steps"],
    }


def main() -> None:
    """Run all and write the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--periods", type=int, default=60)
    parser.add_argument("--beta", default="3e-5", help="beta_R, s: B,...")
    options = parser.parse_args()
    write_table(TABLE, (run(options.periods, float(b)) for b in options.beta.split(",")))


if __name__ == "__main__":
    main()
