"""Numbers of a study of horizons: one row for each run and twin, how fast differences grow."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from solver.study.tables import early_ends, in_columns

Row = Mapping[str, Any]

MOVED = 1e-3
"""Part of alpha that the angle of a block which rocks exceeds."""

NAMES = (
    *("engine", "scale", "end_s", "peak_angle_over_alpha", "overturned"),
    *("perturbation", "horizon_s", "largest_difference"),
)
"""Columns of the table; `horizon_s` is empty where run and twin are the same up to the end."""


def twin_rows(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """One row for each twin."""
    both = (
        {**row, **twin, "engine": row["engine"] or "scene"} for row in rows for twin in row["twins"]
    )
    return [{name: row[name] for name in NAMES} for row in both]


def growth(row: Row) -> float | None:
    """Rate at which differences grow, 1/s: how much earlier larger ones come; None: not known.

    The straight line through the horizons over the logarithms of the perturbations.
    """
    known = [
        (t["horizon_s"], t["perturbation"]) for t in row["twins"] if t["horizon_s"] is not None
    ]
    times = [time for time, _ in known]
    if len(set(times)) < 2:
        return None
    logarithms = [math.log(perturbation) for _, perturbation in known]
    slope = float(np.polyfit(logarithms, times, 1)[0])
    return -1 / slope if slope < 0 else None


def as_text(rows: Sequence[Row]) -> str:
    """Horizons for reading."""
    table = [["engine", "scale", "difference", "horizon s", "largest/alpha", "peak/alpha"]]
    for row in twin_rows(rows):
        until = "none" if row["horizon_s"] is None else f"{row['horizon_s']:.3f}"
        largest = f"{row['largest_difference']:.2g}"
        peak = "overturned" if row["overturned"] else f"{row['peak_angle_over_alpha']:.3f}"
        size = f"{row['perturbation']:g}"
        table.append([row["engine"], f"{row['scale']:g}", size, until, largest, peak])
    lines = [*early_ends(rows), *in_columns(table)]
    if not any(row["overturned"] or row["peak_angle_over_alpha"] > MOVED for row in rows):
        lines.append("no block leaves the ground: a stronger motion may have a horizon")
    for run in rows:
        rate = growth(run)
        if rate is not None:
            name = f"{run['engine'] or 'scene'}, scale {run['scale']:g}"
            lines.append(f"{name}: differences grow by e in {1 / rate:.3g} s")
    return "\n".join(lines) + "\n"
