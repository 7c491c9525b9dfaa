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
    return _started([*launch, sys.executable, "-m", "solver", *words], folder)


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
    launch = ["mpirun", "--oversubscribe", "-n", "2"]
    done = _started([*launch, sys.executable, "-c", SEVERAL, *names], folder)
    assert done.returncode == 0, done.stderr


def _started(command: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}
    return subprocess.run(
        command,
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
