"""The tables of the study: all numbers as CSV, the most important ones for reading."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from solver.study.damping.findings import Line, Rows, restitution_of, sentence
from solver.study.damping.restitution import Restitution
from solver.study.damping.sweep import Sweep
from solver.study.tables import as_csv, column_names, in_columns, in_markdown


def rows_of_table(sweep: Sweep, rows: Rows, impacts: int) -> Iterator[dict[str, Any]]:
    """Rows of the table: the scene as it is, then axis by axis."""
    own = {"axis": "", "value": None, **({sweep.at.name: None} if sweep.at else {})}
    yield own | _measured(sweep.base, rows, impacts)
    for swept in sweep.values:
        named = {"axis": swept.axis.name, "value": swept.value}
        if sweep.at is not None:
            named[sweep.at.name] = swept.at
        yield named | _measured(swept.case, rows, impacts)


def _measured(case: str, rows: Rows, impacts: int) -> dict[str, Any]:
    """The columns that come from a run."""
    if case not in rows:
        return {"case": case, "status": "not run"}
    row = rows[case]
    found = restitution_of(row, impacts)
    told: dict[str, Any] = {"case": case, "status": row["status"], "reason": row["reason"]}
    told |= {"cut_short": row["cut_short"]} if row.get("cut_short") else {}
    if found is None:
        return told
    told["reason"] = row["reason"] or found.too_few(row["end_s"])
    told |= measures(found)
    for number, impact in enumerate(row["impacts"][:impacts], start=1):
        told[f"restitution_{number}"] = impact["restitution"]
        told[f"impact_{number}_s"] = impact["time_s"]
    told |= {f"loss.{name}": share for name, share in row["loss_share"].items()}
    for key in ("largest_gain_fraction", "ledger_error_fraction", "steps", "wall_s"):
        told[key] = row[key]
    return told


def measures(found: Restitution) -> dict[str, Any]:
    """Columns of a mean restitution; empty ones where there is none."""
    return {
        "restitution": found.mean,
        "standard_error": found.error if found.known else None,
        "least": min(found.known, default=None),
        "largest": max(found.known, default=None),
        "impacts": len(found.known),
    }


def csv_text(table: Sequence[Mapping[str, Any]]) -> str:
    """All numbers, with eight digits."""
    names = column_names(sorted(table, key=len, reverse=True))
    return as_csv(table, names, digits=8)


def words(table: Sequence[Mapping[str, Any]], sweep: Sweep, impacts: int) -> list[list[str]]:
    """The most important columns as words, the heading first."""
    numbers = range(1, impacts + 1)
    at = [] if sweep.at is None else [sweep.at.name]
    heading = ["axis", "value", *at, "restitution", "± error"]
    heading += [*(f"impact {k}" for k in numbers), "damping", "unresolved", "steps", "wall s"]
    found = [heading]
    for row in table:
        unresolved = _sum(row, "loss.contact", "loss.numerical")
        found.append(
            [
                row["axis"] or "the scene",
                _number(row["value"], "g"),
                *(_number(row.get(key), "g") for key in at),
                _number(row.get("restitution"), ".4f"),
                _number(row.get("standard_error"), ".4f"),
                *(_number(row.get(f"restitution_{k}"), ".4f") for k in numbers),
                _number(row.get("loss.damping"), ".0%"),
                _number(unresolved, ".0%"),
                _number(row.get("steps"), "d"),
                _number(row.get("wall_s"), ".1f"),
            ]
        )
    return found


def _sum(row: Mapping[str, Any], *keys: str) -> float | None:
    """Sum of values, None where they are not known."""
    return sum(row[key] for key in keys) if all(key in row for key in keys) else None


def _number(value: Any, form: str) -> str:
    """A value as text."""
    return "-" if value is None else format(value, form)


def remarks(
    table: Sequence[Mapping[str, Any]], sweep: Sweep, found: Sequence[Line]
) -> Iterator[str]:
    """What the axes show, then what went wrong."""
    for line in found:
        yield sentence(line, sweep.at)
    for row in table:
        if row.get("reason"):
            at = "" if sweep.at is None else f", {sweep.at.name} {_number(row[sweep.at.name], 'g')}"
            name = f"{row['axis']} {row['value']:g}{at}" if row["axis"] else "the scene"
            yield f"{name}: {row['status']}: {row['reason']}"
    for text in sweep.left_out:
        yield f"left out: {text}"


def plain_text(
    cells: Sequence[Sequence[str]], lines: Sequence[str], first: Sequence[str] = ()
) -> str:
    """Table and remarks for a terminal, after what has to be known first."""
    return "\n".join([*first, *in_columns(cells), "", *lines]) + "\n"


def markdown(
    title: str, cells: Sequence[Sequence[str]], lines: Sequence[str], first: Sequence[str] = ()
) -> str:
    """Table and remarks as Markdown, after what has to be known first."""
    listed = [f"- {line}" for line in lines]
    before = [f"# {title}", "", *(text for line in first for text in (line, ""))]
    return "\n".join([*before, *in_markdown(cells), "", *listed]) + "\n"
