"""The tables of a suite: all numbers as CSV, the most important ones as text, means of ratios."""

from __future__ import annotations

import statistics
from collections.abc import Mapping, Sequence
from typing import Any

from solver.results.report import ROUND_OFF
from solver.study import tables
from solver.study.tables import Row, column_names, in_columns

#: Columns of the text: end of the name in the CSV, heading, factor, format; `NAME.` of a block.
SHOWN = (
    ("pga_g", "PGA g", 1.0, ".3f"),
    ("pga_second_g", "along y", 1.0, ".3f"),
    ("pga_vertical_g", "vertical", 1.0, ".3f"),
    ("platform.peak_drift_m", "drift mm", 1e3, ".3f"),
    ("reference.platform.peak_drift_m", "reference", 1e3, ".3f"),
    ("platform.peak_drift_ratio", "ratio", 1.0, ".4f"),
    (".peak_angle_rad", "angle rad", 1.0, ".3g"),
    (".peak_angle_ratio", "ratio", 1.0, ".4f"),
    (".peak_slip_m", "slip mm", 1e3, ".3f"),
    (".peak_slip_ratio", "ratio", 1.0, ".4f"),
    (".residual_slip_m", "residual", 1e3, ".3f"),
    (".mode", "mode", None, ""),
    (".overturned_at_s", "overturned s", 1.0, ".3f"),
    (".fell_at_s", "fell s", 1.0, ".3f"),
    ("wall_s", "wall s", 1.0, ".1f"),
)

MOST_CAUTIONS = 10
"""Cases whose cautions are told; those of all others stand in the table."""


def as_csv(rows: Sequence[Row]) -> str:
    """All numbers with all digits; values that are not known are empty."""
    # The longest row has all columns in their order: one that failed has few.
    return tables.as_csv(rows, column_names(sorted(rows, key=len, reverse=True)))


def as_text(rows: Sequence[Row], varied: Sequence[str], notes: Sequence[str] = ()) -> str:
    """The most important numbers, the means of the ratios, what went wrong, and what is noted."""
    names = column_names(rows)
    there = [key for key in names if any(row.get(key) is not None for row in rows)]
    named = ["motion", *varied, "status"]
    chosen: list[tuple[str, str, float | None, str]] = [(key, key, None, "") for key in named]
    several = len([key for key in there if _is_of_block(key, ".mode")]) > 1
    for key, heading, factor, form in SHOWN:
        for name in there:
            if name == key or _is_of_block(name, key):
                owner = f"{name.split('.')[0]} " if several and key.startswith(".") else ""
                chosen.append((name, owner + heading, factor, form))
    table = [[heading for _, heading, _, _ in chosen]]
    table += [
        [_cell(row.get(key), factor, form) for key, _, factor, form in chosen] for row in rows
    ]
    lines = in_columns(table)
    means = [_sentence(mean, varied) for mean in ratios(rows, varied)]
    lines += ["", *means] if means else []
    lines += remarks(rows, varied) + cautions(rows, varied)
    lines += ["", *notes] if notes else []
    return "\n".join(lines) + "\n"


def ratios(rows: Sequence[Row], varied: Sequence[str]) -> list[dict[str, Any]]:
    """Mean, standard deviation, least and largest of each ratio, for each of the varied values."""
    found = []
    groups = dict.fromkeys(tuple(str(row[key]) for key in varied) for row in rows)
    for group in groups:
        inside = [row for row in rows if tuple(str(row[key]) for key in varied) == group]
        for name in (key for key in column_names(rows) if key.endswith("_ratio")):
            values = [row[name] for row in inside if row.get(name) is not None]
            if values:
                found.append(
                    {
                        "varied": dict(zip(varied, group, strict=True)),
                        "ratio": name,
                        "count": len(values),
                        "mean": statistics.fmean(values),
                        "deviation": statistics.pstdev(values),
                        "least": min(values),
                        "largest": max(values),
                    }
                )
    return found


def _is_of_block(name: str, ending: str) -> bool:
    """Whether a column is a block's own measure."""
    of_others = name.startswith(("reference.", "platform."))
    return ending.startswith(".") and name.endswith(ending) and not of_others


def _cell(value: Any, factor: float | None, form: str) -> str:
    """A value as text; round-off is 0."""
    if value is None:
        return "-"
    if factor is None:
        return str(value)
    shown = format(factor * value, form)
    return shown if abs(factor * value) > ROUND_OFF else format(0.0, form)


def _sentence(mean: Mapping[str, Any], varied: Sequence[str]) -> str:
    """The mean of a ratio in words."""
    group = "".join(f"{key} {mean['varied'][key]}, " for key in varied)
    return (
        f"{group}{mean['ratio']}: mean {mean['mean']:.4f}, deviation {mean['deviation']:.4f}, "
        f"{mean['least']:.4f} to {mean['largest']:.4f}, {mean['count']} motions"
    )


def remarks(rows: Sequence[Row], varied: Sequence[str]) -> list[str]:
    """A line for each case that has a reason."""
    reasons = [row for row in rows if row.get("reason")]
    lines = [f"{_name(row, varied)}: {row['status']}: {row['reason']}" for row in reasons]
    return ["", *lines] if lines else []


def cautions(rows: Sequence[Row], varied: Sequence[str]) -> list[str]:
    """A line for each of the first cases that have cautions."""
    careful = [row for row in rows if row.get("cautions")]
    first = careful[:MOST_CAUTIONS]
    lines = [f"{_name(row, varied)}: caution: {row['cautions']}" for row in first]
    if len(careful) > MOST_CAUTIONS:
        lines.append(f"{len(careful) - MOST_CAUTIONS} more cases have cautions: see suite.csv")
    return ["", *lines] if lines else []


def _name(row: Row, varied: Sequence[str]) -> str:
    """Motion and varied values of a case."""
    return ", ".join([row["motion"], *(f"{key} {row[key]}" for key in varied)])
