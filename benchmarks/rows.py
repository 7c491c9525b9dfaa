"""Shared parts of the benchmarks: cases run side by side or on ranks, each a row of a table."""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any, TypeVar

from tqdm import tqdm

from solver.study import tables

Case = TypeVar("Case")
Value = TypeVar("Value")
Row = dict[str, Any]

ROOT = Path(__file__).resolve().parents[1]
DEMO = ROOT / "demos" / "free_rocking" / "scene.toml"
"""The paper's block, released from three degrees."""


def side_by_side(
    run: Callable[[Case], Value], cases: Sequence[Case], about: str | None
) -> Iterator[Value]:
    """What all cases give, in their order, as they come; it reads the command line.

    Args:
        run: Of a module, not a lambda: other processes import it.
        cases: What to call it with.
        about: What the benchmark says of itself.
    """
    parser = argparse.ArgumentParser(
        description=about, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1)
    processes = parser.parse_args().processes
    # MPI, which the solver starts, does not survive a fork.
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
        yield from tqdm(pool.map(run, cases), total=len(cases))


def on_ranks(ranks: int, file: str, *words: str) -> subprocess.CompletedProcess[str]:
    """Run a Python file with these words in processes of its own, on some ranks of this machine."""
    launch = ["mpirun", "--oversubscribe", "-n", str(ranks)] if ranks > 1 else []
    return subprocess.run(
        [*launch, sys.executable, file, *words],
        env={**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        check=False,
    )


def write_table(file: Path, rows: Iterable[Row]) -> None:
    """Write a table whose columns are those of all rows, once it is complete."""
    found = list(rows)
    tables.write(file, tables.as_csv(found, tables.column_names(found)))
    print(f"table in {file}")
