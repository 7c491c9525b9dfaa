"""Adaptive steps against fixed ones: the third impact of the paper's block.

    ./in-env python3 benchmarks/adaptive_steps.py

Writes `benchmarks/adaptive_steps.csv`, a row a run: the error of the third impact against the
shortest fixed steps, the iterations of all accepted steps and the seconds in the loop. Fixed steps
come near their limit, 0.865 s, only where they resolve the waves of an impact, below 1e-4 s.
Iterations do not depend on what else runs on the machine; seconds do.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from tqdm import tqdm

from benchmarks.rows import write_table
from rockslip import load_scene, simulate

SCENE = Path(__file__).parents[1] / "demos" / "free_rocking" / "scene.toml"
TABLE = Path(__file__).with_suffix(".csv")

END = 0.95
FIXED = (1e-5, 2e-5, 5e-5, 1e-4, 2e-4, 5e-4, 1e-3, 2e-3)
TOLERANCES = (1e-4, 2.5e-4, 1e-3, 4e-3)


def run(kind: str, setting: float) -> dict[str, Any]:
    """One row, without its error."""
    chosen = [f"time.step={setting!r}"]
    if kind == "adaptive":
        chosen = ["time.adaptive=true", f"time.tolerance={setting!r}"]
    changes = [f"time.end={END}", 'output.fields="none"', *chosen]
    summary = simulate(load_scene(SCENE, changes)).summary
    cost = summary["cost"]
    return {
        "steps": kind,
        "setting": f"{setting:g}",
        "third_impact_s": f"{summary['blocks']['block']['impacts'][2]['time_s']:.5f}",
        "number": cost["steps"],
        "rejected": cost["rejected_steps"],
        "iterations": cost["newton_iterations"],
        "loop_s": f"{cost['wall_s']:.2f}",
    }


def main() -> int:
    """Run all settings; the first one is the reference."""
    cases = [("fixed", step) for step in FIXED]
    cases += [("adaptive", tolerance) for tolerance in TOLERANCES]
    rows = [run(*case) for case in tqdm(cases, desc="adaptive steps")]
    exact = float(rows[0]["third_impact_s"])
    for row in rows:
        row["error_s"] = f"{float(row['third_impact_s']) - exact:.5f}"
    write_table(TABLE, rows)
    sys.stdout.write(f"table in {TABLE}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
