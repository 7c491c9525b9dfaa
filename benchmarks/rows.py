"""Shared parts of the benchmarks: cases run side by side, each a row of a table."""

from __future__ import annotations

import argparse
import csv
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any, TypeVar

from tqdm import tqdm

Case = TypeVar("Case")
Row = dict[str, Any]


def processes_wanted(description: str | None) -> int:
    """The command line of a benchmark that has no other option."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1)
    processes: int = parser.parse_args().processes
    return processes


def parallel_map(
    run: Callable[[Case], Row], cases: Sequence[Case], *, processes: int, name: str
) -> Iterator[Row]:
    """The rows of all cases in their order, as they come.

    Args:
        run: Of a module, not a lambda: other processes import it.
        cases: What to call it with.
        processes: Number of them.
        name: Beside the bar.
    """
    # MPI, which the solver starts, does not survive a fork.
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
        yield from tqdm(pool.map(run, cases), total=len(cases), desc=name)


def write_table(file: Path, rows: Iterable[Row]) -> list[Row]:
    """Write rows as they come and return them; the file takes its name when it is complete."""
    draft, written = file.with_suffix(".part"), []
    with draft.open("w", newline="", encoding="utf-8") as stream:
        for row in rows:
            if not written:
                writer = csv.DictWriter(stream, fieldnames=list(row))
                writer.writeheader()
            writer.writerow(row)
            stream.flush()
            written.append(row)
    draft.replace(file)
    return written
