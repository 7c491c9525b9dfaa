"""Processes that tests start."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]


def outside_mpirun() -> dict[str, str]:
    """The environment of this process, outside of any mpirun around it.

    What is started with it is not taken for a rank of the run that the test may be part of.
    """
    return {k: v for k, v in os.environ.items() if not k.startswith(("PMIX_", "OMPI_COMM_"))}


def on_ranks(ranks: int, folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """A command of rockslip in a folder, under mpirun where there are several ranks."""
    launch = ["mpirun", "--oversubscribe", "-n", str(ranks)] if ranks > 1 else []
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}
    return subprocess.run(
        [*launch, sys.executable, "-m", "solver", *words],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
