"""Sensitivity of a history to its start: blocks released from tilts that hardly differ.

    ./in-env python3 benchmarks/sensitivity.py

Writes `benchmarks/sensitivity.csv`: restitutions of impacts 1 to 4 and times of impacts 2 to 5 with
a fourth of the default tolerance, for tilts that differ by 1e-4 and 1e-3 of themselves. Where these
change the answer by more than a number of steps could, no number of steps can decide it.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tqdm import tqdm

from benchmarks.adaptive_steps import TOLERANCE, answer, scene
from benchmarks.rows import write_table
from rockslip import parse_scene

TABLE = Path(__file__).with_suffix(".csv")

CASES = (("demo", 3e-5), ("demo", 1e-5), ("E 5 GPa", 3e-5), ("on a block", 3e-5))
CHANGES = (0.0, 1e-4, 1e-3)
"""Relative changes of the tilt."""


def rows() -> Iterator[dict[str, Any]]:
    """A row a run."""
    for case, damping in tqdm(CASES, desc="sensitivity"):
        for change in CHANGES:
            made = scene(case, damping)
            made["time"]["tolerance"] = TOLERANCE / 4
            next(block for block in made["block"] if block["name"] == "block")["tilt_deg"] *= (
                1 + change
            )
            found = answer(case, parse_scene(made))
            row = {"case": case, "beta_s": f"{damping:g}", "tilt_changed": f"{change:g}"}
            for k, e in enumerate(found.restitutions):
                row[f"e_{k + 1}"] = f"{e:.4f}"
            for k, time in enumerate(found.times):
                row[f"impact_{k + 2}_s"] = f"{time:.5f}"
            yield row


if __name__ == "__main__":
    write_table(TABLE, rows())
