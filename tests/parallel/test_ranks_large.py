"""Large bodies on two ranks: factorized by each rank, or by MUMPS."""

from __future__ import annotations

import json

import numpy as np
import pytest
from processes import python

RUNS = """
import json
from mpi4py import MPI
from rockslip import parse_scene, simulate
from solver.bodies import factorization

block = dict(width=1.0, height=1.6, thickness=0.8, mass=1000.0, young=5e8, poisson=0.2)
block |= dict(cells=[3, 3, 5], tilt_deg=0.3)
scene = dict(dimension=3, block=[block], contact=dict(friction=0.4), output=dict(fields="none"))
scene["time"] = dict(end=0.04, step=2e-3)
found = []
for redundant in (10**6, 0):
    factorization.REDUNDANT_UNKNOWNS = redundant
    result = simulate(parse_scene(scene))
    names = [name for name in result.history.columns if name.endswith(("_m", "_rad"))]
    rows = [list(map(float, result.history[name])) for name in names]
    found.append((result.summary["cost"]["linear_solvers"], result.status, rows))
if MPI.COMM_WORLD.rank == 0:
    print(json.dumps(found))
"""


@pytest.mark.mpi
def test_each_rank_solves_as_mumps_does() -> None:
    """The same history to round-off, which one landing multiplies."""
    done = python("-c", RUNS, ranks=2, OMP_NUM_THREADS="1")
    assert done.returncode == 0, done.stderr
    each, mumps = json.loads(done.stdout.splitlines()[-1])
    assert [each[0], mumps[0]] == [["CHOLMOD"], ["MUMPS"]]
    assert mumps[1] == each[1] == "completed"
    np.testing.assert_allclose(mumps[2], each[2], rtol=0, atol=1e-11)
