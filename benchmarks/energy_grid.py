"""Energy over a grid of settings: free rocking of the paper's block, 3 s each.

    ./in-env python3 benchmarks/energy_grid.py [--processes 2]

Writes `benchmarks/energy_grid.csv`, one row a run, and ends with exit code 1 where a run gains more
than 1e-5 of the energy scale, its ledger does not close to 1e-8, or it does not complete. The tests
run a short form of it (tests/verification/test_free_rocking.py).
"""

from __future__ import annotations

import itertools
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from benchmarks.rows import processes_wanted, side_by_side, write_table
from rockslip import Scene, load_scene, simulate

SCENE = Path(__file__).parents[1] / "demos" / "free_rocking" / "scene.toml"
TABLE = Path(__file__).with_suffix(".csv")

GRID = {
    "time.rho_inf": (0.0, 0.5, 0.8, 1.0),
    "block.young": (1e6, 1e8, 5e10, 1e12),
    "contact.friction": (0.0, 0.3, 0.7, 10.0),
    "time.step": (2e-4, 1e-3, 2e-3),
}

LARGEST_GAIN = 1e-5
LARGEST_LEDGER_ERROR = 1e-8


def settings() -> Iterator[dict[str, float]]:
    """Every point of the grid."""
    for values in itertools.product(*GRID.values()):
        yield dict(zip(GRID, values, strict=True))


def scene_of(point: dict[str, float]) -> Scene:
    """The scene of the demo with the settings of one point."""
    changes = ["damping.stiffness=0", *(f"{key}={value!r}" for key, value in point.items())]
    return load_scene(SCENE, changes)


def run(point: dict[str, float]) -> dict[str, Any]:
    """One row of the table."""
    summary = simulate(scene_of(point)).summary
    block, energy, cost = summary["blocks"]["block"], summary["energy"], summary["cost"]
    return {
        **point,
        "status": summary["status"],
        "largest_gain_fraction": f"{energy['largest_gain_fraction']:.2e}",
        "ledger_error_fraction": f"{energy['ledger_error_fraction']:.2e}",
        "impacts": len(block["impacts"]),
        "residual_slip_m": f"{block['residual_slip_m']:.2e}",
        "iterations_a_step": f"{cost['newton_iterations'] / cost['steps']:.2f}",
        "rejected_steps": cost["rejected_steps"],
        "rescued": sum(cost["local_problems_rescued"].values()),
    }


def holds(row: dict[str, Any]) -> bool:
    """Whether a run kept what the method promises."""
    return (
        row["status"] == "completed"
        and float(row["largest_gain_fraction"]) < LARGEST_GAIN
        and float(row["ledger_error_fraction"]) < LARGEST_LEDGER_ERROR
    )


def main() -> int:
    """Run the grid; 0 where every run holds."""
    processes = processes_wanted(__doc__)
    rows = write_table(
        TABLE, side_by_side(run, list(settings()), processes=processes, name="energy grid")
    )
    failed = [row for row in rows if not holds(row)]
    sys.stdout.write(f"{len(rows) - len(failed)} of {len(rows)} runs hold; table in {TABLE}\n")
    for row in failed:
        sys.stdout.write(f"does not hold: {row}\n")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
