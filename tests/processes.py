"""Processes that tests start."""

from __future__ import annotations

import os


def outside_mpirun() -> dict[str, str]:
    """The environment of this process, outside of any mpirun around it.

    What is started with it is not taken for a rank of the run that the test may be part of.
    """
    return {k: v for k, v in os.environ.items() if not k.startswith(("PMIX_", "OMPI_COMM_"))}
