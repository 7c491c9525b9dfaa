"""Sliding blocks on everything that can carry them, on 1, 2 and 3 ranks: how far histories part.

    ./in-env python3 benchmarks/ranks.py

Every scene for 1 s in steps of 2 ms. Writes `benchmarks/ranks.csv`, a row for each scene and number
of ranks: the largest differences from one rank, lengths over the block's width, forces over its
weight. `tests/parallel/test_ranks_foundations.py` holds them to limits for a shorter time. All
scenes run in one process for each number of ranks: this file, started with a folder.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from benchmarks.rows import Row, on_ranks, write_table

TABLE = Path(__file__).with_suffix(".csv")
STONE = {"young": 5e10, "poisson": 0.2}
BLOCK = {"width": 1.0, "height": 0.5, "mass": 1000.0, "cells": [4, 3], **STONE}
WEIGHT, WIDTH = 1000.0 * 9.81, 1.0
TOP = BLOCK | {"name": "top", "on": "block", "width": 0.7, "height": 0.3, "mass": 400.0}
PLATE = {
    "kind": "elastic",
    "width": 2.4,
    "height": 0.3,
    "mass_ratio": 2.0,
    "cells": [12, 2],
} | STONE
ON_ROLLERS = {"support": "rollers", "period": 0.2, "damping_ratio": 0.05}
FRAME = {
    "kind": "frame",
    "deck": {"width": 2.4, "height": 0.3},
    "column": {"width": 0.2},
    "storey": 2.5,
    "density": 2500.0,
    "cells": {"bay": 4, "column": 1, "deck": 1, "storey": 3},
    **STONE,
}
SHAKEN = {"kind": "sine", "amplitude_g": 0.5, "period": 0.2}
BOTH_WAYS = SHAKEN | {"second": {"kind": "sine", "amplitude_g": 0.4, "period": 0.15}}
IN_SPACE = {"thickness": 0.8, "cells": [2, 2, 1]}

#: What is special about each scene.
SCENES: dict[str, dict[str, Any]] = {
    "rigid": {},
    "oscillator": {
        "foundation": {
            "kind": "oscillator",
            "mass_ratio": 2.0,
            "period": 0.2,
            "damping_ratio": 0.05,
        }
    },
    "plate": {"foundation": PLATE | {"support": "bottom"}},
    "rollers": {"foundation": PLATE | ON_ROLLERS},
    "frame": {"foundation": FRAME},
    "reduced frame": {"foundation": FRAME | {"modes": "auto"}},
    "linked": {
        "block": [BLOCK, TOP | {"friction": 0.05}],
        "foundation": FRAME,
        "link": [
            {
                "name": "bar",
                "between": ["top", "foundation"],
                "at": [0.35, 0.1],
                "to": [1.13, 0.0],
                "stiffness": 1e5,
            },
            {
                "name": "dab",
                "kind": "wax",
                "between": ["block", "top"],
                "at": [0.0, 0.5],
                "stiffness": 1e7,
                "strength": 100.0,
            },
        ],
        "force": [{"on": "block", "face": "left", "pressure": 500.0, "ramp": [0.0, 0.1]}],
    },
    "neighbours": {"block": [BLOCK, BLOCK | {"name": "beside", "offset": -1.001, "friction": 0.4}]},
    "elastic on elastic": {"block": [BLOCK, TOP | {"friction": 0.05}]},
    "rigid on elastic": {"block": [BLOCK, TOP | {"friction": 0.05, "model": "rigid"}]},
    "rigid on rigid": {
        "block": [BLOCK | {"model": "rigid"}, TOP | {"friction": 0.05, "model": "rigid"}],
        "foundation": PLATE | ON_ROLLERS,
    },
    "elastic on rigid": {"block": [BLOCK | {"model": "rigid"}, TOP | {"friction": 0.05}]},
    "rollers in space": {
        "dimension": 3,
        "block": [BLOCK | IN_SPACE],
        "foundation": PLATE | ON_ROLLERS | {"thickness": 2.0, "cells": [4, 3, 1]},
        "motion": BOTH_WAYS,
    },
    "stack in space": {
        "dimension": 3,
        "block": [BLOCK | IN_SPACE, TOP | IN_SPACE | {"friction": 0.05, "thickness": 0.6}],
        "motion": BOTH_WAYS,
    },
    "rigid on elastic in space": {
        "dimension": 3,
        "block": [
            BLOCK | IN_SPACE,
            TOP | IN_SPACE | {"friction": 0.05, "thickness": 0.6, "model": "rigid"},
        ],
        "motion": BOTH_WAYS,
    },
    "elastic on rigid in space": {
        "dimension": 3,
        "block": [
            BLOCK | IN_SPACE | {"model": "rigid"},
            TOP | IN_SPACE | {"friction": 0.05, "thickness": 0.6},
        ],
        "foundation": PLATE | ON_ROLLERS | {"thickness": 2.0, "cells": [4, 3, 1]},
        "motion": BOTH_WAYS,
    },
}

#: The one whose fields are written, too: three meshed bodies.
WITH_FIELDS = {"block": [BLOCK, TOP], "foundation": PLATE | ON_ROLLERS}


def run_all(folder: Path, end: float, names: Sequence[str]) -> None:
    """Run scenes up to `end` (s) on the ranks that there are; collective."""
    # Not above: the process that starts mpirun must not be a rank itself.
    from mpi4py import MPI

    from rockslip import parse_scene, simulate

    common = {
        "block": [BLOCK],
        "contact": {"friction": 0.1},
        "motion": SHAKEN,
        "damping": {"stiffness": 0.0},
        "time": {"end": end, "step": 2e-3},
        "output": {"every": 0.06},
    }
    size, rank = MPI.COMM_WORLD.size, MPI.COMM_WORLD.rank
    for name in names:
        result = simulate(parse_scene(common | SCENES[name]))
        if rank == 0:
            assert result.status == "completed", result.summary["reason"]
            assert result.summary["cost"]["ranks"] == size or "rigid" in name
            columns = {column: result.history[column] for column in result.history.columns}
            np.savez(folder / f"{name} {size}.npz", **columns)
    simulate(
        parse_scene(common | WITH_FIELDS | {"time": {"end": 0.06, "step": 2e-3}}),
        folder=folder / f"fields{size}",
    )


def run_on(
    ranks: int, folder: Path, end: float, names: Sequence[str] = tuple(SCENES)
) -> subprocess.CompletedProcess[str]:
    """`run_all` in processes of its own."""
    return on_ranks(ranks, __file__, str(folder), str(end), *names)


UNITS = {"rad": 1.0, "m": WIDTH, "N": WEIGHT, "J": WEIGHT * WIDTH}
"""Units of columns, and the scales that their differences are divided by."""


def differences(folder: Path) -> Iterator[Row]:
    """A row for each scene and number of ranks."""
    for name in SCENES:
        one = np.load(folder / f"{name} 1.npz")
        for ranks in (2, 3):
            many = np.load(folder / f"{name} {ranks}.npz")
            row: Row = {"scene": name, "ranks": ranks, "steps": len(one["time_s"]) - 1}
            for unit, scale in UNITS.items():
                columns = [column for column in one.files if column.endswith(f"_{unit}")]
                apart = max(np.abs(many[column] - one[column]).max() for column in columns)
                row[unit] = f"{apart / scale:.1e}"
            yield row


def main() -> int:
    """Run all, on one, two and three ranks; 0 where every run completed."""
    with TemporaryDirectory() as name:
        for ranks in (1, 2, 3):
            done = run_on(ranks, Path(name), 1.0)
            if done.returncode:
                sys.stderr.write(done.stderr)
                return 1
        write_table(TABLE, differences(Path(name)))
    return 0


if __name__ == "__main__":
    if len(sys.argv) > 1:
        run_all(Path(sys.argv[1]), float(sys.argv[2]), sys.argv[3:])
    else:
        sys.exit(main())
