"""Numbers of a study of overturning: one row for each boundary, and what was compared."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from solver.reference.pulses import half_sine_threshold, one_sine_threshold
from solver.study.overturning.boundaries import DIRECTLY, STAYS
from solver.study.tables import Column, in_columns, in_words

Row = dict[str, Any]

NAMES = (
    *("engine", "pulse", "frequency", "restitution", "amplitude", "below", "above"),
    *("rigid_amplitude", "difference", "linear_threshold"),
)
"""Columns of the table: frequency omega/p, amplitudes over g tan alpha."""

LINEAR = {"half_sine": half_sine_threshold, "one_sine": one_sine_threshold}
"""Thresholds without an impact of a slender, linear block."""


def boundary_rows(rows: Sequence[Mapping[str, Any]], first: float | None) -> list[Row]:
    """One row for each boundary, beside that of the rigid block and of the linear one.

    Args:
        rows: Rows of completed cases.
        first: The restitution of rigid blocks that elastic ones are compared with.
    """
    own = [row for row in rows if row["engine"] == "rigid" and row["restitution"] == first]
    rigid = {(row["pulse"], row["frequency"]): row["boundaries"] for row in own}
    found = []
    for row in rows:
        beside = rigid.get((row["pulse"], row["frequency"]), ()) if row["engine"] != "rigid" else ()
        found += [_boundary(row, edge, beside) for edge in row["boundaries"]]
    return found


def _boundary(
    row: Mapping[str, Any], edge: Mapping[str, Any], beside: Sequence[Mapping[str, Any]]
) -> Row:
    """A boundary, with the nearest of its kind beside it."""
    names = ("engine", "pulse", "frequency", "restitution")
    made = {name: row[name] for name in names} | dict(edge)
    kind = edge["below"], edge["above"]
    if kind == (STAYS, DIRECTLY) and row["pulse"] in LINEAR:
        made["linear_threshold"] = LINEAR[row["pulse"]](row["frequency"])
    same = [e["amplitude"] for e in beside if (e["below"], e["above"]) == kind]
    if same:
        nearest = min(same, key=lambda other: abs(other - edge["amplitude"]))
        made["rigid_amplitude"] = nearest
        made["difference"] = edge["amplitude"] / nearest - 1
    return made


COLUMNS = (
    *(Column("engine", "engine"), Column("pulse", "pulse"), Column("frequency", "omega/p", "g")),
    *(Column("below", "below"), Column("above", "above"), Column("amplitude", "amplitude", ".4f")),
    *(Column("rigid_amplitude", "rigid", ".4f"), Column("difference", "difference", "+.3%")),
)
"""Those of the text."""


def as_text(edges: Sequence[Row]) -> str:
    """The comparisons with elastic blocks as text."""
    compared = [edge for edge in edges if "difference" in edge]
    lines = in_columns(in_words(compared, COLUMNS), left=5) if compared else []
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
