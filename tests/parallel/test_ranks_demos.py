"""Demos on two ranks."""

from __future__ import annotations

import pytest
from processes import python

FAILS_ON_RANK = """
import sys
from mpi4py import MPI
from demos.program import conclude

def fail_on(rank):
    if MPI.COMM_WORLD.rank == rank:
        raise IndexError("no impact")
    MPI.COMM_WORLD.Barrier()
    return 0

where = sys.argv[1]
work, show = (lambda: None), (lambda made: fail_on(0))
sys.exit(conclude("demo", (lambda: fail_on(1)) if where == "work" else work, show))
"""


@pytest.mark.mpi
@pytest.mark.parametrize("where", ["work", "show"])
def test_an_error_of_a_demo_ends_all_ranks(where: str) -> None:
    """Rank 1 fails while all work, or rank 0 while it shows and the other one waits for it."""
    done = python("-c", FAILS_ON_RANK, where, ranks=2)
    assert done.returncode != 0
    assert "IndexError: no impact" in done.stderr
