"""Sliding blocks on everything that can carry them: the same on 1, 2 and 3 ranks.

All scenes run in one process per number of ranks: this file, started by mpirun with a folder.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
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
}

#: The one whose fields are written, too: three meshed bodies.
WITH_FIELDS = {"block": [BLOCK, TOP], "foundation": PLATE | ON_ROLLERS}

LIMITS = {
    "rad": 1e-8,
    "rad_s": 1e-5,
    "m": 1e-8 * WIDTH,
    "m_s": 1e-6,
    "N": 1e-6 * WEIGHT,
    "J": 1e-8 * WEIGHT * WIDTH,
}
"""Velocities and forces come out of differences of displacements over steps of 2 ms."""

AT_THE_BOUND = {"stack in space": 1e-4 * WEIGHT}
"""Limits of forces where the start has points that slip under the weight alone.

The static start finds the directions of their friction to 1e-5.
"""


def run_all(folder: Path) -> None:
    """Run every scene on the ranks that there are; collective."""
    from mpi4py import MPI

    from solver.scene import parse_scene
    from solver.simulate import simulate

    common = {
        "block": [BLOCK],
        "contact": {"friction": 0.1},
        "motion": SHAKEN,
        "time": {"end": 0.12, "step": 2e-3},
        "output": {"every": 0.06},
    }
    size, rank = MPI.COMM_WORLD.size, MPI.COMM_WORLD.rank
    for name, special in SCENES.items():
        result = simulate(parse_scene(common | special))
        if rank == 0:
            assert result.status == "completed", result.summary["reason"]
            assert result.summary["cost"]["ranks"] == size or "rigid" in name
            columns = {column: result.history[column] for column in result.history.columns}
            np.savez(folder / f"{name} {size}.npz", **columns)
    simulate(
        parse_scene(common | WITH_FIELDS | {"time": {"end": 0.06, "step": 2e-3}}),
        folder=folder / f"fields{size}",
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Holds the histories on 1, 2 and 3 ranks."""
    folder = tmp_path_factory.mktemp("ranks")
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}
    for ranks in (1, 2, 3):
        launch = ["mpirun", "--oversubscribe", "-n", str(ranks)] if ranks > 1 else []
        done = subprocess.run(
            [*launch, sys.executable, __file__, str(folder)],
            env=environment,
            capture_output=True,
            text=True,
            timeout=600,
            check=False,
        )
        assert done.returncode == 0, done.stderr
    return folder


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [2, 3])
@pytest.mark.parametrize("name", list(SCENES))
def test_histories_agree(folder: Path, name: str, ranks: int) -> None:
    """Every column: kinematics to 1e-8 of the block's width, forces to 1e-6 of its weight."""
    one, many = (np.load(folder / f"{name} {number}.npz") for number in (1, ranks))
    assert set(one.files) == set(many.files)
    assert len(one["time_s"]) == len(many["time_s"]) == 61
    slid = "top.slip_m" if "top.slip_m" in one.files else "block.slip_m"
    assert np.abs(one[slid]).max() > 1e-3
    checked = 0
    for column in one.files:
        unit = next((unit for unit in LIMITS if column.endswith(f"_{unit}")), None)
        if unit is not None:
            limit = AT_THE_BOUND.get(name, LIMITS[unit]) if unit == "N" else LIMITS[unit]
            assert many[column] == pytest.approx(one[column], abs=limit), column
            checked += 1
    assert checked > 15


@pytest.mark.mpi
@pytest.mark.parametrize("part", ["block", "top", "plate"])
def test_fields_of_several_parts_agree(folder: Path, part: str) -> None:
    """Displacement and contact pressure of each body, read back and ordered by place."""
    import pyvista

    ends = []
    for ranks in (1, 2, 3):
        reader = pyvista.get_reader(folder / f"fields{ranks}" / f"fields_{part}.pvd")
        reader.set_active_time_value(0.06)
        data = reader.read().combine()
        # A node on the border of two ranks stands in the files of both.
        _, first = np.unique(np.round(data.points, 9), axis=0, return_index=True)
        ends.append(
            (data.points[first], data["displacement"][first], data["contact_pressure"][first])
        )
    for many in ends[1:]:
        assert many[0] == pytest.approx(ends[0][0], abs=1e-12)
        assert many[1] == pytest.approx(ends[0][1], abs=1e-9)
        assert many[2] == pytest.approx(ends[0][2], abs=1e-5 * WEIGHT)
    assert np.ptp(ends[0][1], axis=0).max() > 0


if __name__ == "__main__":
    run_all(Path(sys.argv[1]))
