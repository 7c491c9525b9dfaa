"""Detect a launcher such as mpirun from the environment, without starting MPI."""

from __future__ import annotations

import os

#: What launchers set to the rank of a process.
VARIABLES = ("OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK", "SLURM_PROCID")


def _rank() -> int | None:
    """The rank that a launcher gave to this process; None without one."""
    for variable in VARIABLES:
        if os.environ.get(variable, "").isdigit():
            return int(os.environ[variable])
    return None


def was_launched() -> bool:
    """True if a launcher started this process, so that there may be other ranks."""
    return _rank() is not None


def launched_rank() -> int:
    """Rank of this process in what was launched; 0 for one that stands alone."""
    return _rank() or 0
