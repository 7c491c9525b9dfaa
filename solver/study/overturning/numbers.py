"""Numbers of a study of overturning: one row for each boundary, and what was compared."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from solver.reference.pulses import half_sine_threshold, one_sine_threshold
from solver.study.overturning.boundaries import DIRECTLY, STAYS
from solver.study.tables import in_columns

Row = dict[str, Any]

NAMES = (
    *("engine", "pulse", "frequency", "restitution", "amplitude", "below", "above"),
    *("rigid_amplitude", "difference", "linear_threshold"),
)
"""Columns of the table: frequency omega/p, amplitudes over g tan alpha."""

LINEAR = {"half_sine": half_sine_threshold, "one_sine": one_sine_threshold}
"""Thresholds without an impact of a slender, linear block."""


def boundary_rows(rows: Sequence[Mapping[str, Any]], first: float | None) -> list[Row]:
    """One row for each boundary.

    Args:
        rows: Rows of completed cases.
        first: The restitution of rigid blocks that elastic ones are compared with.
    """
    rigid = {(r["pulse"], r["frequency"], r["restitution"]): r for r in rows if _rigid(r)}
    found = []
    for row in rows:
        e = first if row["engine"] == "elastic" else row["restitution"]
        beside = rigid.get((row["pulse"], row["frequency"], e))
        found += [_boundary(row, edge, beside) for edge in row["boundaries"]]
    return found


def _rigid(row: Mapping[str, Any]) -> bool:
    return bool(row["engine"] == "rigid")


def _boundary(
    row: Mapping[str, Any], edge: Mapping[str, Any], beside: Mapping[str, Any] | None
) -> Row:
    """A boundary, beside that of the rigid block and of the linear one."""
    made = {name: row[name] for name in ("engine", "pulse", "frequency", "restitution")}
    made |= edge
    direct = (edge["below"], edge["above"]) == (STAYS, DIRECTLY)
    if direct and row["pulse"] in LINEAR:
        made["linear_threshold"] = LINEAR[row["pulse"]](row["frequency"])
    if beside is None or _rigid(row):
        return made
    same = [
        other["amplitude"]
        for other in beside["boundaries"]
        if (other["below"], other["above"]) == (edge["below"], edge["above"])
    ]
    if same:
        nearest = min(same, key=lambda other: abs(other - edge["amplitude"]))
        made["rigid_amplitude"] = nearest
        made["difference"] = edge["amplitude"] / nearest - 1
    return made


def as_text(edges: Sequence[Row]) -> str:
    """The comparisons with other engines as text, and largest differences."""
    table: list[Sequence[str]] = [
        ("engine", "pulse", "omega/p", "below", "above", "amplitude", "rigid", "difference")
    ]
    for edge in (edge for edge in edges if "difference" in edge):
        table.append(
            (
                *(edge["engine"], edge["pulse"], f"{edge['frequency']:g}"),
                *(edge["below"], edge["above"]),
                *(f"{edge['amplitude']:.4f}", f"{edge['rigid_amplitude']:.4f}"),
                f"{100 * edge['difference']:+.3f} %",
            )
        )
    lines = in_columns(table, left=5) if len(table) > 1 else []
    lines.append(f"{sum(edge['engine'] == 'rigid' for edge in edges)} boundaries of rigid blocks")
    return "\n".join(lines) + "\n"


def differences(edges: Sequence[Row]) -> dict[str, float]:
    """Largest relative difference of each other engine from the rigid block."""
    found: dict[str, float] = {}
    for edge in (edge for edge in edges if "difference" in edge):
        engine = edge["engine"]
        found[engine] = max(found.get(engine, 0.0), abs(edge["difference"]))
    return found


def kinds(row: Mapping[str, Any]) -> tuple[str, ...]:
    """Fates from the least amplitude to the largest, in words."""
    edges = row["boundaries"]
    return tuple(edge["below"] for edge in edges) + tuple(edge["above"] for edge in edges[-1:])
