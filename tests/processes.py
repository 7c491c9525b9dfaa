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


def python(
    *words: str | Path, ranks: int = 1, folder: Path | None = None, **environment: str
) -> subprocess.CompletedProcess[str]:
    """Python in a folder, under mpirun where there are several ranks; with its output."""
    launch = ["mpirun", "--oversubscribe", "-n", str(ranks)] if ranks > 1 else []
    return subprocess.run(
        [*launch, sys.executable, *words],
        cwd=folder,
        env=outside_mpirun() | {"PYTHONPATH": str(ROOT)} | environment,
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )


def on_ranks(ranks: int, folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """A command of rockslip in a folder, under mpirun where there are several ranks."""
    return python("-m", "solver", *words, ranks=ranks, folder=folder, OMP_NUM_THREADS="1")


SEVERAL = """
import sys
from solver.cli import main

for name in sys.argv[1:]:
    code = main(["run", f"{name}.toml", "-q", "-o", name])
    if code:
        sys.exit(code)
"""


def runs_on_two_ranks(folder: Path, *names: str) -> None:
    """Run NAME.toml of a folder into its folder NAME, all in one start of two ranks."""
    done = python("-c", SEVERAL, *names, ranks=2, folder=folder, OMP_NUM_THREADS="1")
    assert done.returncode == 0, done.stderr
