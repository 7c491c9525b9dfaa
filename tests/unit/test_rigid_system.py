"""The system of rigid bodies: what it needs, its state saved and restored."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from rockslip import parse_scene
from solver.rigid.system import RigidSystem

REPOSITORY = Path(__file__).resolve().parents[2]

RUN = """
import sys
from solver.rigid.system import RigidSystem
from solver.scene import parse_scene
block = {"width": 0.25, "height": 1.0, "mass": 503.0, "model": "rigid", "tilt_deg": 3.0}
system = RigidSystem(parse_scene({"block": [block], "time": {"end": 1.0}}))
system.advance(250, 1e-3)
heavy = {"dolfinx", "mpi4py", "petsc4py", "gmsh", "ufl"}
print(sorted(heavy & set(sys.modules)))
"""


def test_rigid_bodies_need_neither_finite_elements_nor_a_compiler() -> None:
    done = subprocess.run(
        [sys.executable, "-c", RUN],
        env=os.environ | {"PYTHONPATH": str(REPOSITORY)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize("dimension", [2, 3])
def test_what_was_restored_goes_on_to_the_digit(dimension: int) -> None:
    """Over impacts and slip of two blocks, one on the other."""
    size = {"width": 0.3, "height": 0.8, "thickness": 0.4, "mass": 200.0, "model": "rigid"}
    blocks = [
        {"name": "lower", **size, "tilt_deg": 4.0, "friction": 0.3},
        {"name": "upper", **size, "on": "lower", "friction": 0.2},
    ]
    tables = {"dimension": dimension, "block": blocks, "time": {"end": 1.0}}
    system = RigidSystem(parse_scene(tables))
    system.advance(100, 1e-3)
    saved = system.saved()
    first = system.advance(300, 1e-3)
    system.resume(saved)
    assert np.array_equal(system.advance(300, 1e-3).rows, first.rows)
    other = RigidSystem(parse_scene(tables))
    other.resume(saved)
    parts = [other.advance(count, 1e-3).rows for count in (1, 99, 200)]
    others = [k for k, name in enumerate(system.columns) if name != "time_s"]  # of sums
    assert np.array_equal(np.concatenate(parts)[:, others], first.rows[:, others])


def test_a_step_that_has_no_solution_keeps_the_rows_before_it() -> None:
    block = {"model": "rigid", "width": 0.25, "height": 1.0, "mass": 503.0}
    system = RigidSystem(parse_scene({"block": [block], "time": {"end": 1.0}}))
    ground = np.zeros((11, 2))
    ground[6, 0] = np.inf
    done = system.advance(10, 1e-3, ground)
    assert len(done.rows) == 5
    assert done.failure == "no solution of a step at 0.005 s"
